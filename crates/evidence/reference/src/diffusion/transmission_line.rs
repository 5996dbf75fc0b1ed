//! Transmission line of waves in plane layers, behind [`super::slab`], whose head has the equations.
//!
//! Potential Phi / n^2, current J, stiffness n^2 D_zz. All functions are those of q t, and none divides by q, so that a
//! wave without loss is no exception.

use glam::{DMat2, DVec2};

use super::tensor::{Diffusive, moments};
use transport::stack::{Stack, Substrate};

/// Where a share of the light begins to diffuse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiffuseSource {
    /// Share of the incident light [1].
    pub share: f64,
    /// Its layer.
    pub layer: usize,
    /// Depth below the top of that layer [mm].
    pub depth: f64,
    /// Where its light comes out, on average: place beside the entry, with the drift on the way up [mm].
    pub exit: DVec2,
}

/// A layer of the transmission line.
#[derive(Debug, Clone)]
pub(super) struct LineSection {
    pub medium: Diffusive,
    pub thickness: f64,
    /// What is left of the tensor in the plane [mm].
    pub plane: DMat2,
    /// n^2 D_zz [mm].
    pub stiffness: f64,
    /// Resistance of the interface above it; 0 on top [1].
    pub resistance: f64,
}

/// Layers ready for waves.
#[derive(Debug, Clone)]
pub(super) struct TransmissionLine {
    pub sections: Vec<LineSection>,
    /// z_e above the first and below the last layer [mm].
    pub ends: [f64; 2],
    /// Refractive index below [1].
    pub below: f64,
}

/// tanh(q t) / q.
fn tanh_over(q: f64, t: f64) -> f64 {
    let x = q * t;
    if x < 1e-6 { t } else { libm::tanh(x) / q }
}

impl TransmissionLine {
    pub fn new(stack: &Stack) -> Result<Self, String> {
        let mut sections: Vec<LineSection> = Vec::new();
        for (index, layer) in stack.layers.iter().enumerate() {
            if layer.coat < 1.0 {
                return Err(format!("layer {index} has a coat, which diffusion knows nothing of; use the path model"));
            }
            let medium = Diffusive::new(layer, index)?;
            let resistance = sections.last().map_or(0.0, |above| resistance(above.medium.n, layer.n));
            let stiffness = layer.n * layer.n * medium.d.z_axis.z;
            let plane = medium.sheared();
            sections.push(LineSection { medium, plane, thickness: layer.thickness, stiffness, resistance });
            if layer.thickness.is_infinite() {
                break;
            }
        }
        let Substrate::Index(below) = stack.below else {
            return Err("the stack lies on foil, which diffusion knows nothing of; use the path model".into());
        };
        let (Some(first), Some(last)) = (sections.first(), sections.last()) else {
            return Err("the stack has no layer; give it one".into());
        };
        let ends = [first.medium.extrapolation(stack.above), last.medium.extrapolation(below)];
        Ok(Self { sections, ends, below })
    }

    /// Wave number across the layers of each one for the wave `k`, and the impedance Phi / (n^2 J) seen from its top
    /// upwards and from its bottom downwards.
    pub fn wave(&self, k: DVec2, waves: &mut Vec<LayerWave>) {
        waves.clear();
        for section in &self.sections {
            let medium = &section.medium;
            let loss = k.dot(section.plane * k) + medium.mu_a;
            let q = (loss / medium.d.z_axis.z).max(1e-24).sqrt();
            waves.push(LayerWave { q, up: 0.0, down: 0.0 });
        }
        let last = waves.len() - 1;
        waves[0].up = tanh_over(waves[0].q, self.ends[0]) / self.sections[0].stiffness;
        for i in 1..=last {
            waves[i].up = self.through(i - 1, waves[i - 1].q, self.sections[i - 1].thickness, waves[i - 1].up)
                + self.sections[i].resistance;
        }
        waves[last].down = tanh_over(waves[last].q, self.ends[1]) / self.sections[last].stiffness;
        for i in (0..last).rev() {
            waves[i].down = self.through(i + 1, waves[i + 1].q, self.sections[i + 1].thickness, waves[i + 1].down)
                + self.sections[i + 1].resistance;
        }
    }

    /// Impedance in front of `t` mm of layer `i`, behind which it is `end`.
    fn through(&self, i: usize, q: f64, t: f64, end: f64) -> f64 {
        let stiffness = self.sections[i].stiffness;
        if t.is_infinite() {
            return 1.0 / (stiffness * q);
        }
        let tanh = tanh_over(q, t);
        (end + tanh / stiffness) / (1.0 + end * stiffness * q * q * tanh)
    }

    /// Share of a flux that is left after `t` mm of layer `i` with the impedance `end` behind it.
    fn left(&self, i: usize, q: f64, t: f64, end: f64) -> f64 {
        1.0 / (libm::cosh(q * t) + end * self.sections[i].stiffness * q * libm::sinh(q * t))
    }

    /// Fluxes that leave a source upwards and downwards, of a unit source.
    fn split(&self, source: &DiffuseSource, waves: &[LayerWave]) -> [f64; 2] {
        let (i, wave) = (source.layer, waves[source.layer]);
        let up = self.through(i, wave.q, source.depth, wave.up);
        let down = self.through(i, wave.q, self.sections[i].thickness - source.depth, wave.down);
        [down / (up + down), up / (up + down)]
    }

    /// Share of a unit source that leaves at the top, without the phase.
    pub fn exit(&self, source: &DiffuseSource, waves: &[LayerWave]) -> f64 {
        let [up, _] = self.split(source, waves);
        let mut depth = source.depth;
        let mut flux = up;
        for i in (0..=source.layer).rev() {
            flux *= self.left(i, waves[i].q, depth, waves[i].up);
            depth = if i > 0 { self.sections[i - 1].thickness } else { 0.0 };
        }
        flux
    }

    /// What a unit source sends out at the top and the bottom, and what each layer absorbs.
    pub fn energy(&self, source: &DiffuseSource, waves: &[LayerWave]) -> (f64, f64, Vec<f64>) {
        let [mut up, mut down] = self.split(source, waves);
        let mut absorbed = vec![0.0; self.sections.len()];
        for i in (0..=source.layer).rev() {
            let t = if i == source.layer { source.depth } else { self.sections[i].thickness };
            let left = up * self.left(i, waves[i].q, t, waves[i].up);
            absorbed[i] += up - left;
            up = left;
        }
        for i in source.layer..self.sections.len() {
            let t = self.sections[i].thickness - if i == source.layer { source.depth } else { 0.0 };
            let left = if t.is_infinite() { 0.0 } else { down * self.left(i, waves[i].q, t, waves[i].down) };
            absorbed[i] += down - left;
            down = left;
        }
        (up, down, absorbed)
    }
}

/// A wave in one layer.
#[derive(Debug, Clone, Copy)]
pub(super) struct LayerWave {
    pub q: f64,
    up: f64,
    down: f64,
}

/// Jump of Phi / n^2 for a unit flux from index `above` to `below` [1].
fn resistance(above: f64, below: f64) -> f64 {
    if above == below {
        return 0.0;
    }
    let ((first, second), (_, other)) = (moments(above / below), moments(below / above));
    6.0 * (second + other) / (above * above * (1.0 - 2.0 * first))
}
