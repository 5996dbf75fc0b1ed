//! What the kernel is asked: a film over something goes to the adding method, a half space to the table's Gaussians.

use super::film_stack;
use super::half_space::{self, KernelError};
use crate::answer::{Answer, Question};
use crate::stack::{Stack, Substrate};

/// Asks the kernel about `stack`.
///
/// # Errors
/// Whatever its tables were not made for.
pub fn solve(stack: &Stack, question: &Question) -> Result<Answer, KernelError> {
    if stack.layers.len() > 1 || matches!(stack.below, Substrate::Foil(_)) {
        film_stack::solve(stack, question)
    } else {
        half_space::solve(stack, question)
    }
}
