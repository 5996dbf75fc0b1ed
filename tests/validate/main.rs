//! Validation reports each damage as that damage, and a clean dataset has none.

mod bombs;
mod clean;
mod command;
mod content;
mod damage;
mod damaged;
mod docs;
mod files;
mod rows;
mod sabotage;
mod texts;
