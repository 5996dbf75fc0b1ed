//! One forged sensor frame among many that a sample keeps, its sums mended: told at the defaults, whichever frame it is
//! and however little of it is another. A part of the frames would leave the others to whoever forges.

use std::collections::BTreeSet;

use base::Stream;
use dataset::Dataset;
use dataset::record::StackFrame;
use dataset::validate::Code::ProfileDiffers;
use dataset::validate::RowChoice;
use rand::RngExt;
use sheetlight::generate::ExpectedDataset;

use super::place::{asked_choices, compare_rows, fresh, of_recipe, state, write_as};
use test_support::program::{mesh_recipe, pack_recipe, recipe, sawtooth_recipe};

/// What a forger has: the frames of a sample, which one to change, its columns, the same frame of another sample.
struct Forgery<'a> {
    frames: &'a mut [StackFrame],
    place: usize,
    cols: usize,
    other: &'a [u16],
}

impl Forgery<'_> {
    fn dn(&mut self) -> &mut Vec<u16> {
        &mut self.frames[self.place].dn
    }

    /// The lit pixel in the middle of the line.
    fn peak(&mut self) -> usize {
        let (cols, dn) = (self.cols, self.dn());
        let column = (0..dn.len()).filter(|pixel| pixel % cols == cols / 2);
        column.max_by_key(|pixel| dn[*pixel]).expect("a column")
    }

    /// First pixels of the lines of a patch of 8 x 8 about the peak.
    fn patch(&mut self) -> Vec<usize> {
        let (peak, cols) = (self.peak(), self.cols);
        let rows = self.dn().len() / cols;
        let (row, column) = ((peak / cols).clamp(4, rows - 4) - 4, peak % cols - 4);
        (row..row + 8).map(|row| row * cols + column).collect()
    }

    fn every(&mut self, change: impl Fn(u16) -> u16) {
        self.dn().iter_mut().for_each(|dn| *dn = change(*dn));
    }
}

/// A change of one frame.
type Change = fn(&mut Forgery);

const FORGERIES: [(&str, Change); 30] = [
    ("a pixel one number brighter", |f| f.dn()[77] += 1),
    ("the brightest pixel of a column one number darker", |f| {
        let peak = f.peak();
        f.dn()[peak] -= 1;
    }),
    ("a pixel of the line dead", |f| {
        let peak = f.peak();
        f.dn()[peak] = 0;
    }),
    ("a hot pixel", |f| *f.dn().last_mut().expect("pixels") = 255),
    ("two pixels swapped", |f| {
        let peak = f.peak();
        let bright = f.dn()[peak];
        let other = f.dn().iter().position(|dn| *dn != bright).expect("another number");
        f.dn().swap(peak, other);
    }),
    ("the line a row further on", |f| {
        let cols = f.cols;
        f.dn().rotate_right(cols);
    }),
    ("a column's line a row further on", |f| {
        let cols = f.cols;
        let column: Vec<u16> = f.dn().iter().skip(5).step_by(cols).copied().collect();
        f.dn().iter_mut().skip(5).step_by(cols).skip(1).zip(column).for_each(|(dn, before)| *dn = before);
    }),
    ("a row a column further on", |f| {
        let (row, cols) = (f.peak() / f.cols, f.cols);
        f.dn()[row * cols..(row + 1) * cols].rotate_right(1);
    }),
    ("every row a column further on", |f| {
        let cols = f.cols;
        f.dn().chunks_mut(cols).for_each(|row| row.rotate_right(1));
    }),
    ("a patch without light", |f| f.patch().into_iter().for_each(|first| f.dn()[first..first + 8].fill(11))),
    ("a patch one number brighter", |f| {
        f.patch()
            .into_iter()
            .for_each(|first| f.dn()[first..first + 8].iter_mut().for_each(|dn| *dn += u16::from(*dn < 255)));
    }),
    ("a patch from beside it", |f| f.patch().into_iter().for_each(|first| f.dn().copy_within(first - 8..first, first))),
    ("a patch of another sample", |f| {
        let other = f.other;
        f.patch().into_iter().for_each(|first| f.dn()[first..first + 8].copy_from_slice(&other[first..first + 8]));
    }),
    ("a row without light", |f| {
        let (row, cols) = (f.peak() / f.cols, f.cols);
        f.dn()[row * cols..(row + 1) * cols].fill(11);
    }),
    ("two rows swapped", |f| {
        let cols = f.cols;
        let (first, second) = f.dn().split_at_mut(cols);
        first.swap_with_slice(&mut second[..cols]);
    }),
    ("a column like the one beside it", |f| {
        let cols = f.cols;
        f.dn().chunks_mut(cols).for_each(|row| row[8] = row[9]);
    }),
    ("the frame of another sample, but for a pixel", |f| {
        let other = f.other;
        f.dn().copy_from_slice(other);
        f.dn()[0] += 1;
    }),
    ("the frame of the next profile, but for a pixel", |f| {
        let next = f.frames[f.place + 1].dn.clone();
        *f.dn() = next;
        f.dn()[1] += 1;
    }),
    ("two frames swapped", |f| {
        let (first, second) = f.frames.split_at_mut(f.place + 1);
        std::mem::swap(&mut first[f.place].dn, &mut second[0].dn);
    }),
    ("the mean with the next frame", |f| {
        let next = f.frames[f.place + 1].dn.clone();
        f.dn().iter_mut().zip(next).for_each(|(dn, next)| *dn = (*dn + next).div_ceil(2));
    }),
    ("a tenth darker", |f| f.every(|dn| dn * 9 / 10)),
    ("a tenth brighter", |f| f.every(|dn| (dn * 11 / 10).min(255))),
    ("one number brighter", |f| f.every(|dn| (dn + 1).min(255))),
    ("dark noise taken away", |f| f.every(|dn| if dn < 20 { 12 } else { dn })),
    ("more noise", |f| {
        let mut rng = Stream::root(4).child("forgery").rng();
        f.dn().iter_mut().for_each(|dn| *dn = (*dn + rng.random_range(0..3)).clamp(1, 256) - 1);
    }),
    ("smoothed", |f| {
        let before = f.dn().clone();
        f.dn()
            .iter_mut()
            .skip(1)
            .zip(before.windows(3))
            .for_each(|(dn, near)| *dn = near.iter().sum::<u16>().div_ceil(3));
    }),
    ("the brightest pixels clipped", |f| {
        let most = f.dn().iter().max().copied().expect("pixels");
        f.every(|dn| dn.min(most - 1));
    }),
    ("mirrored", |f| {
        let cols = f.cols;
        f.dn().chunks_mut(cols).for_each(<[u16]>::reverse);
    }),
    ("turned", |f| f.dn().reverse()),
    ("a negative", |f| f.every(|dn| 255 - dn.min(254))),
];

/// The small recipe of each subject, which writes Range and twelve sensor frames alone.
fn subjects() -> [(&'static str, String); 4] {
    let alone = |text: String, every: u64| {
        let is_kept = |line: &&str| !["  png:", "  exr:", "  truth_maps:"].iter().any(|key| line.starts_with(key));
        let lines: Vec<&str> = text.lines().filter(is_kept).collect();
        let output = format!("sensor_stack: {{every: {every}}}\n  png: [range]\n  exr: []\n  truth_maps: false");
        lines.join("\n").replacen("sensor_stack: none", &output, 1)
    };
    [
        ("wood", alone(recipe(&[]), 4)),
        ("blister", alone(pack_recipe(&[]), 8)),
        ("sawtooth", alone(sawtooth_recipe(&[]), 4)),
        ("mesh", alone(mesh_recipe(&[]), 4)),
    ]
}

#[test]
#[ignore = "long"]
fn one_forged_frame_of_many_is_told() {
    let seeds = fresh(asked_choices().unwrap_or(1));
    let (mut tried, mut told_by_one) = (0, 0);
    for (number, (subject, text)) in (0..).zip(subjects()) {
        let (head, samples) = of_recipe(&text, FORGERIES.len() as u64);
        let place = write_as(head.clone(), samples.clone());
        let expected = ExpectedDataset::of(&Dataset::open(place.path()).expect("it opens")).expect("its recipe loads");
        // Frames that would give nothing to forge are told by other rules.
        let kept = samples[0].stack.len();
        assert!(kept == 12 && samples.iter().all(|sample| sample.stack.len() == kept), "{subject}");
        let mut rng = Stream::root(number).child("forger").rng();
        let mut forged = samples.clone();
        for (number, (what, forge)) in FORGERIES.into_iter().enumerate() {
            let place = rng.random_range(0..kept - 1);
            let other = &samples[(number + 1) % samples.len()].stack[place].dn;
            forge(&mut Forgery {
                frames: &mut forged[number].stack,
                place,
                cols: head.images.sensor_cols as usize,
                other,
            });
            assert!(forged[number].stack != samples[number].stack, "{subject}, {what}: nothing is forged");
        }
        let place = write_as(head, forged);
        let report = |rows: Option<RowChoice>| compare_rows(place.path(), Ok(&expected), rows);
        let found = |rows: RowChoice| -> BTreeSet<String> {
            let faults = report(Some(rows)).faults.into_iter();
            faults.inspect(|found| assert_eq!(found.code, ProfileDiffers)).map(|found| found.fault.place).collect()
        };
        let others = report(None);
        assert!(others.is_clean(), "{subject}: other rules tell it:\n{others}");
        let usual = |seed: &u64| expected.rows(None, *seed).expect("the kernel is quick");
        let all: Vec<BTreeSet<String>> = seeds.iter().map(|seed| found(usual(seed))).collect();
        for (number, (what, _)) in FORGERIES.iter().enumerate() {
            let name = format!("stacks/00000.parquet, sample {number}");
            let told = all.iter().filter(|places| places.contains(&name)).count();
            state(&format!("one frame of {kept}: {what}, {subject}"), told, seeds.len());
            assert_eq!(told, seeds.len(), "{subject}: {what}");
        }
        tried += FORGERIES.len();
        told_by_one += found(RowChoice { frames: 1, ..usual(&number) }).len();
    }
    println!("{tried} forgeries of one frame told, by one frame of each sample {told_by_one}");
    assert!(told_by_one < tried / 3, "{told_by_one} of {tried}");
}
