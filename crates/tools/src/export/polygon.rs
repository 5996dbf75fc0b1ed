//! Masks as polygons that give the same pixels again.
//!
//! The outline of a mask runs along the sides of its pixels, a little inside of them. So programs that take a vertex
//! for the pixel that it lies in (`cv2.fillPoly` after a cast to whole numbers, as Ultralytics does) draw the outline
//! on pixels of the mask alone, and those that fill what lies within the line (pycocotools) find the middles of the
//! same pixels. Parts hang together by sides of pixels, not by corners.
//!
//! One polygon has one line. A bridge goes to a hole along a row of the mask and back the same way, which adds nothing.
//! A bridge to another part leaves the mask: its line of one pixel is all that is added, and nothing where parts touch
//! at a corner. Bridges between parts are the shortest ones, as far as a flood from all outlines finds them (Kruskal
//! 1956).

use std::collections::{BTreeMap, VecDeque};

use super::objects::MaskedObject;
use super::sample::Region;

/// How far vertices lie inside of the pixel's sides [px]: more than single precision and six digits lose in images of
/// 32,000 columns, and less than a tenth, at which pycocotools rounds.
const INSET: f64 = 0.02;

/// Whether the parts of a mask are polygons of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PolygonParts {
    /// One polygon for each part.
    Apart,
    /// One polygon, with bridges between parts.
    Bridged,
}

/// A closed line: x and y of its vertices [px], 0 at the outer sides of the first pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Polygon(Vec<[f64; 2]>);

impl Polygon {
    /// x and y in turn, to hundredths [px].
    pub fn numbers(&self) -> Vec<f64> {
        self.0.iter().flatten().map(|place| (place * 100.0).round() / 100.0).collect()
    }

    /// Vertices.
    pub fn vertices(&self) -> &[[f64; 2]] {
        &self.0
    }

    fn push(&mut self, point: [f64; 2]) {
        if self.0.last() != Some(&point) {
            self.0.push(point);
        }
    }
}

/// The polygons of an object's mask: one for each part, or one.
pub(super) fn polygons(object: &MaskedObject, parts: PolygonParts) -> Vec<Polygon> {
    polygons_of(object.bbox, |row, col| object.is_set(row, col), parts)
}

/// The polygons of what is set in a box of the image.
fn polygons_of(bbox: Region, is_set: impl Fn(usize, usize) -> bool, parts: PolygonParts) -> Vec<Polygon> {
    let mask = LocalMask::of(bbox, is_set);
    let mut outlines = Outlines { rings: mask.rings(), bridges: Vec::new() };
    outlines.reach_holes(&mask);
    if parts == PolygonParts::Bridged {
        outlines.reach_parts(&mask);
    }
    let origin = [bbox.left as f64, bbox.top as f64];
    outlines.tours().into_iter().map(|points| shifted(points, origin)).collect()
}

fn shifted(mut polygon: Polygon, [left, top]: [f64; 2]) -> Polygon {
    polygon.0.iter_mut().for_each(|[x, y]| {
        *x += left;
        *y += top;
    });
    polygon
}

/// Mask within its box; nothing is set around it.
struct LocalMask {
    rows: i32,
    cols: i32,
    set: Vec<bool>,
}

/// Direction of a side: the mask lies to the right of it, rows grow downwards.
type Step = [i32; 2];

/// A corner of an outline: a pixel of the mask, and for x and y whether it is the far side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct RingVertex {
    pixel: [i32; 2],
    far: [bool; 2],
}

impl RingVertex {
    fn point(self) -> [f64; 2] {
        [0, 1].map(|axis| f64::from(self.pixel[axis]) + if self.far[axis] { 1.0 - INSET } else { INSET })
    }
}

/// A closed outline; its sides lead from each vertex to the next.
struct MaskRing {
    vertices: Vec<RingVertex>,
    is_hole: bool,
}

/// The end of a bridge: a ring, a side of it, and where on that.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BridgeEnd {
    ring: usize,
    side: usize,
    point: [f64; 2],
}

/// A pixel of an outline, its ring and its side.
type RingPixel = ([i32; 2], usize, usize);

/// The rings of a mask, and what ties them together.
struct Outlines {
    rings: Vec<MaskRing>,
    bridges: Vec<[BridgeEnd; 2]>,
}

impl LocalMask {
    fn of(bbox: Region, is_set: impl Fn(usize, usize) -> bool) -> Self {
        let Region { top, left, rows, cols } = bbox;
        let line = |row: usize| (left..left + cols).map(move |col| (row, col));
        let set = (top..top + rows).flat_map(line).map(|(row, col)| is_set(row, col)).collect();
        Self { rows: rows as i32, cols: cols as i32, set }
    }

    /// Place of a pixel in a list of all; `None` outside.
    fn place(&self, [x, y]: [i32; 2]) -> Option<usize> {
        let is_inside = (0..self.cols).contains(&x) && (0..self.rows).contains(&y);
        is_inside.then_some(y as usize * self.cols as usize + x as usize)
    }

    fn has(&self, pixel: [i32; 2]) -> bool {
        self.place(pixel).is_some_and(|place| self.set[place])
    }

    /// All outlines, in the order of their first upper sides.
    fn rings(&self) -> Vec<MaskRing> {
        let mut followed = vec![false; self.set.len()];
        let mut rings = Vec::new();
        for y in 0..self.rows {
            for x in 0..self.cols {
                let is_upper_side = self.has([x, y]) && !self.has([x, y - 1]);
                if is_upper_side && self.place([x, y]).is_some_and(|place| !followed[place]) {
                    rings.push(self.ring([x, y], &mut followed));
                }
            }
        }
        rings
    }

    /// The outline that begins with the upper side of a pixel.
    fn ring(&self, first: [i32; 2], followed: &mut [bool]) -> MaskRing {
        let (mut pixel, mut step): ([i32; 2], Step) = (first, [1, 0]);
        let (mut vertices, mut twice_area) = (Vec::new(), 0_i64);
        loop {
            if step == [1, 0] {
                self.place(pixel).into_iter().for_each(|place| followed[place] = true);
            }
            let ([dx, dy], [x, y]) = (step, pixel);
            // The corner at the end of this side, and what the outline does there: it turns about the pixel, goes on
            // along the next one, or turns to the one that juts out.
            let corner = [x + i32::from(dx + dy > 0), y + i32::from(dy - dx > 0)];
            twice_area += i64::from(corner[0]) * i64::from(dy) - i64::from(corner[1]) * i64::from(dx);
            let (ahead, jutting) = ([x + dx, y + dy], [x + dx + dy, y + dy - dx]);
            let (next, turned) = match (self.has(ahead), self.has(jutting)) {
                (false, _) => (pixel, [-dy, dx]),
                (true, false) => (ahead, step),
                (true, true) => (jutting, [dy, -dx]),
            };
            if turned != step {
                // What lies inwards of both sides is the mask.
                let inward = [turned[1] + dy, turned[0] + dx];
                let far = [inward[0] > 0, inward[1] < 0];
                vertices
                    .push(RingVertex { pixel: [corner[0] - i32::from(far[0]), corner[1] - i32::from(far[1])], far });
            }
            (pixel, step) = (next, turned);
            if (pixel, step) == (first, [1, 0]) {
                return MaskRing { vertices, is_hole: twice_area < 0 };
            }
        }
    }
}

impl MaskRing {
    fn next(&self, side: usize) -> RingVertex {
        self.vertices[(side + 1) % self.vertices.len()]
    }
}

impl Outlines {
    /// Bridges from each hole leftwards to the outline that stands there, which begins further left: none of them leads
    /// back.
    fn reach_holes(&mut self, mask: &LocalMask) {
        // Sides that have nothing to their left, by column and first row.
        let mut left_sides: BTreeMap<[i32; 2], (usize, usize)> = BTreeMap::new();
        for (number, ring) in self.rings.iter().enumerate() {
            for (side, from) in ring.vertices.iter().enumerate() {
                let to = ring.next(side);
                if !from.far[0] && from.pixel[0] == to.pixel[0] && !to.far[0] && from.point()[1] > to.point()[1] {
                    left_sides.insert(to.pixel, (number, side));
                }
            }
        }
        for (number, ring) in self.rings.iter().enumerate().filter(|(_, ring)| ring.is_hole) {
            let least = ring.vertices.iter().enumerate().min_by_key(|(_, vertex)| vertex.pixel);
            let Some((side, from)) = least else { continue };
            let [mut x, y] = from.pixel;
            while mask.has([x - 1, y]) {
                x -= 1;
            }
            let Some((_, &(target, target_side))) = left_sides.range(..=[x, y]).next_back() else { continue };
            let point = from.point();
            let bank = BridgeEnd { ring: target, side: target_side, point: [f64::from(x) + INSET, point[1]] };
            self.bridges.push([bank, BridgeEnd { ring: number, side, point }]);
        }
    }

    /// Bridges between parts: the shortest ones that tie all of them together.
    fn reach_parts(&mut self, mask: &LocalMask) {
        let mut parts = RingGroups((0..self.rings.len()).collect());
        self.bridges.iter().for_each(|[a, b]| parts.join(a.ring, b.ring));
        if (1..self.rings.len()).all(|ring| parts.root(ring) == parts.root(0)) {
            return;
        }
        // A flood from every pixel of every outline; each pixel keeps the one that came first.
        let pixels = self.pixels();
        let mut owner: Vec<Option<u32>> = vec![None; mask.set.len()];
        let mut wave = VecDeque::new();
        for (number, (pixel, ..)) in pixels.iter().enumerate() {
            if let Some(free) = mask.place(*pixel).filter(|place| owner[*place].is_none()) {
                owner[free] = Some(number as u32);
                wave.push_back(*pixel);
            }
        }
        while let Some([x, y]) = wave.pop_front() {
            let from = mask.place([x, y]).and_then(|place| owner[place]);
            for beside in AROUND.map(|[dx, dy]| [x + dx, y + dy]) {
                if let Some(free) = mask.place(beside).filter(|place| owner[*place].is_none()) {
                    owner[free] = from;
                    wave.push_back(beside);
                }
            }
        }
        let mut found = Vec::new();
        for y in 0..mask.rows {
            for x in 0..mask.cols {
                let owned = |pixel| mask.place(pixel).and_then(|place| owner[place]);
                let Some(a) = owned([x, y]) else { continue };
                for [dx, dy] in &AROUND[..4] {
                    let Some(b) = owned([x + dx, y + dy]) else { continue };
                    let [(from, ring, _), (to, other, _)] = [a, b].map(|number| pixels[number as usize]);
                    if parts.root(ring) != parts.root(other) {
                        let [along, across] = [0, 1].map(|axis| i64::from(from[axis] - to[axis]));
                        found.push((along * along + across * across, a.min(b), a.max(b)));
                    }
                }
            }
        }
        found.sort_unstable();
        for (_, a, b) in found {
            let [from, to] = [a, b].map(|number| pixels[number as usize]);
            if parts.root(from.1) != parts.root(to.1) {
                parts.join(from.1, to.1);
                let ends = [(from, to), (to, from)];
                self.bridges.push(ends.map(|(from, to)| self.bridge_end(&pixels, (from.0, from.1), to.0)));
            }
        }
    }

    /// The pixels of all outlines, each with ring and side, in order.
    fn pixels(&self) -> Vec<RingPixel> {
        let mut pixels = Vec::new();
        for (number, ring) in self.rings.iter().enumerate() {
            for (side, from) in ring.vertices.iter().enumerate() {
                let (mut pixel, to) = (from.pixel, ring.next(side).pixel);
                let step = [0, 1].map(|axis| (to[axis] - pixel[axis]).signum());
                pixels.push((pixel, number, side));
                while pixel != to {
                    pixel = [pixel[0] + step[0], pixel[1] + step[1]];
                    pixels.push((pixel, number, side));
                }
            }
        }
        pixels.sort_unstable();
        pixels
    }

    /// The place of a ring in a pixel that is nearest to another pixel.
    fn bridge_end(&self, pixels: &[RingPixel], (pixel, ring): ([i32; 2], usize), other: [i32; 2]) -> BridgeEnd {
        let wanted = [0, 1]
            .map(|axis| f64::from(pixel[axis]) + 0.5 + (0.5 - INSET) * f64::from((other[axis] - pixel[axis]).signum()));
        let on_side = |side: usize| {
            let ends = [self.rings[ring].vertices[side], self.rings[ring].next(side)].map(RingVertex::point);
            let point = [0, 1].map(|axis| {
                let (low, high) = (ends[0][axis].min(ends[1][axis]), ends[0][axis].max(ends[1][axis]));
                wanted[axis].clamp(low, high)
            });
            let off = (point[0] - wanted[0]).abs() + (point[1] - wanted[1]).abs();
            (off, BridgeEnd { ring, side, point })
        };
        let first = pixels.partition_point(|found| *found < (pixel, ring, 0));
        let sides = pixels[first..].iter().take_while(|found| (found.0, found.1) == (pixel, ring));
        let nearest = sides.map(|found| on_side(found.2)).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or_else(|| on_side(0).1, |(_, end)| end)
    }

    /// What each ring has along its way: its vertices, and between them the ends of bridges.
    fn ways(&self) -> Vec<Vec<([f64; 2], Option<usize>)>> {
        let mut ends_of: Vec<Vec<(usize, f64, usize)>> = self.rings.iter().map(|_| Vec::new()).collect();
        for (number, ends) in self.bridges.iter().enumerate() {
            for (end, BridgeEnd { ring, side, point }) in ends.iter().enumerate() {
                let from = self.rings[*ring].vertices[*side].point();
                let along = (point[0] - from[0]).abs() + (point[1] - from[1]).abs();
                ends_of[*ring].push((*side, along, 2 * number + end));
            }
        }
        let way = |(ring, mut ends): (&MaskRing, Vec<(usize, f64, usize)>)| {
            ends.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
            let mut ends = ends.into_iter().peekable();
            let mut way = Vec::new();
            for (side, vertex) in ring.vertices.iter().enumerate() {
                way.push((vertex.point(), None));
                while let Some((_, _, end)) = ends.next_if(|end| end.0 == side) {
                    way.push((self.bridges[end / 2][end % 2].point, Some(end)));
                }
            }
            way
        };
        self.rings.iter().zip(ends_of).map(way).collect()
    }

    /// Ways around all that is tied together: over each bridge, around what lies behind it, and back.
    fn tours(&self) -> Vec<Polygon> {
        let ways = self.ways();
        let mut place_of = vec![0; 2 * self.bridges.len()];
        for way in &ways {
            way.iter().enumerate().for_each(|(at, (_, end))| end.iter().for_each(|end| place_of[*end] = at));
        }
        let mut seen = vec![false; ways.len()];
        let mut tours = Vec::new();
        for (start, ring) in self.rings.iter().enumerate() {
            if ring.is_hole || seen[start] {
                continue;
            }
            let mut tour = Polygon::default();
            // Rings that were entered and not left: each with where it was entered and how far it was followed.
            let mut open = vec![(start, 0, 0)];
            seen[start] = true;
            while let Some((ring, entry, followed)) = open.pop() {
                let way = &ways[ring];
                let (point, end) = way[(entry + followed) % way.len()];
                tour.push(point);
                // Where it was entered it is left, back over the bridge.
                if followed == way.len() {
                    if let Some((ring, entry, followed)) = open.last() {
                        let way = &ways[*ring];
                        tour.push(way[(entry + followed - 1) % way.len()].0);
                    }
                    continue;
                }
                open.push((ring, entry, followed + 1));
                if let Some(there) = end.filter(|_| followed > 0).map(|end| end ^ 1) {
                    let other = self.bridges[there / 2][there % 2].ring;
                    if !std::mem::replace(&mut seen[other], true) {
                        open.push((other, place_of[there], 0));
                    }
                }
            }
            // The line is closed without its first vertex at its end.
            if tour.0.len() > 1 && tour.0.first() == tour.0.last() {
                tour.0.pop();
            }
            tours.push(tour);
        }
        tours
    }
}

/// The pixels about one; the first four are half of them.
const AROUND: [Step; 8] = [[1, 0], [0, 1], [1, 1], [-1, 1], [-1, 0], [0, -1], [-1, -1], [1, -1]];

/// Which rings hang together.
struct RingGroups(Vec<usize>);

impl RingGroups {
    fn root(&mut self, mut ring: usize) -> usize {
        while self.0[ring] != ring {
            self.0[ring] = self.0[self.0[ring]];
            ring = self.0[ring];
        }
        ring
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mask drawn as text: `#` is set.
    fn drawn(rows: &[&str]) -> (Region, Vec<Vec<bool>>) {
        let set: Vec<Vec<bool>> = rows.iter().map(|row| row.bytes().map(|c| c == b'#').collect()).collect();
        (Region { top: 0, left: 0, rows: set.len(), cols: set[0].len() }, set)
    }

    fn of(rows: &[&str], parts: PolygonParts) -> Vec<Polygon> {
        let (bbox, set) = drawn(rows);
        polygons_of(bbox, |row, col| set[row][col], parts)
    }

    /// Whether a point lies within a closed line, by even and odd crossings.
    fn is_inside(polygons: &[Polygon], [x, y]: [f64; 2]) -> bool {
        let crossings = |polygon: &Polygon| {
            let points = polygon.vertices();
            let sides = points.iter().zip(points.iter().cycle().skip(1));
            sides
                .filter(|([ax, ay], [bx, by])| (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax))
                .count()
        };
        polygons.iter().map(crossings).sum::<usize>() % 2 == 1
    }

    /// Pixels on a line between two, as they are drawn where it runs along rows and columns.
    fn walked(polygon: &Polygon, mut visit: impl FnMut([i32; 2])) {
        let pixel = |point: [f64; 2]| point.map(|n| n.floor() as i32);
        let points = polygon.vertices();
        for (from, to) in points.iter().zip(points.iter().cycle().skip(1)) {
            let (mut at, to) = (pixel(*from), pixel(*to));
            visit(at);
            while at != to {
                at = [0, 1].map(|axis| at[axis] + (to[axis] - at[axis]).signum());
                visit(at);
            }
        }
    }

    /// A pixel, a bar, steps: by hand.
    #[test]
    fn outlines_by_hand() {
        let whole = Polygon(vec![[0.98, 0.02], [0.98, 0.98], [0.02, 0.98], [0.02, 0.02]]);
        assert_eq!(of(&["#"], PolygonParts::Apart), [whole]);
        let stairs = of(&["#.", "##"], PolygonParts::Bridged);
        let expected = [[0.98, 0.02], [0.98, 1.02], [1.98, 1.02], [1.98, 1.98], [0.02, 1.98], [0.02, 0.02]];
        assert_eq!(stairs, [Polygon(expected.to_vec())]);
        assert_eq!(stairs[0].numbers()[..4], [0.98, 0.02, 0.98, 1.02]);
    }

    /// Masks with holes, in holes, at corners, by chance: what lies inside are their pixels, and lines leave them only
    /// on bridges between parts that do not touch.
    #[test]
    fn polygons_give_the_mask_again() {
        let mut state = 1_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 33
        };
        let nested = [
            "#########",
            "#.......#",
            "#.#####.#",
            "#.#...#.#",
            "#.#.#.#.#",
            "#.#...#.#",
            "#.#####.#",
            "#.......#",
            "#########",
        ];
        let mut masks = vec![drawn(&nested), drawn(&["#.#", ".#.", "#.#"]), drawn(&["###", "#.#", "###"])];
        for _ in 0..300 {
            let (rows, cols, share) = (1 + random() % 12, 1 + random() % 12, 1 + random() % 9);
            let mut set: Vec<Vec<bool>> =
                (0..rows).map(|_| (0..cols).map(|_| random() % 10 < share).collect()).collect();
            set[0][0] = true;
            masks.push((Region { top: 0, left: 0, rows: rows as usize, cols: cols as usize }, set));
        }
        let mut several = 0;
        for (bbox, set) in &masks {
            let is_set = |row: usize, col: usize| set[row][col];
            let apart = polygons_of(*bbox, is_set, PolygonParts::Apart);
            let bridged = polygons_of(*bbox, is_set, PolygonParts::Bridged);
            assert_eq!(bridged.len(), 1, "{set:?}");
            several += usize::from(apart.len() > 1);
            for polygons in [&apart, &bridged] {
                for (row, line) in set.iter().enumerate() {
                    for (col, set_here) in line.iter().enumerate() {
                        // Off the middle of pixels, where bridges may run.
                        let inside = is_inside(polygons, [col as f64 + 0.5 + 1e-4, row as f64 + 0.5 + 1e-5]);
                        assert_eq!(inside, *set_here, "{row} {col} {set:?} {polygons:?}");
                    }
                }
            }
            for polygon in &apart {
                walked(polygon, |[x, y]| assert!(set[y as usize][x as usize], "{x} {y} {set:?} {polygon:?}"));
            }
        }
        assert!(several > 100, "{several}");
    }

    /// Parts that touch at corners are tied there: no pixel is added.
    #[test]
    fn corners_tie_parts() {
        let mask = ["##..#", "##.#.", "..#..", ".#..#"];
        let one = of(&mask[..3], PolygonParts::Bridged);
        let (_, set) = drawn(&mask);
        walked(&one[0], |[x, y]| assert!(set[y as usize][x as usize], "{x} {y} {one:?}"));
        assert_eq!(of(&mask[..3], PolygonParts::Apart).len(), 4);
    }

    /// Thousands of holes and parts take neither the stack nor a time that grows with their square.
    #[test]
    fn many_holes_are_one_line() {
        let side = 600;
        let bbox = Region { top: 5, left: 7, rows: side, cols: side };
        let sieve = polygons_of(bbox, |row, col| row % 2 == 1 || col % 2 == 1, PolygonParts::Bridged);
        let dots = polygons_of(bbox, |row, col| row % 3 == 0 && col % 3 == 0, PolygonParts::Bridged);
        assert_eq!((sieve.len(), dots.len()), (1, 1));
        assert!(sieve[0].vertices().len() > 4 * 299 * 299 && dots[0].vertices().len() >= 4 * 200 * 200);
    }
}
