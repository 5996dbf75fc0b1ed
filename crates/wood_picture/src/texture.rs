//! The structure tensor of a picture's texture, gathered in cells.
//!
//! Model: at every pixel the gradient g = (gx, gy) of the logarithm of light under a Gaussian of scale s, and from it
//! the doubled angle of the line across it,  q = w (gx^2 - gy^2, -2 gx gy). Its angle is twice the azimuth of the
//! fibre, from y towards x. Sums of q over a window are the orientation of least squares (Bigün and Granlund 1987);
//! gradients are taken per mm in both directions, so pixels need not be square. Weight: w = 4 c^2 / (e + c^2)^2 (Geman
//! and McClure 1987), e the larger of |g|^2 and its mean under a Gaussian of 1 s, c 1.5 times the root of the median of
//! that mean. Streaks of fibre bundles have gradients about the median; what stands out (cracks, what `rings` has left,
//! rims) counts little. Scales: 0.2, 0.4 and 0.8 mm for streaks, 0.4 mm for all that is seen; `orientation` chooses
//! among them (Lindeberg 1998). Limits: gradients of neighbouring pixels share their light: each cell keeps its second
//! moments for an error that counts it.

use crate::raster::{Beyond, filter, gaussian, gaussian_slope, quantile, smooth};

/// Scales of the derivative for streaks [mm]: bundles of a few tracheids, and of many.
pub(crate) const STREAKS_MM: [f32; 3] = [0.2, 0.4, 0.8];
/// Scale for all that is seen, rings foremost [mm].
pub(crate) const RINGS_MM: f32 = 0.4;
/// What rings turn from the fibre [rad]: 5 deg, the median of what boards of `procedural` show.
pub(crate) const RINGS_RAD: f32 = 0.09;
/// Least scale [pixel]: below, a sampled derivative turns directions.
const LEAST_PIXELS: f32 = 0.9;
/// Gradient at which a pixel counts most over the median gradient [1].
const KNEE: f32 = 1.5;
/// Gaussian over the squares of gradients, over the scale [1].
const ENERGY: f32 = 1.0;
/// Side of a cell [mm]; fibres turn over a knot's half width, 2 mm at least.
pub(crate) const CELL_MM: f32 = 0.5;

/// How cells lie over pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cells {
    /// Rows and columns of cells.
    pub size: [usize; 2],
    /// Side of a cell [mm].
    pub side_mm: f32,
}

impl Cells {
    /// Cells of the tensor over a picture.
    pub fn over(size: [usize; 2], pixel_mm: [f32; 2]) -> Self {
        Self::with_side(size, pixel_mm, CELL_MM)
    }

    /// Cells of a side over a picture, or of a pixel's where pixels are longer [mm].
    pub fn with_side([rows, cols]: [usize; 2], pixel_mm: [f32; 2], side_mm: f32) -> Self {
        let side_mm = side_mm.max(pixel_mm[0]).max(pixel_mm[1]);
        let count = |pixels: usize, mm: f32| ((pixels as f32 * mm / side_mm).ceil() as usize).max(2);
        Self { size: [count(rows, pixel_mm[0]), count(cols, pixel_mm[1])], side_mm }
    }

    /// The cell of a pixel (row, column).
    pub fn of(&self, pixel: [usize; 2], pixel_mm: [f32; 2]) -> usize {
        let [row, col] =
            [0, 1].map(|i| (((pixel[i] as f32 + 0.5) * pixel_mm[i] / self.side_mm) as usize).min(self.size[i] - 1));
        row * self.size[1] + col
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// The cell of a place (x, y) [mm].
    pub fn of_place(&self, place: glam::Vec2) -> usize {
        let [row, col] = [place.y, place.x].map(|mm| (mm / self.side_mm).max(0.0) as usize);
        row.min(self.size[0] - 1) * self.size[1] + col.min(self.size[1] - 1)
    }

    /// Middle of a cell: across (x) and down (y) [mm].
    pub fn middle(&self, cell: usize) -> glam::Vec2 {
        let (row, col) = (cell / self.size[1], cell % self.size[1]);
        self.side_mm * glam::Vec2::new(col as f32 + 0.5, row as f32 + 0.5)
    }

    /// Row and column of cells at a place (x, y) [mm]; middles are whole numbers.
    pub fn at(&self, place: glam::Vec2) -> [f32; 2] {
        [place.y / self.side_mm - 0.5, place.x / self.side_mm - 0.5]
    }
}

/// Texture of one scale in cells.
#[derive(Debug, Clone)]
pub(crate) struct CellTexture {
    /// Error that no window averages out [rad].
    pub bias_rad: f32,
    /// Sums over each cell's pixels of |q|, of both parts of q, and of |q|^2 and the two parts of its square as a
    /// complex number.
    pub sums: [Vec<f32>; 6],
    /// Pixels of each cell that count.
    pub pixels: Vec<f32>,
    /// Rings are seen too, which need not follow the fibres.
    pub rings: bool,
    /// Pixels over which gradients are one [1].
    pub correlated: f32,
}

/// What of a texture is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Look {
    /// Scale of the derivative [mm].
    pub scale_mm: f32,
    /// Error that no window averages out [rad].
    pub bias_rad: f32,
    /// Large gradients count by their size, not less.
    pub by_size: bool,
}

/// Texture of the logarithm of light at one scale; `counts` says which pixels count.
pub(crate) fn texture(
    log_light: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    cells: &Cells,
    look: Look,
    counts: &[bool],
) -> CellTexture {
    let Look { scale_mm, bias_rad, by_size } = look;
    let sigma = pixel_mm.map(|pixel| (scale_mm / pixel).max(LEAST_PIXELS));
    let [smooth_down, smooth_across] = sigma.map(gaussian);
    let [slope_down, slope_across] = sigma.map(gaussian_slope);
    let down = filter(log_light, size, [&slope_down, &smooth_across], Beyond::Same);
    let across = filter(log_light, size, [&smooth_down, &slope_across], Beyond::Same);
    let square = |i: usize| (across[i] / pixel_mm[1]).powi(2) + (down[i] / pixel_mm[0]).powi(2);
    let weights = (!by_size).then(|| {
        let squares: Vec<f32> = (0..log_light.len()).map(square).collect();
        let energy = smooth(&squares, size, pixel_mm.map(|pixel| ENERGY * scale_mm / pixel), Beyond::Same);
        // Every seventh pixel is enough for a median.
        let mut some: Vec<f32> = (0..log_light.len()).step_by(7).filter(|&i| counts[i]).map(|i| energy[i]).collect();
        let knee = if some.is_empty() { 1.0 } else { KNEE * KNEE * quantile(&mut some, 0.5) }.max(f32::MIN_POSITIVE);
        move |i: usize, square: f32| 4.0 * knee / (square.max(energy[i]) + knee).powi(2)
    });
    let mut pixels = vec![0.0_f32; cells.count()];
    let mut sums: [Vec<f32>; 6] = std::array::from_fn(|_| vec![0.0; cells.count()]);
    for row in 0..size[0] {
        for col in 0..size[1] {
            let i = row * size[1] + col;
            if !counts[i] {
                continue;
            }
            let (gx, gy) = (across[i] / pixel_mm[1], down[i] / pixel_mm[0]);
            let square = square(i);
            let weight = weights.as_ref().map_or(1.0, |weight| weight(i, square));
            let (length, re, im) = (weight * square, weight * (gx * gx - gy * gy), -2.0 * weight * gx * gy);
            let cell = cells.of([row, col], pixel_mm);
            pixels[cell] += 1.0;
            let terms = [length, re, im, length * length, re * re - im * im, 2.0 * re * im];
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum[cell] += term;
            }
        }
    }
    // Integral of the squared correlation of gradients' squares under white noise: 3/2 pi s^2.
    let correlated = (1.5 * std::f32::consts::PI * sigma[0] * sigma[1]).max(1.0);
    CellTexture { bias_rad, sums, pixels, rings: bias_rad == RINGS_RAD, correlated }
}
