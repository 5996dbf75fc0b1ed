//! Boards, packs and solid pieces from outside.

mod blister;
mod blister_truth;
mod board;
mod boards;
mod extremes;
mod fine_structure;
mod gran_1;
mod knots;
mod saw_teeth;
mod solid;
mod stem;
mod stem_statistics;
mod wood_defects;
