//! Labels from the truth alone: noise-free hits and the body's own instances, never a measured map.

use procedural::{Class, Instance, atan2};

use crate::record::{Labels, Object, TruthMaps};
use crate::specimen::Hit;

/// Writes the truth of one profile into row `row` of full-size maps of `hits.len()` columns.
pub fn label_row(hits: &[Hit], class: &mut [u8], instance: &mut [u16]) {
    for (column, hit) in hits.iter().enumerate() {
        class[column] = hit.matter.class as u8;
        instance[column] = hit.matter.instance;
    }
}

/// Writes height, fibre azimuth and fibre dive of one profile; NaN off the body.
pub fn truth_row(hits: &[Hit], height: &mut [f32], azimuth: &mut [f32], dive: &mut [f32]) {
    for (column, hit) in hits.iter().enumerate() {
        (height[column], azimuth[column], dive[column]) = if hit.matter.class == Class::Background {
            (f32::NAN, f32::NAN, f32::NAN)
        } else {
            let normal = glam::Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize();
            let fibre = hit.matter.medium.fibre;
            let rise = fibre.dot(normal).clamp(-1.0, 1.0);
            let along = fibre - normal * rise;
            // The fibre's sign has no meaning: the end that points along the scan gives the angle.
            let sign = if along.y < 0.0 { -1.0 } else { 1.0 };
            let turn = atan2(sign * along.x, sign * along.y).to_degrees();
            (hit.surface.z, turn, atan2(rise.abs(), along.length()).to_degrees())
        };
    }
}

/// Groups of `columns x rows` pixels into one: the most frequent class (the greater value on a tie, so that a small
/// defect is not lost to sound wood), and among its pixels the most frequent instance.
pub fn bin(labels: Labels, cols: usize, columns: usize, rows: usize) -> Labels {
    if columns == 1 && rows == 1 {
        return labels;
    }
    let (out_cols, out_rows) = (cols / columns, labels.class.len() / cols / rows);
    let mut out = Labels { class: Vec::with_capacity(out_cols * out_rows), instance: Vec::new() };
    let mut group: Vec<(u8, u16)> = Vec::with_capacity(columns * rows);
    for row in 0..out_rows {
        for column in 0..out_cols {
            group.clear();
            for r in row * rows..(row + 1) * rows {
                let line = r * cols + column * columns;
                group.extend((line..line + columns).map(|i| (labels.class[i], labels.instance[i])));
            }
            group.sort_unstable();
            let class = most_frequent(group.iter().map(|&(class, _)| u16::from(class)));
            let instance = most_frequent(group.iter().filter(|p| u16::from(p.0) == class).map(|&(_, i)| i));
            out.class.push(class as u8);
            out.instance.push(instance);
        }
    }
    out
}

/// Most frequent value of a sorted sequence; the greatest of several.
fn most_frequent(sorted: impl Iterator<Item = u16>) -> u16 {
    let (mut best, mut best_count, mut value, mut count) = (0, 0, 0, 0);
    for v in sorted {
        count = if v == value { count + 1 } else { 1 };
        value = v;
        if count >= best_count {
            (best, best_count) = (value, count);
        }
    }
    best
}

/// The defects that the label image shows: area and box of each, with the body's numbers.
pub fn objects(labels: &Labels, cols: usize, pixel_mm2: f64, instances: &[Instance]) -> Vec<Object> {
    let mut boxes = vec![(0u64, [u32::MAX, u32::MAX, 0, 0]); instances.len()];
    for (row, line) in labels.instance.chunks_exact(cols).enumerate() {
        for (column, &id) in line.iter().enumerate().filter(|&(_, &id)| id > 0) {
            let (area, [left, top, right, bottom]) = &mut boxes[usize::from(id) - 1];
            *area += 1;
            (*left, *right) = ((*left).min(column as u32), (*right).max(column as u32 + 1));
            (*top, *bottom) = ((*top).min(row as u32), (*bottom).max(row as u32 + 1));
        }
    }
    instances
        .iter()
        .zip(boxes)
        .filter(|(_, (area, _))| *area > 0)
        .map(|(&instance, (area, [left, top, right, bottom]))| Object {
            instance,
            area_px: area,
            area_mm2: area as f64 * pixel_mm2,
            bbox: [left, top, right - left, bottom - top],
        })
        .collect()
}

/// Means of groups of `columns x rows` truth pixels; angles by their vectors, NaN left out.
pub fn bin_truth(truth: TruthMaps, cols: usize, columns: usize, rows: usize) -> TruthMaps {
    if columns == 1 && rows == 1 {
        return truth;
    }
    let mean = |map: Vec<f32>| bin_map(map, cols, columns, rows, f32::NAN, |v| !v.is_nan());
    // An azimuth is an axis: its double is a direction, and directions are averaged as vectors.
    let part =
        |f: fn(f32) -> f32| -> Vec<f32> { truth.fibre_azimuth.iter().map(|&a| f((2.0 * a).to_radians())).collect() };
    let (cos, sin) = (mean(part(libm::cosf)), mean(part(libm::sinf)));
    TruthMaps {
        height: mean(truth.height),
        fibre_azimuth: cos.iter().zip(&sin).map(|(c, s)| 0.5 * atan2(*s, *c).to_degrees()).collect(),
        fibre_dive: mean(truth.fibre_dive),
    }
}

/// Means of groups of `columns x rows` pixels for which `valid` holds; `missing` where none does.
pub fn bin_map(
    map: Vec<f32>,
    cols: usize,
    columns: usize,
    rows: usize,
    missing: f32,
    valid: impl Fn(f32) -> bool,
) -> Vec<f32> {
    if columns == 1 && rows == 1 {
        return map;
    }
    let mut out = Vec::with_capacity(map.len() / columns / rows);
    for band in map.chunks_exact(cols * rows) {
        for column in 0..cols / columns {
            let (mut sum, mut count) = (0.0f64, 0u32);
            for line in band.chunks_exact(cols) {
                for &v in line[column * columns..(column + 1) * columns].iter().filter(|v| valid(**v)) {
                    sum += f64::from(v);
                    count += 1;
                }
            }
            out.push(if count > 0 { (sum / f64::from(count)) as f32 } else { missing });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn majority_wins_and_ties_go_to_the_defect() {
        let labels = Labels { class: vec![1, 1, 2, 1, 1, 2, 2, 0], instance: vec![0, 0, 3, 0, 0, 3, 3, 0] };
        let binned = bin(labels, 4, 2, 2);
        assert_eq!(binned.class, vec![1, 2]);
        assert_eq!(binned.instance, vec![0, 3]);
    }

    #[test]
    fn objects_have_the_boxes_of_their_pixels() {
        let labels = Labels { class: vec![0; 12], instance: vec![0, 0, 2, 2, 0, 0, 2, 0, 0, 0, 0, 0] };
        let instance = |id| Instance {
            id,
            class: Class::SoundKnot,
            state: Class::SoundKnot,
            within: 0,
            x_mm: 0.0,
            y_mm: 0.0,
            diameter_mm: 1.0,
            dive_deg: 90.0,
            death_radius_mm: f64::NAN,
            severity: f64::NAN,
        };
        let found = objects(&labels, 4, 0.5, &[instance(1), instance(2)]);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].instance.id, found[0].area_px, found[0].bbox), (2, 3, [2, 0, 2, 2]));
        assert!((found[0].area_mm2 - 1.5).abs() < 1e-12);
    }

    #[test]
    fn azimuth_is_averaged_as_an_axis() {
        let truth =
            TruthMaps { height: vec![1.0, 3.0], fibre_azimuth: vec![89.0, -89.0], fibre_dive: vec![10.0, f32::NAN] };
        let binned = bin_truth(truth, 2, 2, 1);
        assert!((binned.fibre_azimuth[0].abs() - 90.0).abs() < 1e-3, "{}", binned.fibre_azimuth[0]);
        assert_eq!((binned.height[0], binned.fibre_dive[0]), (2.0, 10.0));
    }
}
