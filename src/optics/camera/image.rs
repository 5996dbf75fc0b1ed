//! Where points are imaged, how sharp they are, and how bright lamps make them.

use super::Camera;
use crate::lens::DistortedDirection;

/// Where a point is imaged, and how the image runs about it.
pub(super) struct Image {
    /// Row [px].
    pub row: f32,
    /// Along the motion [px/mm].
    pub rows_per_mm: f32,
    /// Width of a column along the line [mm].
    pub pixel_mm: f32,
}

impl Camera {
    /// Whether points can be out of focus.
    pub fn blurs(&self) -> bool {
        self.blurs
    }

    /// Diameter of the disc that a point at `y` from the laser plane and height `z` is blurred to by a thin lens [mm].
    pub fn confusion(&self, y: f32, z: f32) -> f32 {
        let [zc, bottom] = self.depth(y, z);
        self.focus.confusion(zc, zc / bottom)
    }

    /// Variances along columns and along rows of what is out of focus at `y` from the laser plane and height `z` [px^2].
    pub fn defocus(&self, y: f32, z: f32) -> [f32; 2] {
        let [zc, bottom] = self.depth(y, z);
        if self.blurs { self.focus.variances(zc, zc / bottom) } else { [0.0; 2] }
    }

    /// Variance along rows of what a thin lens has out of focus at `y` from the laser plane and height `z`, however the
    /// sensor stands [px^2].
    pub fn off_plane(&self, y: f32, z: f32) -> f32 {
        let [zc, bottom] = self.depth(y, z);
        if self.thin { self.focus.variances(zc, zc / bottom)[1] } else { 0.0 }
    }

    /// How far along the line a column's way over a level surface goes with the motion, dx/dy [1].
    pub fn lean(&self, x: f32, z: f32) -> f32 {
        let [_, sin, cos, tan_beta, _] = self.row;
        x * (sin - tan_beta * cos) / self.depth(0.0, z)[1]
    }

    /// Depth before the lens, and the same less tan(beta) times the height over the axis [mm].
    #[inline]
    fn depth(&self, y: f32, z: f32) -> [f32; 2] {
        let [_, sin, cos, tan_beta, distance] = self.row;
        let zc = distance + y * sin - z * cos;
        [zc, zc - tan_beta * (y * cos + z * sin)]
    }

    /// Electrons of ambient light in a pixel that sees a white surface at `x`, `z` of the laser plane [e-].
    pub fn ambient(&self, x: f32, z: f32) -> f32 {
        if self.ambient == 0.0 {
            return 0.0;
        }
        let [zc, bottom] = self.depth(0.0, z);
        let yc = z * self.row[1];
        let (tangent2, squeeze) = ((x * x + yc * yc) / (zc * zc), bottom / zc);
        let cos2 = 1.0 / (1.0 + tangent2);
        let mounts = self.field.as_ref().map_or(1.0, |field| field.mounts(tangent2));
        self.ambient * mounts * cos2 * cos2 * squeeze * squeeze * squeeze
    }

    /// Whether lamps and windows light the object.
    pub fn has_ambient(&self) -> bool {
        self.ambient > 0.0
    }

    /// Sensor column and row of a point in space, y from the laser plane [px].
    #[inline]
    pub fn place(&self, x: f32, y: f32, z: f32) -> [f32; 2] {
        if self.bent.is_some() {
            let (col, row) = self.rig.project(f64::from(x), f64::from(y), f64::from(z));
            return [col as f32, row as f32];
        }
        let [scale, sin, cos, tan_beta, distance] = self.row;
        let (yc, zc) = (y * cos + z * sin, distance + y * sin - z * cos);
        let bottom = zc - tan_beta * yc;
        let along = scale * self.upright * x / bottom;
        [self.rig.centre_col as f32 + along, self.rig.centre_row as f32 - scale * yc / bottom]
    }

    /// The image of a point whose place in the lens's frame moves by `dyc`, `dzc` with the motion.
    #[inline]
    pub(super) fn image(&self, x: f32, [yc, zc]: [f32; 2], [dyc, dzc]: [f32; 2]) -> Image {
        let [scale, _, _, tan_beta, _] = self.row;
        let bottom = zc - tan_beta * yc;
        let Some(bent) = &self.bent else {
            let rate = scale * (dyc * bottom - yc * (dzc - tan_beta * dyc)) / (bottom * bottom);
            return Image {
                row: self.rig.centre_row as f32 - scale * yc / bottom,
                rows_per_mm: rate,
                pixel_mm: self.rig.pixel as f32 * bottom / self.rig.image_distance as f32,
            };
        };
        let [x, yc, zc, dyc, dzc] = [x, yc, zc, dyc, dzc].map(f64::from);
        let (xn, yn) = (x / zc, yc / zc);
        let DistortedDirection { direction: [xd, yd], slopes: [a, b, c] } = bent.distort(xn, yn);
        let turn = b * (-xn * dzc / zc) + c * (dyc - yn * dzc) / zc;
        let (scale, lean) = (f64::from(scale), f64::from(tan_beta));
        let flat = 1.0 - lean * yd;
        let column = self.rig.image_distance / self.rig.pixel * (a * flat + xd * lean * b) / (flat * flat);
        Image {
            row: (self.rig.centre_row - scale * yd / flat) as f32,
            rows_per_mm: (scale * turn / (flat * flat)) as f32,
            pixel_mm: (zc / column) as f32,
        }
    }
}
