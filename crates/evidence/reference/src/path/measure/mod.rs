//! Monte Carlo measurements behind the production kernel's tables: films and half spaces without absorption.
//!
//! The layout of the tables is the kernel's ([`kernel::table`](transport::kernel::table),
//! [`kernel::film_stack::table`](transport::kernel::film_stack::table)); what is walked to fill them, and how the
//! measurements become entries, stands here. `examples/kernel_table.rs` and `examples/film_table.rs` write the tables.

pub mod film;
pub mod half_space;
