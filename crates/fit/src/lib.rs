//! Fitting a recipe to scans of a real camera: simulation-based inference over the summary statistics of scans; and
//! whether a recipe's scans cover real ones (`cover`).
//!
//! ```text
//! recipe -> keys with priors -> scores -> simulated scans -> statistics --.
//! real scans -> statistics, spreads of halves ----------------------------+-> Emulator -> Posterior
//!                                                       Posterior -> scores of the next round
//!                                                                 '-> Fit: keys, statistics, misfit
//! ```
//!
//! The first round draws scores from the prior, that is, from the recipe's own distributions; each further round draws
//! them from the posterior so far, widened by a half, with a tenth from the prior. The posterior at the end is checked
//! on simulated scans whose scores are known, and widened where they scatter more than it says (`rounds`).
//! docs/theory/fitting.md has the equations and sources.

mod cover;
mod emulator;
mod observation;
mod page;
mod posterior;
mod prior;
mod result;
mod rounds;
mod simulator;
mod store;

pub use cover::{Cover, CoverOptions, CoverProgress, CoveredScan, CoveredStatistic, cover};
pub use observation::RealScan;
pub use prior::{FitKey, fit_keys};
pub use result::{Fit, FittedKey, FittedMatter, KeyState, MapsOfScan, ScanFit, StatisticFit};
pub use rounds::{FitOptions, FitProgress, fit};
