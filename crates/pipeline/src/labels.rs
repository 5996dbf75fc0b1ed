//! Labels from the truth alone: noise-free hits and the body's own instances, never a measured map.

use base::{Class, Instance, Matter, atan2};
use dataset::record::{Labels, Object};
use scanner::specimen::Hit;

/// Writes the truth of one profile into row `row` of full-size maps of `hits.len()` columns.
pub(crate) fn label_row(hits: &[Hit], class: &mut [u8], instance: &mut [u16]) {
    for (column, hit) in hits.iter().enumerate() {
        class[column] = hit.matter.class as u8;
        instance[column] = hit.matter.instance;
    }
}

/// The hits of one profile at even positions along the line, as many as there are columns: at each the one whose true x
/// is nearest, among those that are lit and seen as long as one of these lies within a pitch. Positions more than half
/// a pitch beyond either end show the background.
pub(crate) fn on_grid(hits: &[Hit], first_mm: f64, pitch_mm: f64) -> Vec<Hit> {
    let of = |GridColumn { x, hit, beyond }| if beyond { background(hits[hit], x) } else { hits[hit] };
    grid_columns(hits, first_mm, pitch_mm).into_iter().map(of).collect()
}

/// Puts the light of a profile's hits onto the same positions; NaN beyond the ends.
pub(crate) fn light_on_grid(hits: &[Hit], first_mm: f64, pitch_mm: f64, light: &mut [f32]) {
    let own = light.to_vec();
    for (light, GridColumn { hit, beyond, .. }) in light.iter_mut().zip(grid_columns(hits, first_mm, pitch_mm)) {
        *light = if beyond { f32::NAN } else { own[hit] };
    }
}

/// A position of a grid.
struct GridColumn {
    /// Along the line [mm].
    x: f32,
    /// The hit that it shows.
    hit: usize,
    /// Whether it lies more than half a pitch beyond either end.
    beyond: bool,
}

/// What the positions of [`on_grid`] show.
fn grid_columns(hits: &[Hit], first_mm: f64, pitch_mm: f64) -> Vec<GridColumn> {
    let sorted = |seen_alone: bool| -> Vec<usize> {
        let is_asked = |&i: &usize| !seen_alone || (hits[i].lit && hits[i].seen);
        let mut sorted: Vec<usize> = (0..hits.len()).filter(is_asked).collect();
        // Of two at one position the upper one hides the lower.
        sorted.sort_by(|&a, &b| {
            let [a, b] = [&hits[a], &hits[b]];
            a.x.total_cmp(&b.x).then(b.surface.z.total_cmp(&a.surface.z))
        });
        sorted
    };
    let (seen, all) = (sorted(true), sorted(false));
    let nearest = |list: &[usize], x: f32| -> Option<(f32, usize)> {
        let above = list.partition_point(|&i| hits[i].x < x);
        // The first of those at one position.
        let below = above.checked_sub(1).map(|last| list.partition_point(|&i| hits[i].x < hits[list[last]].x));
        let candidates = [below, Some(above)].into_iter().flatten().filter_map(|i| list.get(i));
        let apart = |&i: &usize| ((hits[i].x - x).abs(), i);
        candidates.map(apart).reduce(|a, b| if b.0 < a.0 { b } else { a })
    };
    let at_column = |j: usize| {
        let x = (first_mm + j as f64 * pitch_mm) as f32;
        let near = nearest(&seen, x).filter(|(apart, _)| f64::from(*apart) <= pitch_mm).or_else(|| nearest(&all, x));
        let ends = [all.first(), all.last()].map(|end| end.map_or(x, |&i| hits[i].x));
        let beyond = f64::from((ends[0] - x).max(x - ends[1])) > 0.5 * pitch_mm;
        near.map(|(_, hit)| GridColumn { x, hit, beyond })
    };
    (0..hits.len()).filter_map(at_column).collect()
}

/// The background at `x`, with the surface of `hit`.
fn background(hit: Hit, x: f32) -> Hit {
    Hit { x, matter: Matter { class: Class::Background, instance: 0, ..hit.matter }, lit: false, seen: false, ..hit }
}

/// Writes the truth of one profile into a line of each map: what `of` says of a hit, NaN off the body.
pub(crate) fn truth_row<const MAPS: usize>(hits: &[Hit], mut maps: Vec<&mut [f32]>, of: impl Fn(&Hit) -> [f32; MAPS]) {
    for (column, hit) in hits.iter().enumerate() {
        let truth = if hit.matter.class == Class::Background { [f32::NAN; MAPS] } else { of(hit) };
        maps.iter_mut().zip(truth).for_each(|(map, truth)| map[column] = truth);
    }
}

/// The truth of a board: height, fibre azimuth and fibre dive.
pub(crate) fn fibre(hit: &Hit) -> [f32; 3] {
    let normal = glam::Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize();
    let fibre = hit.matter.medium.fibre;
    let rise = fibre.dot(normal).clamp(-1.0, 1.0);
    let along = fibre - normal * rise;
    // A fibre is an axis without sign: the end that points along the scan gives the angle.
    let sign = if along.y < 0.0 { -1.0 } else { 1.0 };
    let azimuth = atan2(sign * along.x, sign * along.y).to_degrees();
    [hit.surface.z, azimuth, atan2(-sign * rise, along.length()).to_degrees()]
}

/// The truth of a pack: height, thickness of the film and air below it.
pub(crate) fn film(hit: &Hit) -> [f32; 3] {
    let film = hit.matter.film.as_ref();
    let air = film.and_then(|film| film.gap_mm);
    [hit.surface.z, film.map_or(0.0, |film| film.thickness_mm), air.unwrap_or(0.0)]
}

/// Areas of the pixels of each image column, `columns` of `cols` sensor columns each, of which a middle one has
/// `pixel_mm2`: on a turntable steps are as long as the distance from the axis says, which `share` tells of a column
/// [mm^2].
pub fn areas(cols: usize, columns: usize, pixel_mm2: f64, share: impl Fn(f64) -> f64) -> Vec<f64> {
    let middle = |column: usize| (column as f64 + 0.5) * columns as f64 - 0.5;
    (0..cols / columns).map(|column| pixel_mm2 * share(middle(column))).collect()
}

/// Extent of an instance in the label image.
#[derive(Debug, Clone, Copy)]
struct InstanceExtent {
    /// Pixels.
    pixels: u64,
    /// Area of them [mm^2].
    area: f64,
    /// First column [px].
    left: u32,
    /// First row [px].
    top: u32,
    /// Column after the last [px].
    right: u32,
    /// Row after the last [px].
    bottom: u32,
}

/// Objects in the label image: area and box of each instance, what lies in it included, with the body's numbers;
/// `areas` are those of a pixel in each column [mm^2], `pixel_mm` is a pixel along the scan and along the line, NaN on
/// a turntable.
pub fn objects(labels: &Labels, areas: &[f64], pixel_mm: [f64; 2], instances: &[Instance]) -> Vec<Object> {
    let none = InstanceExtent { pixels: 0, area: 0.0, left: u32::MAX, top: u32::MAX, right: 0, bottom: 0 };
    let mut extents = vec![none; instances.len()];
    for (row, line) in labels.instance.chunks_exact(areas.len()).enumerate() {
        for (column, &id) in line.iter().enumerate() {
            let mut id = usize::from(id);
            while id > 0 {
                let of = &mut extents[id - 1];
                of.pixels += 1;
                of.area += areas[column];
                (of.left, of.right) = (of.left.min(column as u32), of.right.max(column as u32 + 1));
                (of.top, of.bottom) = (of.top.min(row as u32), of.bottom.max(row as u32 + 1));
                // What holds an instance has a smaller number, so this ends.
                id = usize::from(instances[id - 1].within).min(id - 1);
            }
        }
    }
    instances
        .iter()
        .zip(extents)
        .filter(|(_, of)| of.pixels > 0)
        .map(|(&instance, of)| Object {
            instance,
            area_px: of.pixels,
            area_mm2: of.area,
            bbox: [of.left, of.top, of.right - of.left, of.bottom - of.top],
            extent_mm: [f64::from(of.bottom - of.top) * pixel_mm[0], f64::from(of.right - of.left) * pixel_mm[1]],
        })
        .collect()
}

/// Classes of the defects among `objects`, and of those instances that no pixel shows; each by number.
pub(crate) fn defects(objects: &[Object], instances: &[Instance]) -> (Vec<Class>, Vec<Class>) {
    let shown = |own: &&Instance| objects.iter().any(|object| object.instance.id == own.id);
    let defects = instances.iter().filter(|own| own.class.is_defect());
    let (shown, unseen): (Vec<&Instance>, Vec<&Instance>) = defects.partition(shown);
    let classes = |own: Vec<&Instance>| own.into_iter().map(|own| own.class).collect();
    (classes(shown), classes(unseen))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_have_the_boxes_of_their_pixels() {
        let labels = Labels { class: vec![0; 12], instance: vec![0, 0, 2, 2, 0, 0, 2, 0, 0, 0, 0, 0] };
        let found = objects(&labels, &[0.5; 4], [0.25, 2.0], &[instance(1, 0), instance(2, 0)]);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].instance.id, found[0].area_px, found[0].bbox), (2, 3, [2, 0, 2, 2]));
        assert!((found[0].area_mm2 - 1.5).abs() < 1e-12);
        assert_eq!(found[0].extent_mm, [0.5, 4.0]);
    }

    fn instance(id: u16, within: u16) -> Instance {
        Instance {
            id,
            class: Class::SoundKnot,
            state: Class::SoundKnot,
            within,
            x_mm: 0.0,
            y_mm: 0.0,
            diameter_mm: 1.0,
            dive_deg: 90.0,
            death_radius_mm: f64::NAN,
            severity: f64::NAN,
            depth_mm: f64::NAN,
            knot: None,
        }
    }

    #[test]
    fn a_pocket_holds_what_lies_in_it() {
        // Pocket 1 in front, of which defect 3 hides a corner; pocket 2 shows nothing but its own defect 4.
        let labels = Labels { class: vec![0; 12], instance: vec![1, 1, 0, 0, 1, 3, 0, 0, 0, 3, 0, 4] };
        let found =
            objects(&labels, &[0.5; 4], [0.25, 2.0], &[instance(1, 0), instance(2, 0), instance(3, 1), instance(4, 2)]);
        let seen: Vec<_> = found.iter().map(|o| (o.instance.id, o.area_px, o.bbox)).collect();
        assert_eq!(seen, [(1, 5, [0, 0, 2, 3]), (2, 1, [3, 2, 1, 1]), (3, 2, [1, 1, 1, 2]), (4, 1, [3, 2, 1, 1])]);
    }
}
