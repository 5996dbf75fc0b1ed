//! What a picture of a board, or a stack of slices of one, can have against it.

/// Why a picture gives no map, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PictureFault {
    /// The array does not have the stated size.
    #[error(
        "the picture has {pixels} pixels, but {rows} rows of {cols} columns are stated; give one brightness a pixel, \
            row by row"
    )]
    Length {
        /// Pixels given.
        pixels: usize,
        /// Rows stated.
        rows: usize,
        /// Columns stated.
        cols: usize,
    },
    /// Pixels of no size, or much longer than wide.
    #[error("pixels of {} by {} mm (down, across) are stated; give sizes over 0, the longer at most 4 times the \
        shorter: board length over rows, board width over columns", pixel_mm[0], pixel_mm[1])]
    Pixel {
        /// Size stated, down and across [mm].
        pixel_mm: [f32; 2],
    },
    /// Pixels too large for the streaks of wood.
    #[error("pixels of {pixel_mm} mm cannot show the streaks of fibres; scan or photograph the board with at least {} \
        pixels a mm", 1.0 / most_mm)]
    Coarse {
        /// Longer side of a pixel [mm].
        pixel_mm: f32,
        /// The most it may be [mm].
        most_mm: f32,
    },
    /// Too few pixels or too little of a board.
    #[error("the picture shows {:.1} by {:.1} mm (down, across); show at least {least_mm} by {least_mm} mm of the \
        board", extent_mm[0], extent_mm[1])]
    TooSmall {
        /// What it shows, down and across [mm].
        extent_mm: [f32; 2],
        /// The least [mm].
        least_mm: f32,
    },
    /// The picture's shape is not the board's.
    #[error("the picture shows {:.1} by {:.1} mm (down, across), but the board is {:.1} by {:.1} mm; crop it to the \
        board's edges, turn it so that the length runs down the rows, or correct the pixel \
        size", extent_mm[0], extent_mm[1], board_mm[0], board_mm[1])]
    Aspect {
        /// What the picture shows, down and across [mm].
        extent_mm: [f32; 2],
        /// The board: length and width [mm].
        board_mm: [f32; 2],
    },
    /// More patches of classes than instances can be told apart.
    #[error(
        "the classes make {patches} patches, more than {most}; smooth the picture of classes, or leave out patches of \
            a few pixels"
    )]
    Patches {
        /// Patches of one class that share no side.
        patches: usize,
        /// The most.
        most: usize,
    },
    /// A brightness that is no number, or below 0.
    #[error("row {row}, column {col} has the brightness {value}; every pixel needs a number from 0 on")]
    Value {
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
        /// Its brightness.
        value: f32,
    },
    /// Nobody said how brightness is encoded.
    #[error(
        "how the picture's numbers go with light is not stated, and absorption follows from light; state `Linear` for \
            raw or linear files, `Srgb` for ordinary JPEG and PNG files, else the gamma"
    )]
    NotLinear,
    /// A gamma that is none.
    #[error("a gamma of {gamma} is stated; give one between 0.3 and 4, 2.2 is usual")]
    Gamma {
        /// What is stated [1].
        gamma: f32,
    },
    /// One brightness all over.
    #[error("the picture is the same all over (its middle 90 % of pixels lie within {:.2} % of each other); give the \
        photograph itself, not a mask or a mean colour", 100.0 * spread)]
    Constant {
        /// Spread of the middle 90 % of pixels over their median [1].
        spread: f32,
    },
    /// Too many pixels at the end of the scale.
    #[error("{:.1} % of the pixels have reached the end of the scale, {full_scale}; expose less, or cut away \
        glare", 100.0 * share)]
    Saturated {
        /// Share of such pixels [1].
        share: f32,
        /// End of the scale.
        full_scale: f32,
    },
    /// No texture with a direction.
    #[error(
        "there is no grain in the picture: its texture has a direction {significance:.1} times as strong as noise \
            would, and wood's is {least} times at least; check the focus, the compression of the file and that it \
            shows bare wood"
    )]
    NoWood {
        /// Median of the direction's strength over its standard error [1].
        significance: f32,
        /// The least of wood [1].
        least: f32,
    },
    /// The texture's size is not that of wood.
    #[error("the streaks are {found_mm:.2} mm wide at the stated size of pixels, and wood's lie between {} and {} mm; \
        correct the size of pixels (a ruler in the picture, or board width over columns)", range_mm[0], range_mm[1])]
    Scale {
        /// Scale at which the grain is strongest [mm].
        found_mm: f32,
        /// Scales of wood [mm].
        range_mm: [f32; 2],
    },
}

/// Why a stack of slices gives no wood, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VolumeFault {
    /// Too little wood.
    #[error("the stack shows {:.2} by {:.2} by {:.2} mm (through the slices, down, across); give more slices or \
        larger ones, at least {least_mm} mm on each side, or correct the size of a \
        voxel", extent_mm[0], extent_mm[1], extent_mm[2])]
    TooSmall {
        /// What it shows, through the slices, down and across [mm].
        extent_mm: [f32; 3],
        /// The least [mm].
        least_mm: f32,
    },
    /// More voxels than are kept.
    #[error(
        "the stack has {voxels} voxels where those below 0.05 mm are put together, and at most {most} are kept; crop \
            it, or average voxels to 0.1 mm"
    )]
    Large {
        /// Voxels.
        voxels: usize,
        /// The most.
        most: usize,
    },
    /// No mean density of wood.
    #[error(
        "the mean density is {mean:.0} kg/m3, and wood has {least} to {most}; correct the densities of black and \
            white, or crop the slices to wood"
    )]
    Mean {
        /// Mean density [kg/m^3].
        mean: f32,
        /// The least that wood has [kg/m^3].
        least: f32,
        /// The most [kg/m^3].
        most: f32,
    },
    /// Too much air.
    #[error("{:.0} % of it have less than {density} kg/m3, which is air and no wood; crop the slices to wood, which \
        lies {:.1} to {:.1} mm through the slices, {:.1} to {:.1} mm down and {:.1} to {:.1} mm across them, or \
        correct the densities of black and \
        white", 100.0 * share, wood_mm[0][0], wood_mm[0][1], wood_mm[1][0], wood_mm[1][1], wood_mm[2][0],
            wood_mm[2][1])]
    Air {
        /// Share of the voxels [1].
        share: f32,
        /// Density below which they are air [kg/m^3].
        density: f32,
        /// From where to where wood lies through the slices, down and across them [mm].
        wood_mm: [[f32; 2]; 3],
    },
    /// One density all over.
    #[error("the density is the same all over: its standard deviation is {:.2} % of the mean; give slices that show \
        rings or fibres, or densities of black and white that lie further apart", 100.0 * spread)]
    Even {
        /// Standard deviation over the mean [1].
        spread: f32,
    },
}
