//! The door to the evidence: all that the program knows of what the product is held to. No crate of the product depends
//! on it; `src` asks it where a command or a recipe names what lies behind.
//!
//! | behind it | who asks |
//! |---|---|
//! | [`study`] | `gen study` |
//! | [`reference`] | `gen transport`; [`reference::line_solver`] for `transport: path`, `diffusion` and `thesis` in recipes |
//! | [`gap`] | `gen compare --gap` |

pub use gap;
pub use reference;
pub use study;
