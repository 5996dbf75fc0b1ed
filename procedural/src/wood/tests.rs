//! Tests of the parts together that need to see inside a board.

use super::*;
