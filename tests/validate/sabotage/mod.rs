//! Damage of every kind to datasets that the program made: each is reported as that fault, and a clean dataset has
//! none.
//!
//! `SABOTAGE_SEEDS=20 cargo test --release --workspace --test validate -- --nocapture` prints, as lines of `share`, of
//! how many fresh choices of rows each damage is told at the default `--rows`. Whatever a test here asks of `inspect`,
//! `with` or `after` is told without any row, so always. Choices decide about what agrees with all that follows
//! without light:
//!
//! | damage | told of 20 |
//! |---|---|
//! | one sample a copy of another: as it is, with up to 1 DN more or less, a tenth darker, mirrored | 20 |
//! | Range three millimetres higher; Scatter one number brighter | 20 |
//! | all kept sensor frames of a sample turned, of another one, in another order, one pixel one number brighter | 20 |
//! | a block of 25 % of the rows lost in all measured maps | 20 |
//! | every tenth row one number darker | 16 |
//! | a pixel, in 2 % of the rows | 4 |

mod bodies;
mod clean;
mod clean_sweep;
mod columns;
mod content;
mod copies;
mod documents;
mod files;
mod flips;
mod forgeries;
mod frames;
mod place;
mod review;
mod tags;
mod truth;
mod useless;
