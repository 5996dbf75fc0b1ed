//! Counting: what a batch of photons did, and what all batches together say.

use glam::DVec3;
use procedural::normal;
use rand::Rng;

use super::towards::Lens;
use super::walk::{Photon, Prepared, Tally, Walk};
use crate::transport::answer::{Angle, Answer, Estimate, Question};
use crate::transport::stack::Stack;

/// Half angle of the cone about the lens whose light is counted [rad].
const CONE: f64 = 0.087_266_462_599_716_48;

/// One batch's counts, in units of a photon's energy.
#[derive(Debug, Clone)]
pub(super) struct Count {
    lens: Option<Lens>,
    view: DVec3,
    inside: f64,
    row_mm: f64,
    rows: i64,
    line_mm: f64,
    /// Where on the laser line's width the photon stands for [mm].
    beside: f64,
    cell_mm: f64,
    cells: i64,
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
    /// Light into the cone by row.
    seen: Vec<f64>,
    point: Vec<f64>,
}

impl Count {
    pub(super) fn new(walk: &Walk, question: &Question) -> Self {
        let (rows, cells) = (question.rows as i64, question.cells as i64);
        let side = if cells > 0 { 2 * question.cells + 1 } else { 0 };
        Self {
            lens: Lens::new(walk, question.view),
            view: question.view,
            inside: libm::cos(CONE),
            row_mm: question.row_mm,
            rows,
            line_mm: question.line_mm,
            beside: 0.0,
            cell_mm: question.cell_mm,
            cells,
            thrown: 0.0,
            reflected: 0.0,
            transmitted: 0.0,
            unscattered: 0.0,
            absorbed: vec![0.0; walk.layers.len()],
            towards: 0.0,
            cone: 0.0,
            up: vec![0.0; question.angles],
            down: vec![0.0; question.angles],
            line: vec![0.0; 2 * question.rows + 1],
            seen: vec![0.0; 2 * question.rows + 1],
            point: vec![0.0; side * side],
        }
    }

    /// A photon begins of which the surface threw back the share `thrown`; `line` draws its place on the line's width.
    pub(super) fn begin(&mut self, thrown: f64, line: &mut impl Rng) {
        self.thrown += thrown;
        if self.line_mm > 0.0 {
            self.beside = self.line_mm * normal(line);
        }
    }
}

impl Tally for Count {
    #[inline]
    fn collide(&mut self, photon: &Photon, layer: &Prepared, rng: &mut impl Rng) {
        if let Some(lens) = &self.lens {
            self.towards += lens.estimate(photon, layer, rng);
        }
    }

    #[inline]
    fn absorb(&mut self, layer: usize, weight: f64) {
        self.absorbed[layer] += weight;
    }

    fn leave(&mut self, photon: &Photon) {
        let (weight, up) = (photon.weight, photon.way.z > 0.0);
        let scattered = photon.turned + photon.guided > 0;
        let bins = self.up.len() as f64;
        let bin = libm::acos(photon.way.z.abs().min(1.0)) / std::f64::consts::FRAC_PI_2 * bins;
        let angles = if up { &mut self.up } else { &mut self.down };
        if scattered && let Some(angle) = angles.get_mut(bin as usize) {
            *angle += weight;
        }
        let row = ((photon.place.y + self.beside) / self.row_mm).round() as i64 + self.rows;
        let row = Some(row).filter(|row| (0..=2 * self.rows).contains(row));
        if scattered && photon.way.dot(self.view) > self.inside {
            self.cone += weight;
            if let Some(row) = row {
                self.seen[row as usize] += weight;
            }
        }
        if !up {
            self.transmitted += weight;
            self.unscattered += if scattered { 0.0 } else { weight };
            return;
        }
        self.reflected += weight;
        if let Some(row) = row {
            self.line[row as usize] += weight;
        }
        let cell = |v: f64| (v / self.cell_mm).round() as i64 + self.cells;
        let (x, y, side) = (cell(photon.place.x), cell(photon.place.y), 2 * self.cells + 1);
        if self.cells > 0 && (0..side).contains(&x) && (0..side).contains(&y) {
            self.point[(y * side + x) as usize] += weight;
        }
    }
}

/// What all batches of `each` photons say together.
pub(super) fn answer(counts: &[Count], each: u64, stack: &Stack, question: &Question) -> Answer {
    let each = each as f64;
    let mean = |pick: &dyn Fn(&Count) -> f64| Estimate::of(counts.iter().map(|count| pick(count) / each));
    let bins = question.angles;
    let angles = (0..bins).map(|bin| {
        let edge = |b: usize| std::f64::consts::FRAC_PI_2 * b as f64 / bins as f64;
        let solid = std::f64::consts::TAU * (libm::cos(edge(bin)) - libm::cos(edge(bin + 1)));
        Angle {
            from_deg: edge(bin).to_degrees(),
            to_deg: edge(bin + 1).to_degrees(),
            reflected: mean(&|count| count.up[bin] / solid),
            transmitted: mean(&|count| count.down[bin] / solid),
        }
    });
    let solid = std::f64::consts::TAU * (1.0 - libm::cos(CONE));
    let factor = std::f64::consts::PI / (solid * question.view.z.abs());
    let cone = mean(&|count| count.cone * factor);
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
        seen: (0..=2 * question.rows).map(|row| mean(&|count| count.seen[row] * factor)).collect(),
        cell_mm: question.cell_mm,
        point: (0..counts[0].point.len()).map(|cell| mean(&|count| count.point[cell])).collect(),
    }
}
