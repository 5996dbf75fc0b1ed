//! Pixel classes as colours, the same in every picture.

use image::Rgb;
use procedural::Class;

/// Colour of a pixel class: calm where all is well, and far from its neighbours where it is not.
pub fn class_colour(class: u8) -> Rgb<u8> {
    Rgb(match Class::ALL.get(usize::from(class)) {
        Some(Class::Background) | None => [40, 44, 52],
        Some(Class::Clear) => [222, 196, 150],
        Some(Class::SoundKnot) => [214, 96, 30],
        Some(Class::DeadKnot) => [70, 36, 20],
        Some(Class::Rot) => [74, 128, 92],
        Some(Class::Flange) => [206, 210, 214],
        Some(Class::Pocket) => [146, 168, 188],
        Some(Class::Missing) => [228, 26, 28],
        Some(Class::Broken) => [255, 127, 0],
        Some(Class::Chipped) => [255, 190, 60],
        Some(Class::Cracked) => [150, 80, 30],
        Some(Class::Capped) => [250, 235, 90],
        Some(Class::ForeignTablet) => [152, 78, 163],
        Some(Class::WrongCoat) => [247, 129, 191],
        Some(Class::Double) => [88, 50, 150],
        Some(Class::Particle) => [0, 0, 0],
        Some(Class::Fibre) => [0, 90, 40],
        Some(Class::Powder) => [255, 250, 205],
        Some(Class::Shallow) => [0, 114, 178],
        Some(Class::Collapsed) => [86, 210, 233],
        Some(Class::Punctured) => [0, 40, 255],
        Some(Class::Pinhole) => [255, 0, 255],
        Some(Class::Channel) => [0, 200, 110],
        Some(Class::Wrinkle) => [150, 220, 50],
        Some(Class::Delamination) => [0, 128, 128],
        Some(Class::TabletOnFlange) => [130, 0, 60],
        Some(Class::Tooth) => [120, 160, 200],
        Some(Class::Object) => [200, 170, 90],
    })
}
