//! Lets the linker leave Python's own symbols open, as macOS asks to be told.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
