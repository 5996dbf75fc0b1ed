//! Sheetlight.
pub mod frame;
pub mod optics {
    //! Optics.
    pub mod parameters;
}
pub mod recipe;
pub mod record;
pub mod settings;
