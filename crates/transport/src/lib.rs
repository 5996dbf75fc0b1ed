//! Light transport inside matter: where light that enters a body leaves it again, and in which directions.
//!
//! The kernel answers for plane layers ([`kernel::solve`]), for the surface of a body, point by point, and for films
//! over something ([`kernel::film_stack`]): Gaussians over path length, from tables that were measured once. It is what
//! datasets are rendered with. The models that it is held to (Monte Carlo, diffusion, and the method of the thesis)
//! answer the same questions, a [`stack::Stack`] and an [`answer::Question`], in the crate `reference`.
//!
//! [`stack`] is matter in plane layers and [`answer`] what is said of it; [`line`] is a line of light on a body;
//! [`fresnel`] has the laws that all models share. docs/theory/physics.md has the equations, their
//! sources and where each model fails.

pub mod answer;
pub mod fresnel;
pub mod kernel;
pub mod line;
pub mod stack;
