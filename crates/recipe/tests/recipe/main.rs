//! What a recipe says is drawn, or refused with its line, its key and its remedy.

mod alternatives;
mod camera;
mod draws;
mod effects;
mod faults;
mod motion;
mod settings;
mod subjects;
mod support;
mod thesis;
mod transport;
