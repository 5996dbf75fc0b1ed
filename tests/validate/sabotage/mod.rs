//! Damage of every kind to datasets that the program made: each is reported as that fault, and a clean dataset has
//! none.
//!
//! What a rule tells without rows that are exposed again (`inspect`, `with`, `after`) is told whatever rows are chosen.
//! Choices decide about what agrees with all that follows without light. Of 20 choices at the default `--rows`:
//!
//! | damage | told of 20 |
//! |---|---|
//! | files gone, cut, swapped, flipped or too many; documents, manifests, card | 20 |
//! | rows and columns of tables, headers, channels, depths and units of images | 20 |
//! | labels, instances, masks by a pixel, objects, lists of classes, areas, shares | 20 |
//! | truth maps of every subject: zeroed, mirrored, moved, scaled | 20 |
//! | a sample a copy of another: as it is, with up to 1 DN more or less, a tenth darker, mirrored | 20 |
//! | frames left out, blank, repeated, in another order | 20 |
//! | Range, Reflectance or Scatter of a whole sample, of every subject, in eight ways | 20 |
//! | all frames of a sample, of every subject: turned, of another one, in another order, a pixel one number brighter | 20 |
//! | one frame of twelve, of every subject, in thirty ways | 20 |
//! | a block of 25 % of the rows lost in all measured maps, of every subject | 20 |
//! | every tenth row one number darker, of boards, packs, saw-teeth and parts | 14, 20, 14, 15 |
//! | a pixel, in 2 % of the rows, of packs in 1 % | 6, 0, 1, 2 |
//!
//! `SABOTAGE_SEEDS=20 cargo test --release --workspace --test validate sabotage:: -- --include-ignored --nocapture`
//! validates each damage with 20 fresh choices, which all must tell it, and prints of how many they do as lines of
//! `share`. Without it forgeries of maps have two, of frames one, and parts of maps the 20 of the table.

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
