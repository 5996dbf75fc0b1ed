//! Observer of photons in plane layers: what a batch did, and the answer of all batches together.

use base::normal;
use glam::DVec3;
use rand::Rng;

use super::next_event::LensEstimator;
use super::plane_layers::{PreparedLayer, StackGeometry, StackObserver};
use super::tracker::Photon;
use transport::answer::{AngleBin, Answer, Estimate, Question};
use transport::stack::Stack;

/// Half angle of the cone about the lens whose light is counted [rad].
const CONE_HALF_ANGLE: f64 = 0.087_266_462_599_716_48;

/// One batch's counts, in units of a photon's energy.
#[derive(Debug, Clone)]
pub(super) struct StackCounts {
    question: Question,
    lens: Option<LensEstimator>,
    /// Cosine of the half angle of the cone about the lens [1].
    inside: f64,
    /// Where on the laser line's width the photon stands for [mm].
    beside: f64,
    thrown: f64,
    reflected: f64,
    transmitted: f64,
    unscattered: f64,
    absorbed: Vec<f64>,
    towards: f64,
    /// Light into the cone about the lens.
    cone: f64,
    up: Vec<f64>,
    down: Vec<f64>,
    line: Vec<f64>,
    /// Light towards the lens by row.
    seen: Vec<f64>,
    /// Where all azimuths are alike: cosines of the tilts between which light counts as seen, and the lens's azimuth.
    ring: Option<([f64; 2], DVec3)>,
    point: Vec<f64>,
    /// Light towards the lens by row and length of path, `[2 rows + 1][PATH_STEPS]`; empty where nobody asks.
    paths: Vec<[f64; PATH_STEPS]>,
}

/// Steps of the lengths of path in [`seen_paths`](super::seen_paths).
pub const PATH_STEPS: usize = 160;
/// Ratio of the ends of a step [1].
const PATH_STEP_RATIO: f64 = 1.1;
/// Where the first one begins [mm].
const SHORTEST_PATH_MM: f64 = 1e-3;

/// The middle of a step of lengths of path [mm].
pub fn step_path_mm(step: usize) -> f64 {
    SHORTEST_PATH_MM * libm::pow(PATH_STEP_RATIO, step as f64 + 0.5)
}

/// The step that holds a length of path; the first and the last hold what lies beyond.
fn path_step(path_mm: f64) -> usize {
    let step = libm::log(path_mm / SHORTEST_PATH_MM) / libm::log(PATH_STEP_RATIO);
    step.clamp(0.0, PATH_STEPS as f64 - 1.0) as usize
}

impl StackCounts {
    /// The same, with lengths of path, where light within `half_angle` of the lens counts as seen [rad].
    pub(super) fn with_paths(self, stack: &Stack, question: &Question, half_angle: f64) -> Self {
        let paths = vec![[0.0; PATH_STEPS]; self.seen.len()];
        Self { paths, ring: ring(stack, question, half_angle), inside: libm::cos(half_angle), ..self }
    }

    /// Light that the lens sees leave at `y` [mm] after a path.
    #[inline]
    fn see(&mut self, y: f64, light: f64, path_mm: f64) {
        if let Some(row) = self.row(y) {
            self.seen[row] += light;
            if let Some(steps) = self.paths.get_mut(row) {
                steps[path_step(path_mm)] += light;
            }
        }
    }

    /// What was counted by row and length of path.
    pub(super) fn into_paths(self) -> Vec<[f64; PATH_STEPS]> {
        self.paths
    }

    pub(super) fn new(geometry: &StackGeometry, stack: &Stack, question: &Question) -> Self {
        let side = if question.cells > 0 { 2 * question.cells + 1 } else { 0 };
        Self {
            question: *question,
            lens: LensEstimator::new(geometry, question.view),
            inside: libm::cos(CONE_HALF_ANGLE),
            ring: ring(stack, question, CONE_HALF_ANGLE),
            beside: 0.0,
            thrown: 0.0,
            reflected: 0.0,
            transmitted: 0.0,
            unscattered: 0.0,
            absorbed: vec![0.0; geometry.layers.len()],
            towards: 0.0,
            cone: 0.0,
            up: vec![0.0; question.angles],
            down: vec![0.0; question.angles],
            line: vec![0.0; 2 * question.rows + 1],
            seen: vec![0.0; 2 * question.rows + 1],
            point: vec![0.0; side * side],
            paths: Vec::new(),
        }
    }

    /// A photon begins of which the surface threw back the share `thrown`; `line` draws its place on the line's width.
    pub(super) fn begin(&mut self, thrown: f64, line: &mut impl Rng) {
        self.thrown += thrown;
        if self.question.line_mm > 0.0 {
            self.beside = self.question.line_mm * normal(line);
        }
    }

    /// The row of a photon that leaves at `y` [mm], if it is among them.
    fn row(&self, y: f64) -> Option<usize> {
        let rows = self.question.rows as i64;
        let row = ((y + self.beside) / self.question.row_mm).round() as i64 + rows;
        (0..=2 * rows).contains(&row).then_some(row as usize)
    }
}

/// Tilts within `half_angle` of the lens's, as cosines, and its azimuth, if the stack and the light on it have none
/// themselves: then light at any azimuth is as good as that towards the lens, turned about the normal.
fn ring(stack: &Stack, question: &Question, half_angle: f64) -> Option<([f64; 2], DVec3)> {
    let view = question.view;
    let tilt = libm::acos(view.z.clamp(-1.0, 1.0));
    let fits = view.z > 0.0 && tilt > 1.5 * half_angle && tilt + half_angle < std::f64::consts::FRAC_PI_2;
    let azimuth = DVec3::new(view.x, view.y, 0.0).normalize_or_zero();
    let cosines = [libm::cos(tilt + half_angle), libm::cos(tilt - half_angle)];
    (fits && stack.is_round() && question.incidence == Some(0.0)).then_some((cosines, azimuth))
}

/// y of where a photon leaves, once all is turned about the normal so that it leaves at `azimuth` [mm].
fn turned_to(azimuth: DVec3, photon: &Photon) -> Option<f64> {
    let (position, direction) = (photon.position, photon.direction);
    let flat = (direction.x * direction.x + direction.y * direction.y).sqrt();
    // Sine and cosine of the turn from the photon's azimuth to the lens's.
    let cos = (direction.x * azimuth.x + direction.y * azimuth.y) / flat;
    let sin = (direction.x * azimuth.y - direction.y * azimuth.x) / flat;
    (flat > 0.0).then_some(position.x * sin + position.y * cos)
}

impl StackObserver for StackCounts {
    #[inline]
    fn collide(&mut self, photon: &Photon, layer: &PreparedLayer, rng: &mut impl Rng) {
        let Some(lens) = &self.lens else { return };
        let light = lens.estimate(photon, layer, rng);
        self.towards += light;
        if light > 0.0 {
            let (exit, way) = lens.exit(photon);
            self.see(exit.y, light, photon.path + way);
        }
    }

    #[inline]
    fn absorb(&mut self, layer: usize, weight: f64) {
        self.absorbed[layer] += weight;
    }

    fn leave(&mut self, photon: &Photon) {
        let (weight, up) = (photon.weight, photon.direction.z > 0.0);
        let scattered = photon.turned + photon.guided > 0;
        let bins = self.up.len() as f64;
        let bin = libm::acos(photon.direction.z.abs().min(1.0)) / std::f64::consts::FRAC_PI_2 * bins;
        let angles = if up { &mut self.up } else { &mut self.down };
        if scattered && let Some(angle) = angles.get_mut(bin as usize) {
            *angle += weight;
        }
        let in_cone = scattered && photon.direction.dot(self.question.view) > self.inside;
        self.cone += if in_cone { weight } else { 0.0 };
        let seen = match self.ring {
            _ if self.lens.is_some() => None,
            Some(([low, high], azimuth)) => {
                let inside = scattered && (low..high).contains(&photon.direction.z);
                inside.then(|| turned_to(azimuth, photon)).flatten()
            }
            None => in_cone.then_some(photon.position.y),
        };
        if let Some(y) = seen {
            self.see(y, weight, photon.path);
        }
        if !up {
            self.transmitted += weight;
            self.unscattered += if scattered { 0.0 } else { weight };
            return;
        }
        self.reflected += weight;
        if let Some(row) = self.row(photon.position.y) {
            self.line[row] += weight;
        }
        let cells = self.question.cells as i64;
        let cell = |v: f64| (v / self.question.cell_mm).round() as i64 + cells;
        let (x, y, side) = (cell(photon.position.x), cell(photon.position.y), 2 * cells + 1);
        if cells > 0 && (0..side).contains(&x) && (0..side).contains(&y) {
            self.point[(y * side + x) as usize] += weight;
        }
    }
}

/// What all batches of `each` photons say together.
pub(super) fn answer(counts: &[StackCounts], each: u64, stack: &Stack, question: &Question) -> Answer {
    let each = each as f64;
    let mean = |pick: &dyn Fn(&StackCounts) -> f64| Estimate::of(counts.iter().map(|count| pick(count) / each));
    let bins = question.angles;
    let angles = (0..bins).map(|bin| {
        let edge = |b: usize| std::f64::consts::FRAC_PI_2 * b as f64 / bins as f64;
        let solid = std::f64::consts::TAU * (libm::cos(edge(bin)) - libm::cos(edge(bin + 1)));
        AngleBin {
            from_deg: edge(bin).to_degrees(),
            to_deg: edge(bin + 1).to_degrees(),
            reflected: mean(&|count| count.up[bin] / solid),
            transmitted: mean(&|count| count.down[bin] / solid),
        }
    });
    let solid = std::f64::consts::TAU * (1.0 - libm::cos(CONE_HALF_ANGLE));
    let factor = std::f64::consts::PI / (solid * question.view.z.abs());
    let cone = mean(&|count| count.cone * factor);
    let seen = match ring(stack, question, CONE_HALF_ANGLE) {
        // Estimated like all light towards the lens.
        _ if counts[0].lens.is_some() => 1.0,
        // Against Lambert's law, which sends a share cos^2 to cos^2 between two tilts.
        Some(([low, high], _)) => 1.0 / (high * high - low * low),
        None => factor,
    };
    Answer {
        model: "path".into(),
        specular: counts.iter().map(|count| count.thrown).sum::<f64>() / (each * counts.len() as f64),
        reflectance: mean(&|count| count.reflected),
        transmittance: mean(&|count| count.transmitted),
        unscattered: mean(&|count| count.unscattered),
        absorbed: (0..stack.layers.len()).map(|layer| mean(&|count| count.absorbed[layer])).collect(),
        towards_lens: Some(if counts[0].lens.is_some() { mean(&|count| count.towards) } else { cone }),
        cone: Some(cone),
        angles: angles.collect(),
        row_mm: question.row_mm,
        line: (0..=2 * question.rows).map(|row| mean(&|count| count.line[row])).collect(),
        seen: (0..=2 * question.rows).map(|row| mean(&|count| count.seen[row] * seen)).collect(),
        cell_mm: question.cell_mm,
        point: (0..counts[0].point.len()).map(|cell| mean(&|count| count.point[cell])).collect(),
    }
}
