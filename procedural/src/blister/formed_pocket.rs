//! One formed pocket: height and thickness of its film.
//!
//! Models: a section that is a function of the distance e inwards from the pocket's outline: the edge's radius, a
//! straight wall at the draft angle, the shoulder's radius, and a roof with a crown (1 - q^2)^2; slopes are continuous
//! everywhere. Thickness t = t0 / (1 + thinning beta g), where g is the drawn share of the depth and larger on the
//! shoulder, which meets the mould last. The factor beta follows from the volume of film: the integral of t over the
//! formed area is t0 times the flat area where `thinning` is 1.
//! Source: mean thinning by area ratio (Throne 1996); that a wall thins steadily towards a corner is the classic
//! result for vacuum forming into a cavity (Williams 1970). Neglected: bending of the film, its flow along the wall.

use glam::Vec2;

use super::outline::{Outline, OutlinePoint};
use super::parameters::{Pocket, Web};
use super::tablet::TabletForm;

/// Extra draw of the middle of the shoulder, as a share of the whole depth [1].
const CORNER: f32 = 0.5;
/// Room that no tablet uses, see the margins of poses [mm].
const BESIDE_MM: f32 = 0.08;
/// Least radius of the roof inside its rim [mm].
const ROOF_MM: f32 = 0.5;

/// Height above the flange as a function of the distance inwards.
#[derive(Debug, Clone, Copy)]
struct PocketSection {
    /// Radius of edge and of shoulder [mm].
    radius: [f32; 2],
    /// Where the wall begins, where it ends, and where the roof begins [mm].
    ends: [f32; 3],
    /// Height where the wall begins [mm].
    foot: f32,
    /// Rise of the wall [1].
    steep: f32,
    /// Height of the roof's rim [mm].
    depth: f32,
}

/// The form that all pockets of a pack share.
#[derive(Debug, Clone)]
pub struct FormedPocket {
    /// Outline on the flange.
    pub outline: Outline,
    /// Long axis in the card [1].
    pub axis: Vec2,
    section: PocketSection,
    crown: f32,
    flat_mm: f32,
    thinning: f32,
}

/// The film of a pocket at one place.
#[derive(Debug, Clone, Copy)]
pub struct PocketFilm {
    /// Distance inwards from the outline, or from the rim on the roof; negative outside the pocket [mm].
    pub inset: f32,
    /// Height above the flange [mm].
    pub rise: f32,
    /// Its gradient in the axes of the card [1].
    pub slope: Vec2,
    /// How far it is drawn, 0 on the flange [1].
    pub drawn: f32,
}

impl PocketSection {
    fn new(pocket: &Pocket, depth: f32) -> Self {
        let (sine, cosine) = libm::sincosf((90.0 - pocket.draft_deg as f32).to_radians());
        let radii = [pocket.edge_radius_mm as f32, pocket.shoulder_radius_mm as f32];
        // Radii that take more than the whole depth shrink together, and no wall is left.
        let bent = (radii[0] + radii[1]) * (1.0 - cosine);
        let radius = radii.map(|r| r * (depth / bent).min(1.0));
        let wall = (depth - (radius[0] + radius[1]) * (1.0 - cosine)).max(0.0);
        let begin = radius[0] * sine;
        let end = begin + wall * cosine / sine;
        Self {
            radius,
            ends: [begin, end, end + radius[1] * sine],
            foot: radius[0] * (1.0 - cosine),
            steep: sine / cosine,
            depth,
        }
    }

    /// Height [mm] and slope [1] at `e` inwards.
    #[inline]
    fn at(&self, e: f32) -> (f32, f32) {
        let [begin, end, roof] = self.ends;
        if e <= 0.0 {
            (0.0, 0.0)
        } else if e < begin {
            let up = (self.radius[0] * self.radius[0] - e * e).sqrt();
            (self.radius[0] - up, e / up)
        } else if e < end {
            (self.foot + self.steep * (e - begin), self.steep)
        } else if e < roof {
            let left = roof - e;
            let up = (self.radius[1] * self.radius[1] - left * left).max(0.0).sqrt();
            (self.depth - self.radius[1] + up, (left / up.max(1.0e-6)).min(self.steep))
        } else {
            (self.depth, 0.0)
        }
    }
}

impl FormedPocket {
    /// Pockets for that tablet; `slack` is what the card's warp takes of the room below and above it [mm].
    pub fn new(pocket: &Pocket, web: &Web, form: &TabletForm, slack: f32) -> Self {
        let (sine, cosine) = libm::sincosf((pocket.turn_deg as f32).to_radians());
        let flat_mm = web.thickness_mm as f32;
        let crown = pocket.dome_mm as f32;
        // The roof's rim may lie lower than the room asked for over a convex tablet's middle.
        let spare = crown.min(0.5 * form.cap_mm()).min(0.8 * pocket.headroom_mm as f32);
        let depth = form.thickness_mm() + pocket.headroom_mm as f32 + 2.0 * slack - spare;
        let section = PocketSection::new(pocket, depth);
        let short = form.outline().half().y;
        let clearance = pocket.clearance_mm as f32 + BESIDE_MM;
        let fits = |room: f32| {
            let half = short + clearance + room;
            (0..=200).all(|i| {
                let e = half * i as f32 / 200.0;
                let inset = e - room - clearance;
                let (rise, slope) = section.at(e);
                let q = ((half - e) / (half - section.ends[2])).min(1.0);
                let rise = rise + crown * (1.0 - q * q) * (1.0 - q * q);
                let below = rise + flat_mm - flat_mm * (1.0 + slope * slope).sqrt();
                inset < -clearance || below >= form.top_mm(inset.max(0.0)) + 2.0 * slack
            })
        };
        let (mut low, mut high) = ((section.ends[2] + ROOF_MM - short - clearance).max(0.0), section.ends[2] + ROOF_MM);
        if !fits(low) {
            for _ in 0..24 {
                let middle = 0.5 * (low + high);
                if fits(middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            low = high;
        }
        Self {
            outline: form.outline().grown(low + clearance),
            axis: Vec2::new(cosine, sine),
            section,
            crown,
            flat_mm,
            thinning: web.thinning as f32,
        }
    }

    /// Depth of the roof's rim and height of its crown above that [mm].
    pub fn depth_mm(&self) -> (f32, f32) {
        (self.section.depth, self.crown)
    }

    /// Steepest slope of the crown [1].
    pub fn crown_slope(&self) -> f32 {
        // (1 - q^2)^2 is steepest at q = 1 / sqrt(3).
        1.54 * self.crown / (self.outline.half().y - self.section.ends[2])
    }

    /// Half the box around a pocket in the axes of the card [mm].
    pub fn reach(&self) -> Vec2 {
        self.outline.reach(self.axis)
    }

    /// The film at `p` from the pocket's middle, formed `factor` times as deep [mm].
    #[inline]
    pub fn skin(&self, p: Vec2, factor: f32) -> PocketFilm {
        let own = Vec2::new(self.axis.dot(p), self.axis.perp_dot(p));
        let [_, end, roof] = self.section.ends;
        let (inset, rise, slope, drawn) = match self.outline.place(own, roof) {
            OutlinePoint::Wall(inset, gradient) => {
                let (rise, slope) = self.section.at(inset);
                let x = ((inset - end) / (roof - end)).clamp(0.0, 1.0);
                (inset, rise, slope * gradient, rise / self.section.depth + CORNER * 4.0 * x * (1.0 - x))
            }
            OutlinePoint::Roof(square, gradient) => {
                let left = 1.0 - square;
                (roof, self.section.depth + self.crown * left * left, -2.0 * self.crown * left * gradient, 1.0)
            }
        };
        let slope = factor * (slope.x * self.axis + slope.y * self.axis.perp());
        PocketFilm { inset, rise: factor * rise, slope, drawn }
    }

    /// Distances from `p`, from the pocket's middle, to the pocket's ends against the unit vector `way` and along it
    /// [mm].
    pub fn ends(&self, p: Vec2, way: Vec2) -> [f32; 2] {
        let own = |v: Vec2| Vec2::new(self.axis.dot(v), self.axis.perp_dot(v));
        self.outline.ends(own(p), own(way))
    }

    /// What the film's thickness is divided by, less one, where it is drawn to the full: from the volume of film [1].
    pub fn stretch(&self, factor: f32) -> f32 {
        // Flat area, formed area and draw of each patch.
        let patches: Vec<[f64; 3]> = self
            .outline
            .areas(self.section.ends[2])
            .into_iter()
            .map(|(own, area)| {
                let skin = self.skin(own.x * self.axis + own.y * self.axis.perp(), factor);
                [area, area * (1.0 + skin.slope.length_squared()).sqrt(), skin.drawn].map(f64::from)
            })
            .collect();
        let flat: f64 = patches.iter().map(|[flat, ..]| flat).sum();
        let volume = |beta: f64| patches.iter().map(|[_, formed, drawn]| formed / (1.0 + beta * drawn)).sum::<f64>();
        let (mut low, mut high) = (0.0, 64.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if volume(middle) > flat {
                low = middle;
            } else {
                high = middle;
            }
        }
        (0.5 * (low + high)) as f32
    }

    /// Thickness of film drawn so far [mm].
    #[inline]
    pub fn thickness_mm(&self, drawn: f32, stretch: f32) -> f32 {
        self.flat_mm / (1.0 + self.thinning * stretch * drawn)
    }
}
