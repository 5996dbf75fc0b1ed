//! Boards, packs and solid pieces from outside.

mod blister;
mod blister_truth;
mod board;
mod boards;
mod extremes;
mod knots;
mod solid;
mod wood_defects;
