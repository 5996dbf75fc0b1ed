//! `gen` as its users run it: datasets, studies, questions, faults.

mod bits;
mod channels;
mod commands;
mod cover;
mod determinism;
mod engines;
mod faults;
mod files;
mod fit;
mod named_files;
mod options;
mod output;
mod progress;
mod range;
mod red_team;
mod rig_check;
mod rig_mistakes;
mod study;
mod symptoms;
mod thesis_frames;
mod transport;
mod tune;
mod variation;
