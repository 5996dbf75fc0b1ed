//! Files of the real camera, written, read, and refused where they are damaged.

mod faults;
mod round_trips;
mod scans;
