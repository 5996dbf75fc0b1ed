//! What a recipe says is drawn, or refused with its line, its key and its remedy.

mod alternatives;
mod camera;
mod draws;
mod effects;
mod extends;
mod faults;
mod motion;
mod presets;
mod settings;
mod subjects;
mod support;
mod thesis;
mod transport;
