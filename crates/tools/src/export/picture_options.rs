//! Options of exports that write pictures: what these show, and the ends of their grey scales.

use clap::{Args, ValueEnum};

// Options of exports that write pictures; a documentation comment would become the help of each of them.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct PictureOptions {
    /// What pictures show; rgb is Range, Reflectance and Scatter as red, green and blue
    #[arg(long, value_enum, default_value_t = PictureContent::Reflectance)]
    pub image: PictureContent,
    /// Heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
    #[arg(long, value_name = "LOW,HIGH", value_parser = ends, allow_hyphen_values = true)]
    pub range_ends: Option<[f64; 2]>,
    /// Scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
    #[arg(long, value_name = "LOW,HIGH", value_parser = ends)]
    pub scatter_ends: Option<[f64; 2]>,
}

impl PictureOptions {
    /// Refuses ends of maps that are not shown.
    pub(super) fn check(&self) -> Result<(), String> {
        let shown = self.image.maps();
        for (map, given) in [("range", self.range_ends), ("scatter", self.scatter_ends)] {
            if given.is_some() && !shown.contains(&map) {
                return Err(format!(
                    "--{map}-ends has no effect without --image {map} or rgb; give one of them, or leave it away"
                ));
            }
        }
        Ok(())
    }
}

/// Two numbers, the lower first.
fn ends(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let ends = text.split_once(',').and_then(|(low, high)| Some([number(low)?, number(high)?]));
    ends.filter(|[low, high]| low < high).ok_or_else(|| format!("'{text}' is not LOW,HIGH, for instance 10,30"))
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum PictureContent {
    // Brightness at the peak.
    Reflectance,
    // Light beside the peak.
    Scatter,
    // Light of lamps.
    Grey,
    // Height.
    Range,
    // Range, Reflectance and Scatter as red, green and blue.
    Rgb,
}

impl PictureContent {
    /// The maps that it takes, in the order of channels.
    pub fn maps(self) -> &'static [&'static str] {
        match self {
            Self::Reflectance => &["reflectance"],
            Self::Scatter => &["scatter"],
            Self::Grey => &["grey"],
            Self::Range => &["range"],
            Self::Rgb => &["range", "reflectance", "scatter"],
        }
    }

    /// Name of the choice.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgb => "rgb",
            one => one.maps()[0],
        }
    }
}
