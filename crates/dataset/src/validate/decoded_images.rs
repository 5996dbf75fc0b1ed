//! The images of a sample as numbers: of its row, and of its EXR file.

use output_schema::row::IMAGES;

use crate::ExrChannel;

/// Decoded images by name.
#[derive(Debug, Default)]
pub(super) struct DecodedImages(Vec<(String, Vec<u16>)>);

impl DecodedImages {
    /// Numbers of an image, row-major.
    pub(super) fn get(&self, name: &str) -> Option<&[u16]> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, numbers)| numbers.as_slice())
    }

    /// Adds an image.
    pub(super) fn add(&mut self, name: String, numbers: Vec<u16>) {
        self.0.push((name, numbers));
    }

    /// Adds the channels of an EXR file of which the row has no image, as the image of that name would have them;
    /// `scale` is what the number 0 of Range means and what a step is [mm or px].
    pub(super) fn add_channels(&mut self, channels: &[ExrChannel], scale: [f64; 2]) {
        for channel in channels {
            let name = image_of_channel(&channel.name);
            if !IMAGES.contains(&name.as_str()) || self.get(&name).is_some() {
                continue;
            }
            let numbers = &channel.numbers;
            let height = |z: f32| ((f64::from(z) - scale[0]) / scale[1]).round().clamp(1.0, 65535.0);
            let numbers: Vec<u16> = match name.as_str() {
                "range" => numbers.iter().map(|&z| if z.is_nan() { 0 } else { height(z) as u16 }).collect(),
                "label" | "instance" => numbers.iter().map(|&n| n as u16).collect(),
                _ => numbers.iter().map(|n| n.round() as u16).collect(),
            };
            self.add(name, numbers);
        }
    }
}

/// Name of the image that repeats a channel of an EXR file.
pub(super) fn image_of_channel(channel: &str) -> String {
    if channel == "Y" { "reflectance".into() } else { channel.to_lowercase() }
}
