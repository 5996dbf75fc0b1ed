//! Real scans as they are fitted: what of them counts, their statistics, and how far halves of one scan lie apart.

use dataset::Fault;
use tools::compare::summary::{SummaryStatistic, summary};
use tools::compare::{RangeUnit, ScanMaps, ScanMask, ScanRegion};

/// Fewest pixels with a height.
const FEWEST_HEIGHTS: usize = 2000;
/// Fewest profiles and columns.
const FEWEST_LINES: usize = 32;
/// Share of saturated pixels from which a scan says nothing of light.
const MOST_SATURATED: f64 = 0.995;
/// Largest relative difference of pitches that is taken for the same geometry.
const SAME_PITCH: f64 = 0.02;

/// A real scan with its statistics.
#[derive(Debug, Clone)]
pub struct RealScan {
    /// The part of it that is fitted.
    pub maps: ScanMaps,
    /// Pixels that don't count; `None` where the whole scan does.
    pub ignored: Option<Vec<bool>>,
    /// Its statistics.
    pub statistics: Vec<SummaryStatistic>,
    /// Standard error of each, in the scale of its law, from halves of the scan; `None` where halves don't tell it.
    pub spreads: Vec<Option<f64>>,
}

/// The geometry of simulated scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapGeometry {
    /// Distance between columns and between profiles [mm].
    pub pitch_mm: [f64; 2],
    /// Whether heights are sensor rows.
    pub is_uncalibrated: bool,
}

impl RealScan {
    /// A scan, or the part of it that counts.
    ///
    /// # Errors
    /// Where it is of no use: with the reason and the remedy.
    pub fn new(mut maps: ScanMaps, region: Option<ScanRegion>, mask: Option<&ScanMask>) -> Result<Self, Fault> {
        let fault = |what: String, remedy: &str| Fault::new(maps.name.clone(), what, remedy.to_owned());
        if maps.range.is_empty() {
            return Err(fault(
                "it holds no heights, only frames of the sensor".into(),
                "give scans, whose profiles were read",
            ));
        }
        let ignored = maps.cut_to(None, region, mask)?;
        let fault = |what: String, remedy: &str| Fault::new(maps.name.clone(), what, remedy.to_owned());
        if maps.cols < FEWEST_LINES || maps.rows < FEWEST_LINES {
            let what = format!("{} columns and {} profiles tell nothing of noise between them", maps.cols, maps.rows);
            return Err(fault(what, &format!("give a scan of at least {FEWEST_LINES} of each")));
        }
        let measured: Vec<usize> = measured(&maps, ignored.as_deref()).collect();
        if measured.len() < FEWEST_HEIGHTS {
            let what = format!("{} of its pixels that count have a height", measured.len());
            return Err(fault(
                what,
                &format!("give a part with at least {FEWEST_HEIGHTS}, on the object (--region, --mask)"),
            ));
        }
        if let Some(light) = &maps.reflectance {
            let full = measured.iter().filter(|&&i| light[i] >= 255.0).count();
            if full as f64 > MOST_SATURATED * measured.len() as f64 {
                let what = format!("{full} of {} peaks are saturated", measured.len());
                return Err(fault(what, "take a scan with less exposure, or give a darker part of it (--region)"));
            }
        }
        let statistics = summary(&maps, ignored.as_deref());
        let spreads = half_spreads(&maps, ignored.as_deref(), &statistics);
        Ok(Self { maps, ignored, statistics, spreads })
    }

    /// Refuses a scan that was taken by another geometry than simulated ones.
    ///
    /// # Errors
    /// What differs, and what to set.
    pub fn check_geometry(&self, simulated: MapGeometry) -> Result<(), Fault> {
        let fault = |what: String, remedy: String| Fault::new(self.maps.name.clone(), what, remedy);
        if (self.maps.unit != RangeUnit::Mm) != simulated.is_uncalibrated {
            let [real, ours] =
                if simulated.is_uncalibrated { ["heights", "sensor rows"] } else { ["sensor rows", "heights"] };
            let remedy =
                "set `extraction.range` of the recipe to what the scan is: calibrated, rectified or uncalibrated";
            return Err(fault(format!("it has {real}, simulated scans have {ours}"), remedy.into()));
        }
        let keys = [
            "`camera.distance_mm`, `focal_length_mm` and `pixel_um`, or `extraction.rectified_pitch_mm`",
            "`motion.step_mm`",
        ];
        for ((real, ours), (key, what)) in [self.maps.col_mm, self.maps.row_mm]
            .into_iter()
            .zip(simulated.pitch_mm)
            .zip(keys.into_iter().zip(["columns", "profiles"]))
        {
            let Some(real) = real else { continue };
            if (real / ours - 1.0).abs() > SAME_PITCH {
                let what = format!("its {what} are {real:.4} mm apart, those of simulated scans {ours:.4} mm");
                return Err(fault(what, format!("set {key} of the recipe to that")));
            }
        }
        Ok(())
    }
}

/// Pixels with a height that count.
pub(crate) fn measured(maps: &ScanMaps, ignored: Option<&[bool]>) -> impl Iterator<Item = usize> {
    let counts = move |i: &usize| ignored.is_none_or(|ignored| !ignored[*i]) && maps.range[*i].is_finite();
    (0..maps.range.len()).filter(counts)
}

/// Standard errors of statistics from six ways to cut a scan into two halves: a half's variance is twice that of the
/// whole, and the difference of two has twice a half's.
pub(crate) fn half_spreads(maps: &ScanMaps, ignored: Option<&[bool]>, whole: &[SummaryStatistic]) -> Vec<Option<f64>> {
    let (cols, rows) = (maps.cols, maps.rows);
    // Stripes and boards of so many parts along and across.
    let cuts = [(1, 2), (2, 1), (1, 4), (4, 1), (2, 2), (4, 4)];
    let mut squares = vec![(0.0, 0_u32); whole.len()];
    for (across, down) in cuts {
        let second = |i: usize| (i % cols * across / cols + i / cols * down / rows) % 2 == 1;
        let half = |which: bool| {
            let outside = |i: usize| second(i) != which || ignored.is_some_and(|ignored| ignored[i]);
            summary(maps, Some(&(0..maps.range.len()).map(outside).collect::<Vec<bool>>()))
        };
        let (a, b) = rayon::join(|| half(false), || half(true));
        for (sum, (a, b)) in squares.iter_mut().zip(a.iter().zip(&b)) {
            if let (Some(a), Some(b)) = (a.scaled, b.scaled) {
                *sum = (sum.0 + 0.25 * (a - b) * (a - b), sum.1 + 1);
            }
        }
    }
    let spread = |(sum, n): (f64, u32)| (n > 2).then(|| (sum / f64::from(n)).sqrt());
    squares.into_iter().map(spread).collect()
}
