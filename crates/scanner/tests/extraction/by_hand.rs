//! What an extractor makes of a column, by hand: peaks, plateaus, windows, edges, Scatter.

use crate::columns::{SENSOR, by, column, frame, read, read_both, settings};
use base::Stream;
use optical_bench::settings::{Extraction, PeakChoice, PeakMethod, ScatterDark, ScatterMode, SearchDirection};
use rand::RngExt;
use scanner::extract::{margin, scatter_pixels};
use scanner::frame::Frame;

const METHODS: [PeakMethod; 5] = [
    PeakMethod::CentreOfGravity,
    PeakMethod::Parabola,
    PeakMethod::Gaussian,
    PeakMethod::BlaisRioux { order: 4 },
    PeakMethod::Fir { length: 5 },
];

/// A line of random shape, its rows above a dark level of 0.
fn shape(rng: &mut impl rand::Rng) -> Vec<u16> {
    let centre: f64 = rng.random_range(6.0..8.0);
    let sigma: f64 = rng.random_range(0.8..2.0);
    (0..15).map(|k| (200.0 * libm::exp(-0.5 * ((k as f64 - centre) / sigma).powi(2))) as u16).collect()
}

/// Whole rows move the position by themselves, an offset that the calibration knows and a scale do nothing.
#[test]
fn positions_move_with_the_line_and_with_nothing_else() {
    let mut rng = Stream::root(11).rng();
    for method in METHODS {
        let settings = Extraction { threshold_dn: 40.0, ..by(method, 3) };
        for _ in 0..50 {
            let shape = shape(&mut rng);
            let at = |dark: u16, first: usize, scale: u16| {
                let levels: Vec<u16> = shape.iter().map(|dn| dark + scale * dn).collect();
                read(frame(&[column(dark, first, &levels)]), f32::from(dark), &settings)[0][0]
            };
            let plain = at(0, 100, 1);
            assert!(plain.is_finite(), "{method:?} finds nothing in {shape:?}");
            assert!((at(0, 137, 1) - plain - 37.0).abs() < 1e-4, "{method:?}: shift");
            assert!((at(23, 100, 1) - plain).abs() < 1e-4, "{method:?}: offset");
            // Logarithms are taken from half a digital number on, which no scale changes.
            if method != PeakMethod::Gaussian {
                assert!((at(0, 100, 7) - plain).abs() < 1e-4, "{method:?}: scale");
            }
        }
    }
}

/// A plateau of seven saturated rows between flanks: where each method puts it, from either end.
#[test]
fn saturated_plateaus_count_from_their_first_row() {
    let levels = [60, 255, 255, 255, 255, 255, 255, 255, 60];
    let of = |method, window, direction| {
        let settings = Extraction { direction, ..by(method, window) };
        let [range, reflectance, _] = read(frame(&[column(0, 100, &levels)]), 0.0, &settings);
        assert_eq!(reflectance, [255.0]);
        range[0]
    };
    let (standard, reverse) = (SearchDirection::Standard, SearchDirection::Reverse);
    // The window of three rows about row 101 holds 101 to 104 whole and row 100: its centre of gravity by hand.
    let sum = 60.0 + 4.0 * 255.0;
    let short = 101.0 + (255.0 * (1.0 + 2.0 + 3.0) - 60.0) / sum;
    let found = of(PeakMethod::CentreOfGravity, 3, standard);
    assert!((found - short).abs() < 1e-3, "{found} and not {short}");
    // From the other end it is the mirror image about the middle, 104.
    assert!((of(PeakMethod::CentreOfGravity, 3, reverse) - (208.0 - short)).abs() < 1e-3);
    // Windows that reach the far end see all of it.
    assert!((of(PeakMethod::CentreOfGravity, 15, standard) - 104.0).abs() < 1e-3);
    for method in [PeakMethod::Parabola, PeakMethod::Gaussian] {
        assert_eq!((of(method, 7, standard), of(method, 7, reverse)), (101.5, 106.5), "{method:?}");
    }
    for method in [PeakMethod::BlaisRioux { order: 4 }, PeakMethod::Fir { length: 5 }] {
        assert!((of(method, 7, standard) - 104.0).abs() < 1e-3, "{method:?}: {}", of(method, 7, standard));
        assert!((of(method, 7, reverse) - 104.0).abs() < 1e-3, "{method:?}");
        // A window that ends on the plateau sees no falling side.
        assert!(of_missing(method, &levels), "{method:?}");
    }
}

/// Whether a window of three rows finds nothing.
fn of_missing(method: PeakMethod, levels: &[u16]) -> bool {
    let long: Vec<u16> = levels.iter().copied().flat_map(|dn| if dn == 255 { vec![dn; 2] } else { vec![dn] }).collect();
    read(frame(&[column(0, 100, &long)]), 0.0, &by(method, 3))[0][0].is_nan()
}

/// Two lines in a column: the stronger one, the first one from either end; a shoulder on a rise is no peak, a dip is.
#[test]
fn peaks_are_chosen_as_asked() {
    let mut two = column(0, 80, &[30, 90, 90, 30]);
    two[150..153].copy_from_slice(&[40, 200, 40]);
    let row = |column: &[u16], peak, direction| {
        let settings = Extraction { peak, direction, ..by(PeakMethod::Parabola, 1) };
        read(frame(&[column.to_vec()]), 0.0, &settings)[0][0]
    };
    assert_eq!(row(&two, PeakChoice::Strongest, SearchDirection::Standard), 151.0);
    assert_eq!(row(&two, PeakChoice::First, SearchDirection::Standard), 81.5);
    assert_eq!(row(&two, PeakChoice::First, SearchDirection::Reverse), 151.0);
    two[151] = 60;
    assert_eq!(row(&two, PeakChoice::Strongest, SearchDirection::Standard), 81.5);
    // Of two rows alike the first in the direction of the search, seen by the neighbours that the parabola takes.
    assert_eq!(row(&two, PeakChoice::Strongest, SearchDirection::Reverse), 81.5);
    let rise = column(0, 80, &[18, 30, 60, 61, 90, 30]);
    assert!((row(&rise, PeakChoice::First, SearchDirection::Standard) - 84.0).abs() < 0.5);
    let dip = column(0, 80, &[18, 40, 39, 60, 90, 30]);
    assert!((row(&dip, PeakChoice::First, SearchDirection::Standard) - 81.0).abs() <= 0.5);
    assert!((row(&dip, PeakChoice::Strongest, SearchDirection::Standard) - 84.0).abs() < 0.5);
}

/// A peak below the threshold, or too near the edge of sensor or frame for its windows, is missing with all its
/// numbers; one row further in it is there.
#[test]
fn missing_is_missing_everywhere() {
    for method in METHODS {
        for (window, width) in [(3, 1), (7, 1), (15, 1), (3, 12)] {
            let settings = Extraction { scatter_width_rows: width, ..by(method, window) };
            let need = margin(&settings);
            let at = |peak: usize, dn: u16| {
                let mut column = vec![0; SENSOR];
                column[peak] = dn;
                (column[peak - 1], column[peak + 1]) = (dn / 2, dn / 2);
                let [range, reflectance, scatter] = read(frame(&[column]), 0.0, &settings);
                (range[0], reflectance[0], scatter[0])
            };
            for (peak, dn, there) in [
                (need, 100, true),
                (need - 1, 100, false),
                (SENSOR - 1 - need, 100, true),
                (SENSOR - need, 100, false),
                (120, 17, true),
                (120, 16, false),
            ] {
                if peak == 0 || peak + 1 == SENSOR {
                    continue;
                }
                let (range, reflectance, scatter) = at(peak, dn);
                assert_eq!(range.is_finite(), there, "{method:?} {window} {width}: peak {peak} of {dn} DN");
                assert_eq!(reflectance > 0.0, there);
                assert_eq!(scatter > 0.0, there && settings.scatter_offset_rows <= 1);
                assert!(there || (range.is_nan() && (reflectance, scatter) == (0.0, 0.0)));
            }
        }
    }
    // Range is the row in steps of a sixteenth.
    let rounded = Extraction { subpixel_steps: 16, ..by(PeakMethod::Parabola, 1) };
    let [range, ..] = read(frame(&[column(0, 100, &[50, 100, 73])]), 0.0, &rounded);
    assert_eq!(range[0], 101.125, "the vertex lies at 23 / 154 of a row, 2.4 sixteenths");
}

/// Sums of the side windows by hand, for each mode, offset and width, with and without the dark level.
#[test]
fn scatter_by_hand() {
    // Row 100 + k holds 10 + k up to the peak of 200 at row 120, behind it 50 - k.
    let mut levels: Vec<u16> = (0..20).map(|k| 10 + k).collect();
    levels.push(200);
    levels.extend((1..20).map(|k| 50 - k));
    let before = |d: usize| 30.0 - d as f32;
    let behind = |d: usize| 50.0 - d as f32;
    for (offset, width) in [(0, 1), (0, 15), (1, 8), (7, 5), (15, 1), (2, 14)] {
        let rows = offset..offset + width;
        let front: f32 = rows.clone().map(|d| if d == 0 { 200.0 } else { before(d) }).sum();
        let back: f32 = rows.map(|d| if d == 0 { 200.0 } else { behind(d) }).sum();
        let both = front + back - if offset == 0 { 200.0 } else { 0.0 };
        for (scatter_mode, sum) in
            [(ScatterMode::Symmetric, both), (ScatterMode::Front, front), (ScatterMode::Back, back)]
        {
            for (scatter_dark, dark) in [(ScatterDark::Kept, 0.0), (ScatterDark::Subtracted, 4.5f32)] {
                let settings = Extraction {
                    scatter_mode,
                    scatter_dark,
                    scatter_offset_rows: offset,
                    scatter_width_rows: width,
                    ..settings()
                };
                let [_, _, scatter] = read(frame(&[column(4, 100, &levels)]), 4.5, &settings);
                let expected = sum - dark * scatter_pixels(&settings) as f32;
                assert_eq!(scatter[0], expected, "{scatter_mode:?} {offset} {width} {scatter_dark:?}");
            }
        }
    }
    // Less than nothing is nothing, more than 16 bits is 65535.
    let end = |dark, levels: &[u16]| {
        let settings = Extraction { scatter_dark: ScatterDark::Subtracted, ..settings() };
        read(frame(&[column(0, 100, levels)]), dark, &settings)[2][0]
    };
    assert_eq!(end(9.0, &[100]), 0.0);
    assert_eq!(end(0.0, &[60_000; 40]), 65535.0);
}

/// Of two windows that hold the same column the first peak is the first of both, whichever window has it.
#[test]
fn first_peaks_are_found_in_either_window() {
    let line = |first: i32, top: u16| Frame {
        cols: 1,
        rows: 44,
        first_col: 0,
        first_row: vec![first],
        dn: (0..44)
            .map(|k: i32| {
                if k == 22 {
                    top
                } else if (k - 22).abs() == 1 {
                    top / 2
                } else {
                    0
                }
            })
            .collect(),
    };
    let (low, high) = (line(40, 60), line(120, 200));
    for (peak, direction, row) in [
        (PeakChoice::Strongest, SearchDirection::Standard, 142.0),
        (PeakChoice::First, SearchDirection::Standard, 62.0),
        (PeakChoice::First, SearchDirection::Reverse, 142.0),
    ] {
        let settings = Extraction { peak, direction, ..by(PeakMethod::Parabola, 1) };
        for frames in [[low.clone(), high.clone()], [high.clone(), low.clone()]] {
            assert_eq!(read_both(&frames, 0.0, &settings)[0], [row], "{peak:?} {direction:?}");
        }
    }
}

/// Twelve bits are read as eight are: a sixteenfold frame over a sixteenfold threshold has the same rows.
#[test]
fn more_bits_are_read_alike() {
    let mut rng = Stream::root(13).rng();
    let columns: Vec<Vec<u16>> = (0..64).map(|_| column(0, 100, &shape(&mut rng))).collect();
    let fine: Vec<Vec<u16>> = columns.iter().map(|c| c.iter().map(|dn| 16 * dn).collect()).collect();
    for method in METHODS.into_iter().filter(|method| *method != PeakMethod::Gaussian) {
        let settings = by(method, 7);
        let of_fine = Extraction { threshold_dn: 16.0 * settings.threshold_dn, ..settings };
        let [rows, light, _] = read(frame(&columns), 0.0, &settings);
        let [fine_rows, fine_light, _] = read(frame(&fine), 0.0, &of_fine);
        assert!(rows.iter().zip(&fine_rows).all(|(a, b)| (a - b).abs() < 1e-4), "{method:?}");
        assert!(light.iter().zip(&fine_light).all(|(a, b)| 16.0 * a == *b), "{method:?}");
    }
}
