//! A board cut out of a picture: the picture with what is known of it, and the wood of one board as `procedural` asks
//! for it.
//!
//! `BoardPicture::new` analyses the picture once; `BoardPicture::cut` takes the board's part of it, mirrored or turned,
//! and finds the absorption that has its light with the board's own media, so that boards of unlike media from one
//! picture show it alike.
//!
//! Models: absorption and its depth are those of [`crate::AbsorptionMap`], or ([`Depth::Even`]) the face's colour down
//! to a depth and clear wood's mean below it. Fibres of the face go on below it as they are; in a knot all follows the
//! branch's axis. Scattering and index are clear wood's mean, in knots that of knot wood. Labels are the knots that
//! were found, or, where somebody gives a picture of classes, that alone: its patches of one class are the instances.
//! Mirroring changes the sign of the azimuth; turning end for end that of the dive. Limits: those of the maps; fibres
//! are blended over four pixels, so knots have a rim of a pixel.

use std::f32::consts::FRAC_PI_2;

use base::{Class, Instance, Medium};
use glam::{Vec2, Vec3};
use procedural::wood::{GivenMatter, GivenWood, Wood};

use crate::absorption::{LEVELS, absorption_of, means, relative_light};
use crate::components::{Patch, patches};
use crate::raster::{around, quantile};
use crate::{AbsorptionMap, Face, FibreMap, PictureAnalysis, PictureFault, PictureKnot, fibre_map};

/// Fibres are disturbed as far as this from a knot's outline [half axes]: as `media.knot_fibre_dispersion_deg` says.
const DISTURBED: f32 = 4.0;

/// Most patches of a picture of classes: instances have numbers of 16 bits, a board's border may part a patch, and the
/// board's own defects have numbers too.
const MOST_PATCHES: usize = 30_000;

/// How far below the face its colour goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Depth {
    /// A feature of width w lasts to a depth of about w.
    Feature,
    /// The face's colour down to this depth, clear wood's mean below it [mm].
    Even(f32),
}

/// A picture of wood with all that is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardPicture {
    /// Light of the wood over the mean of clear wood [1].
    light: Vec<f32>,
    fibres: FibreMap,
    /// Classes that somebody gives.
    classes: Option<Vec<Class>>,
    face: Face,
    depth: Depth,
}

impl BoardPicture {
    /// Analyses a picture; arguments as of [`fibre_map`].
    ///
    /// # Errors
    /// Those of [`fibre_map`].
    pub fn new(
        grey: &[f32],
        size: [usize; 2],
        pixel_mm: [f32; 2],
        settings: &PictureAnalysis,
        depth: Depth,
    ) -> Result<Self, PictureFault> {
        let fibres = fibre_map(grey, size, pixel_mm, settings)?;
        Self::with_fibres(grey, fibres, settings, depth)
    }

    /// A picture whose fibres are known from elsewhere.
    ///
    /// # Errors
    /// Those of a picture that does not serve, and a size other than the map's.
    pub fn with_fibres(
        grey: &[f32],
        fibres: FibreMap,
        settings: &PictureAnalysis,
        depth: Depth,
    ) -> Result<Self, PictureFault> {
        let light = relative_light(grey, &fibres, settings)?;
        Ok(Self { light, fibres, classes: None, face: settings.face, depth })
    }

    /// A map of fibres without a picture: every pixel has a share of clear wood's light, for instance the alpha of the
    /// thesis' maps.
    ///
    /// # Errors
    /// A number of shares other than that of the map's pixels.
    pub fn drawn(shares: &[f32], fibres: FibreMap, face: Face, depth: Depth) -> Result<Self, PictureFault> {
        let [rows, cols] = fibres.size;
        if shares.len() != rows * cols {
            return Err(PictureFault::Length { pixels: shares.len(), rows, cols });
        }
        Ok(Self { light: shares.to_vec(), fibres, classes: None, face, depth })
    }

    /// With a class for every pixel, in the place of the knots that were found as labels.
    ///
    /// # Errors
    /// More patches than instances can be told apart.
    ///
    /// # Panics
    /// Where there are not as many as pixels.
    pub fn labelled(mut self, classes: Vec<Class>) -> Result<Self, PictureFault> {
        assert_eq!(classes.len(), self.light.len(), "a class for each pixel");
        let patches = patches(&classes, self.fibres.size).1.len();
        if patches > MOST_PATCHES {
            return Err(PictureFault::Patches { patches, most: MOST_PATCHES });
        }
        self.classes = Some(classes);
        Ok(self)
    }

    /// Its fibres and knots.
    pub fn fibres(&self) -> &FibreMap {
        &self.fibres
    }

    /// Length (down the rows) and width of what it shows [mm].
    pub fn extent_mm(&self) -> [f32; 2] {
        [0, 1].map(|i| self.fibres.size[i] as f32 * self.fibres.pixel_mm[i])
    }

    /// The wood of a board as large as `wood` says, at the place that it says, with its media. A board that is larger
    /// than the picture gets the picture's border pixels beyond it.
    pub fn cut(&self, wood: &Wood) -> PicturedWood {
        let (board, place) = (&wood.board, &wood.picture);
        let side = |i: usize, mm: f64, share: f64| {
            let (pixels, pixel) = (self.fibres.size[i], f64::from(self.fibres.pixel_mm[i]));
            let count = ((mm / pixel).ceil() as usize + 1).min(pixels);
            let room = (pixels as f64 * pixel - mm).max(0.0) * share / pixel;
            let first = (room as usize).min(pixels - count);
            // The board's edge lies within the first pixel.
            (first, count, ((room - first as f64).clamp(0.0, 1.0) * pixel) as f32)
        };
        let (row, rows, rest_y) = side(0, board.length_mm, place.along);
        let (col, cols, rest_x) = side(1, board.width_mm, place.across);
        let part = PicturePart {
            first: [row, col],
            size: [rows, cols],
            turned: place.turned > 0.5,
            flipped: (place.mirrored > 0.5) != (place.turned > 0.5),
        };
        let fibres = part.fibres(&self.fibres);
        let light = part.of(&self.light, self.fibres.size[1]);
        let levels = if self.depth == Depth::Feature { LEVELS } else { 1 };
        let absorption = absorption_of(&light, &fibres, &wood.media, wood.log.latewood_share, levels);
        // Turned or flipped, the part's other end is the first, and what was left over lies there.
        let [length, width] = [0, 1].map(|i| fibres.size[i] as f32 * fibres.pixel_mm[i]);
        let other = |is_other: bool, whole: f32, mm: f64, rest: f32| {
            if is_other { (whole - mm as f32 - rest).max(0.0) } else { rest }
        };
        let corner = Vec2::new(
            other(part.flipped, width, board.width_mm, rest_x),
            other(part.turned, length, board.length_mm, rest_y),
        );
        let vectors: Vec<Vec3> = (0..light.len()).map(|pixel| fibres.fibre(pixel)).collect();
        let mut azimuths = fibres.azimuth_rad.clone();
        let azimuth_rad = quantile(&mut azimuths, 0.5);
        let [clear, knot] = means(&wood.media, wood.log.latewood_share);
        let labels = match &self.classes {
            Some(classes) => LabelSource::given(&part.of(classes, self.fibres.size[1]), fibres.size),
            None => LabelSource::Knots,
        };
        PicturedWood {
            absorption,
            vectors,
            corner,
            azimuth_rad,
            clear,
            knot,
            labels,
            depth: self.depth,
            face: self.face,
            board_mm: Vec2::new(board.width_mm as f32, board.length_mm as f32),
        }
    }
}

/// A part of a picture, and how it lies on the board.
struct PicturePart {
    /// First row and column.
    first: [usize; 2],
    /// Rows and columns.
    size: [usize; 2],
    /// Whether rows run backwards.
    turned: bool,
    /// Whether columns do.
    flipped: bool,
}

impl PicturePart {
    /// Its pixels.
    fn of<T: Copy>(&self, pixels: &[T], width: usize) -> Vec<T> {
        let [rows, cols] = self.size;
        let mut part = Vec::with_capacity(rows * cols);
        for row in 0..rows {
            let from = self.first[0] + if self.turned { rows - 1 - row } else { row };
            let start = from * width + self.first[1];
            let line = &pixels[start..start + cols];
            if self.flipped {
                part.extend(line.iter().rev());
            } else {
                part.extend_from_slice(line);
            }
        }
        part
    }

    /// Its fibres: one flipped axis mirrors azimuths, and where rows run backwards the other end of a fibre points
    /// ahead.
    fn fibres(&self, whole: &FibreMap) -> FibreMap {
        let width = whole.size[1];
        let mirrored = self.turned != self.flipped;
        let mut map = FibreMap {
            size: self.size,
            pixel_mm: whole.pixel_mm,
            azimuth_rad: self.of(&whole.azimuth_rad, width),
            dive_rad: self.of(&whole.dive_rad, width),
            confidence: self.of(&whole.confidence, width),
            knots: Vec::new(),
        };
        if mirrored {
            map.azimuth_rad.iter_mut().for_each(|azimuth| *azimuth = -*azimuth);
        }
        if self.turned {
            map.dive_rad.iter_mut().for_each(|dive| *dive = -*dive);
        }
        // At an azimuth of 90 degrees neither end points ahead, and pi/2 and -pi/2 are one line.
        map.azimuth_rad.iter_mut().filter(|azimuth| **azimuth <= -FRAC_PI_2).for_each(|azimuth| *azimuth = FRAC_PI_2);
        let [length, across] = [0, 1].map(|i| self.size[i] as f32 * whole.pixel_mm[i]);
        let corner = Vec2::new(self.first[1] as f32 * whole.pixel_mm[1], self.first[0] as f32 * whole.pixel_mm[0]);
        let signs = Vec2::new(if self.flipped { -1.0 } else { 1.0 }, if self.turned { -1.0 } else { 1.0 });
        let shift = Vec2::new(if self.flipped { across } else { 0.0 }, if self.turned { length } else { 0.0 });
        let moved = |knot: &PictureKnot| PictureKnot {
            centre_mm: shift + signs * (knot.centre_mm - corner),
            azimuth_rad: if mirrored { -knot.azimuth_rad } else { knot.azimuth_rad },
            axis: (signs * knot.axis.truncate()).extend(knot.axis.z),
            ..*knot
        };
        let reaches = |knot: &PictureKnot| {
            let reach = DISTURBED * knot.half_axes_mm[0];
            let at = knot.centre_mm;
            -reach < at.x && at.x < across + reach && -reach < at.y && at.y < length + reach
        };
        map.knots = whole.knots.iter().map(moved).filter(reaches).collect();
        map
    }
}

/// What labels are made from.
#[derive(Debug, Clone, PartialEq)]
enum LabelSource {
    /// The knots that were found.
    Knots,
    /// Number of the patch of every pixel, 0 for none, and the patches.
    Patches(Vec<u16>, Vec<Patch>),
}

impl LabelSource {
    fn given(classes: &[Class], size: [usize; 2]) -> Self {
        let (numbers, mut found) = patches(classes, size);
        // Numbers end where those of instances do.
        found.truncate(usize::from(u16::MAX));
        Self::Patches(numbers.into_iter().map(|number| u16::try_from(number).unwrap_or(0)).collect(), found)
    }
}

/// The wood of one board from a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PicturedWood {
    absorption: AbsorptionMap,
    /// Fibre of every pixel [1].
    vectors: Vec<Vec3>,
    /// Place of the board's near left corner in its part of the picture [mm].
    corner: Vec2,
    azimuth_rad: f32,
    /// Mean clear wood and knot wood.
    clear: Medium,
    knot: Medium,
    labels: LabelSource,
    depth: Depth,
    face: Face,
    /// Width and length [mm].
    board_mm: Vec2,
}

impl PicturedWood {
    /// Its knots, those that lie beyond its edges included; places are from the board's near left corner [mm].
    pub fn knots(&self) -> impl Iterator<Item = PictureKnot> {
        self.absorption.knots.iter().map(|knot| PictureKnot { centre_mm: knot.centre_mm - self.corner, ..*knot })
    }

    /// Fibre at a place of its part of the picture [mm].
    fn fibre(&self, place: Vec2) -> Vec3 {
        let map = &self.absorption;
        let at = [place.y / map.pixel_mm[0] - 0.5, place.x / map.pixel_mm[1] - 0.5];
        let near = around(map.size, at);
        let main = near.iter().fold(near[0], |most, one| if one.1 > most.1 { *one } else { most }).0;
        let sum: Vec3 = near
            .iter()
            .map(|&(i, weight)| {
                let own = self.vectors[i];
                if own.dot(self.vectors[main]) < 0.0 { -weight * own } else { weight * own }
            })
            .sum();
        sum.normalize_or(self.vectors[main])
    }

    fn patch(&self, numbers: &[u16], place: Vec2) -> u16 {
        let map = &self.absorption;
        let index = |at: f32, pixel: f32, count: usize| ((at / pixel).max(0.0) as usize).min(count - 1);
        let row = index(place.y, map.pixel_mm[0], map.size[0]);
        numbers[row * map.size[1] + index(place.x, map.pixel_mm[1], map.size[1])]
    }

    /// Numbers of the instances of its knots: those that can reach the board, and 0 for others, which bend its fibres
    /// alone.
    fn numbers(&self) -> impl Iterator<Item = u16> {
        let mut last = 0;
        self.knots().map(move |knot| {
            let reach = Vec2::splat(knot.half_axes_mm[0]);
            let at = knot.centre_mm;
            let is_on = at.cmpge(-reach).all() && at.cmple(self.board_mm + reach).all();
            last += u16::from(is_on);
            if is_on { last } else { 0 }
        })
    }
}

impl GivenWood for PicturedWood {
    fn at(&self, place: Vec2, depth_mm: f32) -> GivenMatter {
        let place = place + self.corner;
        let map = &self.absorption;
        let branch = map.branch(place, depth_mm);
        let foot = branch.map_or(place, |(_, foot)| foot);
        let mu_a = match self.depth {
            Depth::Feature => map.at(place, depth_mm),
            Depth::Even(to) if depth_mm <= to => map.on_face(foot),
            Depth::Even(_) => self.clear.mu_a,
        };
        let medium = if branch.is_some() { &self.knot } else { &self.clear };
        let near = |knot: &&PictureKnot| foot.distance(knot.centre_mm) < DISTURBED * knot.half_axes_mm[0];
        let nearest = map.knots.iter().filter(near).map(|knot| knot.within(foot)).fold(DISTURBED, f32::min);
        let share = ((DISTURBED - nearest) / (DISTURBED - 1.0)).clamp(0.0, 1.0);
        let (class, instance) = match (&self.labels, branch) {
            (LabelSource::Knots, Some((number, _))) => {
                let class = if map.knots[number].dead { Class::DeadKnot } else { Class::SoundKnot };
                (class, self.numbers().nth(number).unwrap_or(0))
            }
            (LabelSource::Knots, None) => (Class::Clear, 0),
            (LabelSource::Patches(numbers, found), _) => {
                let number = self.patch(numbers, place);
                (found.get(usize::from(number).wrapping_sub(1)).map_or(Class::Clear, |patch| patch.class), number)
            }
        };
        GivenMatter {
            mu_a,
            sigma_i: medium.sigma_i,
            k: medium.k,
            n_eff: medium.n_eff,
            fibre: self.fibre(foot),
            disturbed: share * share * (3.0 - 2.0 * share),
            class,
            instance,
        }
    }

    fn instances(&self) -> Vec<Instance> {
        let known = |id: u16, class: Class, at: Vec2, diameter_mm: f32, dive_deg: f64| Instance {
            id,
            class,
            state: class,
            within: 0,
            x_mm: f64::from(at.x),
            y_mm: f64::from(at.y),
            diameter_mm: f64::from(diameter_mm),
            dive_deg,
            death_radius_mm: f64::NAN,
            severity: f64::NAN,
            depth_mm: f64::NAN,
            knot: None,
        };
        match &self.labels {
            LabelSource::Knots => self
                .knots()
                .zip(self.numbers())
                .filter(|(_, number)| *number > 0)
                .map(|(knot, id)| {
                    let class = if knot.dead { Class::DeadKnot } else { Class::SoundKnot };
                    let dive_deg = f64::from(knot.dive_rad().to_degrees());
                    known(id, class, knot.centre_mm, 2.0 * knot.half_axes_mm[1], dive_deg)
                })
                .collect(),
            LabelSource::Patches(_, found) => found
                .iter()
                .zip(1..)
                .map(|(patch, id)| {
                    let [down, across] = self.absorption.pixel_mm;
                    let [row, col] = patch.middle().map(|at| at as f32 + 0.5);
                    let extent = Vec2::new(
                        across * (patch.cols[1] - patch.cols[0] + 1) as f32,
                        down * (patch.rows[1] - patch.rows[0] + 1) as f32,
                    );
                    let at = Vec2::new(col * across, row * down) - self.corner;
                    known(id, patch.class, at, extent.max_element(), f64::NAN)
                })
                .collect(),
        }
    }

    fn azimuth_deg(&self) -> f32 {
        self.azimuth_rad.to_degrees()
    }

    fn pith_is_above(&self) -> bool {
        self.face == Face::Pith
    }
}
