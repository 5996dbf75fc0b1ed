//! Shares of a sample: how much of its object is measured, saturated and in view, and from where on it is of little
//! use.
//!
//! The limits are far from what a recipe may mean, so that what falls short is useless as a whole: dark knots and bark,
//! shadows, clear film and scans that are overexposed on purpose stay within them. Over the shipped recipes, samples
//! reach down to the figures that docs/guide/faults.md lists.

use base::{Class, words};

use crate::record::{Labels, Maps};

/// Least share of the object's pixels in which Range is measured: shadows, glints and dark parts of shipped recipes
/// leave 0.89 [1].
pub const LEAST_MEASURED: f64 = 0.1;
/// Least share of the pixels that show sound matter in which Range is measured: what laser, camera and extraction do to
/// matter as it should be is the rig's doing, while holes and dark knots are what samples show. Shipped recipes reach
/// down to 0.9, packs by the walls of their pockets [1].
pub const LEAST_SOUND: f64 = 0.8;
/// Share of the object's pixels below which those of sound matter tell nothing of the rig [1].
pub const FEW_SOUND: f64 = 0.1;
/// Share of the object's measured pixels from which on they count as saturated as a whole: packs at the longest
/// exposure that their recipe draws reach 0.94, at sixty times the usual light 0.96 to 0.98, boards 1 [1].
pub const MOST_SATURATED: f64 = 0.95;
/// Least share of the object's outline that lies in the field: of the longest shipped piece, the saw-tooth of the
/// thesis, a fifth stands out on purpose, and of a card that lies half outside half [1].
pub const LEAST_IN_VIEW: f64 = 2.0 / 3.0;

/// How much of a sample is of use; NaN where a share has no meaning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleShares {
    /// Share of the object's pixels in which Range is measured; NaN where no pixel shows the object [1].
    pub measured: f64,
    /// Share of the pixels of sound matter in which Range is measured; NaN where hardly any shows it, or where that is
    /// not known [1].
    pub sound: f64,
    /// Share of the object's measured pixels in which the line saturates; NaN where there are none [1].
    pub saturated: f64,
    /// Share of the object's outline that lies in the field; NaN on a turntable [1].
    pub in_view: f64,
}

words! {
    /// What makes a sample of little use, by its code in documents and reports.
    #[derive(PartialOrd, Ord)]
    Shortfall {
        /// Less of the object than [`LEAST_IN_VIEW`] lies in the field, or no pixel shows it.
        ObjectOutOfView = "object-out-of-view",
        /// Range is measured in less of the object than [`LEAST_MEASURED`].
        HardlyMeasured = "hardly-measured",
        /// Range is measured in less of sound matter than [`LEAST_SOUND`].
        PartlyMeasured = "partly-measured",
        /// The line saturates in [`MOST_SATURATED`] of what is measured of the object, or more.
        Saturated = "saturated",
    }
}

impl Shortfall {
    /// What to do, where no more is known.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::ObjectOutOfView => {
                "bring the object into the field by its offset_mm, lead_in_mm and size, or enlarge the field by \
                    scan.columns, \
                 scan.profiles, motion.step_mm or camera.distance_mm"
            }
            Self::HardlyMeasured => {
                "see `gen rig`: where the object is higher than the sensor sees, raise camera.rows or \
                    camera.distance_mm; where \
                 the line is wide, bring it into focus; else raise exposure.time_us or laser.power_mw"
            }
            Self::PartlyMeasured => {
                "see `gen rig`: where the fan ends on the object, widen it by laser.fan_angle_deg; where the object \
                    is higher than \
                 the sensor sees, raise camera.rows; where it hides itself, lower camera.tilt_deg; where the line is \
                 wide, bring it \
                 into focus; where it is too dark or too bright, set exposure.time_us, laser.power_mw or \
                 extraction.threshold_dn"
            }
            Self::Saturated => "shorten exposure.time_us or lower laser.power_mw",
        }
    }
}

impl SampleShares {
    /// Of measured maps and labels on one grid; `most` is the greatest digital number [DN].
    pub fn of(maps: &Maps, labels: &Labels, most: u16, in_view: f64) -> Self {
        let pixels = labels.class.iter().zip(maps.range.iter().zip(&maps.reflectance));
        let marks = |(class, (range, dn)): (&u8, (&f32, &f32))| {
            (u16::from(*class), [!range.is_nan(), dn.round() >= f32::from(most)])
        };
        let [measured, sound, saturated] = ObjectPixels::count(pixels.map(marks)).shares();
        Self { measured, sound, saturated, in_view }
    }

    /// In what the sample falls short.
    pub fn shortfalls(&self) -> Vec<Shortfall> {
        let falls_short = |shortfall: &Shortfall| match shortfall {
            Shortfall::ObjectOutOfView => self.measured.is_nan() || self.in_view < LEAST_IN_VIEW,
            Shortfall::HardlyMeasured => self.measured < LEAST_MEASURED,
            Shortfall::PartlyMeasured => self.measured >= LEAST_MEASURED && self.sound < LEAST_SOUND,
            Shortfall::Saturated => self.saturated >= MOST_SATURATED,
        };
        Shortfall::ALL.into_iter().filter(falls_short).collect()
    }

    /// A shortfall of this sample in words.
    pub fn describe(&self, shortfall: Shortfall) -> String {
        let percent = |share: f64| {
            let percent = 100.0 * share;
            // More digits where one would read as none.
            let digits = if percent > 0.0 { (-libm::log10(percent).floor()).clamp(1.0, 9.0) as usize } else { 1 };
            format!("{percent:.digits$} %")
        };
        match shortfall {
            Shortfall::ObjectOutOfView if self.measured.is_nan() => "no pixel shows the object".into(),
            Shortfall::ObjectOutOfView => {
                let (share, least) = (percent(self.in_view), percent(LEAST_IN_VIEW));
                format!("{share} of the object lies in the field of the images, less than {least}")
            }
            Shortfall::HardlyMeasured => {
                let (share, least) = (percent(self.measured), percent(LEAST_MEASURED));
                format!("Range is measured in {share} of the pixels that show the object, less than {least}")
            }
            Shortfall::PartlyMeasured => {
                let (share, least) = (percent(self.sound), percent(LEAST_SOUND));
                format!("Range is measured in {share} of the pixels that show matter without defect, less than {least}")
            }
            Shortfall::Saturated => {
                let (share, most) = (percent(self.saturated), percent(MOST_SATURATED));
                format!("the line saturates in {share} of the object's measured pixels, {most} or more")
            }
        }
    }
}

/// Pixels that show the object, and what is found on them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ObjectPixels {
    /// All of them.
    pub all: u64,
    /// Those in which Range is measured.
    pub measured: u64,
    /// Those of sound matter, and how many of these are measured.
    pub sound: [u64; 2],
    /// Those of the measured ones in which the line saturates.
    pub saturated: u64,
}

impl ObjectPixels {
    /// Counts the pixels of a label that show the object, each with whether it is measured and whether its number is
    /// the greatest.
    pub(crate) fn count(pixels: impl Iterator<Item = (u16, [bool; 2])>) -> Self {
        let is_sound = Class::ALL.map(Class::is_sound);
        let mut found = Self::default();
        for (class, [measured, greatest]) in pixels.filter(|(class, _)| *class != Class::Background as u16) {
            let sound = is_sound.get(usize::from(class)).is_some_and(|sound| *sound);
            found.all += 1;
            found.measured += u64::from(measured);
            found.sound[0] += u64::from(sound);
            found.sound[1] += u64::from(sound & measured);
            found.saturated += u64::from(measured & greatest);
        }
        found
    }

    /// The measured share, that of sound matter, and the saturated one of what is measured; NaN where there are no
    /// pixels [1].
    pub(crate) fn shares(self) -> [f64; 3] {
        let share = |part: u64, all: u64| if all == 0 { f64::NAN } else { part as f64 / all as f64 };
        let [sound, measured] = self.sound;
        let of_sound = if share(sound, self.all) < FEW_SOUND { f64::NAN } else { share(measured, sound) };
        [share(self.measured, self.all), of_sound, share(self.saturated, self.measured)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels of the background beside four of the object: three measured, one of these at the greatest number.
    #[test]
    fn shares_are_of_the_object() {
        let nan = f32::NAN;
        let maps = Maps {
            range: vec![1.0, nan, 1.0, 2.0, nan, 3.0],
            reflectance: vec![255.0, 0.0, 254.4, 254.6, 0.0, 90.0],
            scatter: vec![0.0; 6],
            grey: Vec::new(),
        };
        let labels = Labels { class: vec![0, 0, 1, 1, 3, 1], instance: vec![0; 6] };
        let shares = SampleShares::of(&maps, &labels, 255, 1.0);
        assert_eq!((shares.measured, shares.sound, shares.saturated), (0.75, 1.0, 1.0 / 3.0));
        assert_eq!((shares.in_view, shares.shortfalls()), (1.0, vec![]));
        let none = SampleShares::of(&maps, &Labels { class: vec![0; 6], ..labels }, 255, 0.0);
        assert!(none.measured.is_nan() && none.saturated.is_nan());
        assert_eq!(none.shortfalls(), [Shortfall::ObjectOutOfView]);
        assert_eq!(none.describe(Shortfall::ObjectOutOfView), "no pixel shows the object");
    }

    #[test]
    fn limits_are_told_with_what_was_found() {
        let shares = SampleShares { measured: 0.0004, sound: 0.0004, saturated: 0.97, in_view: 0.5 };
        let hardly = [Shortfall::ObjectOutOfView, Shortfall::HardlyMeasured, Shortfall::Saturated];
        assert_eq!(shares.shortfalls(), hardly);
        let told = hardly.map(|shortfall| shares.describe(shortfall));
        assert!(told[0].starts_with("50.0 %") && told[1].contains("0.04 %") && told[2].contains("97.0 %"), "{told:?}");
        // What is told of the whole object is not told of its sound matter again.
        let partly = SampleShares { measured: 0.35, sound: 0.4, saturated: 0.0, in_view: 1.0 };
        assert_eq!(partly.shortfalls(), [Shortfall::PartlyMeasured]);
        assert!(partly.describe(Shortfall::PartlyMeasured).contains(" 40.0 % "));
        // A share without meaning is no shortfall.
        let turned = SampleShares { measured: 1.0, sound: 1.0, saturated: 0.0, in_view: f64::NAN };
        assert_eq!(turned.shortfalls(), []);
    }

    /// Holes and dark knots are what samples show: only matter without defect tells of the rig, where there is enough
    /// of it.
    #[test]
    fn defects_that_are_not_measured_are_no_shortfall() {
        let shares = |sound: usize, hole: usize| {
            let all = sound + hole;
            let range = [vec![1.0; sound], vec![f32::NAN; hole]].concat();
            let maps = Maps { range, reflectance: vec![100.0; all], scatter: vec![0.0; all], grey: Vec::new() };
            let class = [vec![Class::Clear as u8; sound], vec![Class::KnotHole as u8; hole]].concat();
            SampleShares::of(&maps, &Labels { class, instance: vec![0; all] }, 255, 1.0)
        };
        assert_eq!((shares(6, 4).measured, shares(6, 4).sound), (0.6, 1.0));
        assert_eq!(shares(6, 4).shortfalls(), []);
        assert!(shares(1, 11).sound.is_nan());
    }
}
