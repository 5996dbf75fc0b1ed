//! What is read from frames alone, without bodies or light: lines, windows, methods, forms of Range.

mod by_hand;
mod columns;
mod methods;
mod pack_windows;
mod range_forms;
