//! Samples that are wrong in themselves, with every checksum right: numbers, images, labels, frames.

use base::Class;
use dataset::validate::Code::*;
use dataset::{Encoded, Grey, write_png};
use optical_bench::settings::Channel;
use optical_bench::split::Split;

use super::place::{SIZE, boards, codes_of, exr, labels, looked_at, of_recipe, png, relabel, with};

/// A sample that shows objects, and another one.
fn pair() -> [usize; 2] {
    let shown: Vec<usize> = (0..boards().samples.len()).filter(|&i| !boards().samples[i].objects.is_empty()).collect();
    assert!(shown.len() > 1, "two boards show knots or rot");
    [shown[0], shown[1]]
}

/// The first sample of a class whose name holds a word.
fn of_class(word: &str) -> usize {
    boards().samples.iter().position(|sample| sample.class.contains(word)).expect("the class has a sample")
}

/// Mirrored, moved by columns, or moved by rows.
fn moved(numbers: &[u16], columns: usize, rows: usize, mirrored: bool) -> Vec<u16> {
    let (cols, lines) = SIZE;
    let place = |i: usize| {
        let x = if mirrored { cols - 1 - i % cols } else { (i % cols + cols - columns) % cols };
        (i / cols + lines - rows) % lines * cols + x
    };
    (0..numbers.len()).map(|i| numbers[place(i)]).collect()
}

#[test]
#[ignore = "long"]
fn masks() {
    let (a, b) = (of_class("rot"), of_class("knot"));
    let swap = |samples: &mut Vec<Encoded>| {
        let [of_a, of_b] = [a, b].map(|i| labels(&samples[i]));
        let (objects, defects) = (samples[a].objects.clone(), samples[a].defects.clone());
        (samples[a].objects, samples[a].defects) = (samples[b].objects.clone(), samples[b].defects.clone());
        (samples[b].objects, samples[b].defects) = (objects, defects);
        relabel(&mut samples[a], &of_b[0], &of_b[1]);
        relabel(&mut samples[b], &of_a[0], &of_a[1]);
    };
    let place = format!("{}.exr", boards().samples[a].id);
    // The outlines of both boards lie within the two pixels at which pictures are held against labels.
    with(swap, &[DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers], &place, "masks of two samples swapped");
    for (columns, rows) in [(3, 0), (0, 3), (SIZE.0 - 4, 0)] {
        let shift = |samples: &mut Vec<Encoded>| {
            let [label, instance] = labels(&samples[a]).map(|numbers| moved(&numbers, columns, rows, false));
            relabel(&mut samples[a], &label, &instance);
        };
        let what = format!("a mask moved by {columns} columns and {rows} rows");
        with(shift, &[TruthDiffers, LabelDiffers], &place, &what);
    }
    let mirror = |samples: &mut Vec<Encoded>| {
        let [label, instance] = labels(&samples[a]).map(|numbers| moved(&numbers, 0, 0, true));
        relabel(&mut samples[a], &label, &instance);
    };
    with(mirror, &[TruthDiffers, LabelDiffers], &place, "a mirrored mask");
}

/// Where the recipe cannot be drawn again, saturated pixels at a card's edge do not count for its outline; those of the
/// conveyor that a mask takes for the card after it was moved by three rows do.
#[test]
#[ignore = "long"]
fn masks_of_overexposed_packs() {
    let text = include_str!("../../../recipes/blister-small.yaml").replacen("exr: auto", "exr: all", 1);
    let line = text.lines().find(|line| line.trim_start().starts_with("time_us:")).expect("an exposure time");
    let (head, samples) = of_recipe(&text.replacen(line, "  time_us: 400", 1), 3);
    assert_eq!(looked_at(&head, samples.clone()), []);
    for way in [3, -3] {
        let mut moved = samples.clone();
        for sample in &mut moved {
            let [label, instance] = labels(sample).map(|mut numbers| {
                let rows = 360 * 3;
                if way > 0 {
                    numbers.rotate_right(rows)
                } else {
                    numbers.rotate_left(rows)
                }
                numbers
            });
            relabel(sample, &label, &instance);
        }
        assert!(looked_at(&head, moved.clone()).contains(&OutlineDiffers), "masks moved by {way} rows");
        let what = format!("masks of overexposed packs moved by {way} rows");
        assert!(codes_of(&head, moved, &what).contains(&LabelDiffers), "{what}");
    }
}

/// Moved by one pixel, the mask of an object that ends within the image is found exactly: every row crosses its sides,
/// and the rows at its ends are made again. Nothing on the object, no truth map and no picture helps.
#[test]
#[ignore = "long"]
fn masks_moved_by_a_pixel() {
    let bare = ["truth_maps: true", "truth_maps: false"];
    let wood = include_str!("../../../recipes/wood-small.yaml").replacen("exr: auto", "exr: all", 1);
    let classes =
        &wood[wood.find("classes:").expect("classes")..wood.find("# How the profiles").expect("the next section")];
    let wood = wood.replace(classes, "classes: {clear: {share: 1}}\n").replacen(bare[0], bare[1], 1);
    let png = ["png: [range, reflectance, scatter, label]", "png: [range, reflectance]"];
    for (name, text) in [("labels in PNG", wood.clone()), ("labels in EXR", wood.replacen(png[0], png[1], 1))] {
        let (head, samples) = of_recipe(&text, 2);
        assert_eq!(codes_of(&head, samples.clone(), name), [], "{name}");
        for (columns, rows) in [(0, 1), (0, -1), (1, 0), (-1, 0), (0, 3), (0, -3)] {
            let mut moved = samples.clone();
            for sample in &mut moved {
                let cols = sample.cols as isize;
                let [label, instance] = labels(sample).map(|mut numbers| {
                    let most = numbers.len() as isize;
                    numbers.rotate_right((rows * cols + columns).rem_euclid(most) as usize);
                    numbers
                });
                relabel(sample, &label, &instance);
            }
            let what = format!("{name}, a mask moved by {columns} columns and {rows} rows");
            assert_eq!(codes_of(&head, moved, &what), [LabelDiffers], "{what}");
        }
    }
}

/// Where the recipe cannot be drawn again, a knot whose fibres lie flat is looked at; of a hole, which shows the wood
/// below, nothing is expected.
#[test]
#[ignore = "long"]
fn fibres_of_knots() {
    let wood = include_str!("../../../recipes/wood-small.yaml").replacen(
        "bin: {columns: 1, profiles: 1}",
        "bin: {columns: 2, profiles: 2}",
        1,
    );
    let classes =
        &wood[wood.find("classes:").expect("classes")..wood.find("# How the profiles").expect("the next section")];
    for (kind, is_told) in [("dead_count", true), ("hole_count", false)] {
        let text = wood.replace(classes, &format!("classes: {{a: {{share: 1, knots: {{{kind}: 2}}}}}}\n"));
        let (head, samples) = of_recipe(&text, 3);
        assert_eq!(looked_at(&head, samples.clone()), [], "{kind}");
        let mut flat = samples;
        for sample in &mut flat {
            exr(sample, |channels, _| {
                let dive = channels.iter_mut().find(|channel| channel.name == "FibreDive").expect("truth maps");
                dive.numbers.iter_mut().for_each(|n| *n *= 0.0);
            });
        }
        let expected: &[dataset::validate::Code] = if is_told { &[DiveDiffers] } else { &[] };
        assert_eq!(looked_at(&head, flat.clone()), expected, "{kind}");
        assert_eq!(codes_of(&head, flat, "fibres of knots that lie flat"), [TruthDiffers], "{kind}");
    }
}

#[test]
#[ignore = "long"]
fn labels_of_pixels_and_objects() {
    let [a, _] = pair();
    let id = format!("sample {a}");
    let own = |sample: &Encoded| {
        let [_, instance] = labels(sample);
        let number = sample.objects[0].instance.id;
        // Rows at the ends of the board and through the middle of an object are made again, and tell it by themselves.
        let own: Vec<usize> = (0..instance.len()).filter(|&at| instance[at] == number).collect();
        own[own.len() / 4]
    };
    let pixel = |samples: &mut Vec<Encoded>| {
        let sample = &mut samples[a];
        let ([mut label, instance], at) = (labels(sample), own(sample));
        label[at] = Class::Clear as u16;
        relabel(sample, &label, &instance);
    };
    with(pixel, &[InstanceClass], &id, "one pixel of a defect labelled clear");
    let free = |samples: &mut Vec<Encoded>| {
        let sample = &mut samples[a];
        let ([label, mut instance], at) = (labels(sample), own(sample));
        instance[at] = 0;
        relabel(sample, &label, &instance);
    };
    with(free, &[InstanceClass], &id, "one pixel of a defect of no instance");
    let class = |samples: &mut Vec<Encoded>| {
        let object = &mut samples[a].objects[0].instance;
        object.class = if object.class == Class::SoundKnot { Class::DeadKnot } else { Class::SoundKnot };
        object.state = object.class;
        let class = object.class;
        samples[a].defects[0] = class;
    };
    with(class, &[DrawDiffers, InstanceClass, ObjectDiffers], &id, "the class of an object");
    let number = |samples: &mut Vec<Encoded>| samples[a].objects[0].instance.id += 7;
    with(number, &[DrawDiffers, ObjectDiffers], &id, "an object with another number");
    with(|samples| samples[a].objects[0].bbox[0] += 1, &[ObjectDiffers], &id, "a box one pixel off");
    with(|samples| samples[a].objects[0].area_px += 1, &[ObjectDiffers], &id, "a pixel more");
    with(|samples| samples[a].objects[0].area_mm2 *= 1.01, &[ObjectDiffers], &id, "an area of more mm^2");
    with(|samples| samples[a].objects[0].area_mm2 = -1.0, &[ValueRange, ObjectDiffers], &id, "a negative area");
    with(
        |samples| samples[a].objects[0].instance.severity = 1.5,
        &[DrawDiffers, ValueRange],
        &id,
        "a severity beyond 1",
    );
    with(|samples| _ = samples[a].objects.pop(), &[ObjectDiffers], &id, "an object that was left out");
    let swap = |samples: &mut Vec<Encoded>| samples[a].class_area_px.swap(0, 1);
    with(swap, &[ClassAreaDiffers], &id, "areas of two classes swapped");
    let known = |n: &mut Vec<u16>| n[500] = 77;
    with(
        |samples| png(&mut samples[a], Channel::Label, known),
        &[LabelUnknown, InstanceClass, TruthDiffers, LabelDiffers, ShareDiffers, ExrDiffers],
        &id,
        "a class of nothing",
    );
}

#[test]
#[ignore = "long"]
fn rows() {
    with(|samples| samples[1].draws[2].1 = samples[1].draws[2].1.next_up(), &[DrawDiffers], "sample 1", "a last bit");
    with(|samples| samples[1].draws[2].1 = f64::NAN, &[NumberMissing], "data/", "a number left out");
    with(
        |samples| samples[1].physics[0].1 = f64::INFINITY,
        &[DrawDiffers, ValueRange],
        "sample 1",
        "a derived number without end",
    );
    // Sizes stand in the EXR file too, and areas follow from them.
    let codes = [DrawDiffers, ValueRange, ExrDiffers, ObjectDiffers];
    let [a, _] = pair();
    with(|samples| samples[a].row_mm = -1.0, &codes, &format!("sample {a}"), "a negative distance");
    let calibration = |samples: &mut Vec<Encoded>| samples[1].calibration[0].1 += 0.5;
    with(calibration, &[DrawDiffers, ExrDiffers], ".exr", "another distance of the camera");
    with(|samples| samples[1].shares.measured *= 0.9, &[ShareDiffers], "sample 1", "a measured share");
    with(|samples| samples[1].shares.saturated = 0.5, &[ShareDiffers], "sample 1", "a saturated share");
    with(|samples| samples[1].shares.measured = f64::NAN, &[ShareDiffers], "sample 1", "a share that was left out");
    let beyond = |samples: &mut Vec<Encoded>| samples[1].shares.saturated = 1.5;
    with(beyond, &[ValueRange], "sample 1", "a share beyond 1");
    let in_view = |samples: &mut Vec<Encoded>| samples[1].shares.in_view *= 0.9;
    with(in_view, &[DrawDiffers], "sample 1", "a share in the field");
    let split = |samples: &mut Vec<Encoded>| {
        let test = if samples[1].split == Split::Test { Split::Train } else { Split::Test };
        samples[1].split = test;
        exr(&mut samples[1], |_, text| text["split"] = test.name().into());
    };
    with(split, &[ManifestDiffers, RowDiffers], "sample 1", "another split");
    let class = |samples: &mut Vec<Encoded>| {
        let other = boards().head.classes.iter().find(|class| **class != samples[1].class).expect("two classes");
        samples[1].class = other.clone();
        exr(&mut samples[1], |_, text| text["class"] = other.as_str().into());
    };
    with(class, &[ManifestDiffers, RowDiffers], "sample 1", "another class");
    let id = |samples: &mut Vec<Encoded>| {
        samples[1].id = samples[0].id.clone();
        exr(&mut samples[1], |_, text| text["id"] = boards().samples[0].id.as_str().into());
    };
    // Both have the same EXR file, that of the latter: its maps are not those of the former.
    let of_file = [ExrDiffers, SampleChecksum, TruthDiffers, LabelDiffers, ObjectDiffers, InstanceClass];
    // It has one of the two sizes that the manifest lists, so the shard is not done, and nobody finishes the card.
    let codes = [[ManifestDiffers, IdRepeated, RowDiffers].as_slice(), &of_file, &[CardDiffers]].concat();
    with(id, &codes, "sample 1", "the id of another sample");
}

#[test]
#[ignore = "long"]
fn images() {
    let lit = |n: &[u16]| n.iter().position(|&n| n > 0).expect("light");
    let cut = |samples: &mut Vec<Encoded>| samples[2].png[1].1.truncate(60);
    with(cut, &[ImageUnreadable], "sample 2", "half an image");
    let small = |samples: &mut Vec<Encoded>| samples[2].png[1].1 = write_png(&Grey::Eight(vec![9; 12]), 4);
    with(small, &[ImageSize], "sample 2", "a small image");
    let deep = |samples: &mut Vec<Encoded>| {
        samples[2].png[1].1 = write_png(&Grey::Sixteen(vec![9; SIZE.0 * SIZE.1]), SIZE.0);
    };
    with(deep, &[ImageSize], "sample 2", "an image of 16 bits");
    let dark = |n: &mut Vec<u16>| {
        let at = lit(n);
        n[at] = 0;
    };
    let codes = [MissingRule, ExrDiffers];
    with(|samples| png(&mut samples[2], Channel::Range, dark), &codes, "sample 2", "light without range");
    let step = |n: &mut Vec<u16>| {
        let at = lit(n);
        n[at] += 2;
    };
    with(|samples| png(&mut samples[2], Channel::Range, step), &[ExrDiffers], ".exr", "a height that was moved");
    let negative = |samples: &mut Vec<Encoded>| {
        exr(&mut samples[of_class("knot")], |channels, _| {
            let dive = channels.iter_mut().find(|channel| channel.name == "FibreDive").expect("truth maps");
            dive.numbers.iter_mut().for_each(|n| *n = n.abs() - 91.0);
        });
    };
    with(negative, &[ValueRange, TruthDiffers], ".exr", "a dive below -90");
    let none = |samples: &mut Vec<Encoded>| {
        exr(&mut samples[2], |channels, _| {
            let height = channels.iter_mut().find(|channel| channel.name == "Height").expect("truth maps");
            let at = height.numbers.iter().position(|z| !z.is_nan()).expect("a board");
            height.numbers[at] = f32::NAN;
        });
    };
    with(none, &[TruthDiffers], ".exr", "a height that is none");
    let unit = |samples: &mut Vec<Encoded>| exr(&mut samples[2], |_, text| text["units"]["Range"] = "m".into());
    with(unit, &[ExrDiffers], ".exr", "another unit");
    let fewer = |samples: &mut Vec<Encoded>| exr(&mut samples[2], |channels, _| _ = channels.pop());
    with(fewer, &[ExrChannels], ".exr", "a channel that was left out");
}

#[test]
#[ignore = "long"]
fn sensor_frames() {
    let frames = "stacks/00000.parquet";
    with(|samples| _ = samples[1].stack.pop(), &[StackDiffers], frames, "a frame that was left out");
    with(|samples| samples[1].stack.swap(0, 1), &[StackDiffers], frames, "frames in another order");
    with(|samples| samples[1].stack[1].profile = 3, &[StackDiffers], frames, "a frame of another profile");
    let dark = |samples: &mut Vec<Encoded>| samples[1].stack[1].dn.fill(0);
    with(dark, &[StackBlank], frames, "a frame of nothing");
    let copy = |samples: &mut Vec<Encoded>| samples[1].stack = boards().samples[0].stack.clone();
    with(copy, &[StackRepeated], frames, "the frames of another sample");
}
