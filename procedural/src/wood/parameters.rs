//! The numbers that make a board: how it was sawn, the log it came from, its knots, its decay and its media, and the
//! whole stem for boards that are sawn from one.
//!
//! Sources: [T] Kihl and Källberg 2021; [G] statistics of the scanned spruce log "Gran_1" (Larsson et al. 2022, MIT);
//! [L] the literature named in docs/theory/wood.md; [C] chosen so that the observables of docs/theory/wood.md come out;
//! [P] measured on the photographs of sawn boards of Kodytek et al. (2021).

use base::Need::{self, Amount, Any, AnyOrLog, Factor, While};
use base::{TANGLED, parameters};

/// An edge leaves its line by this at most [root mean squares].
pub const EDGE_MOST: f32 = 3.0;

const PLACED: Need = While("log.source", &["placed"]);
const STEM: Need = While("log.source", &["stem"]);
const SAWN: Need = While("log.source", &["stem", "measured"]);
const GROWN: Need = While("log.source", &["placed", "stem", "measured"]);
/// What a picture can show and a log has, and densities do not tell.
const SEEN: Need = While("log.source", &["placed", "stem", "measured", "picture"]);
const PICTURE: Need = While("log.source", &["picture"]);
const SLICES: Need = While("log.source", &["slices"]);

/// Boards whose knots are not counted.
const KNOTTY: &[&str] = &["stem", "measured", "picture"];
const KNOTS: Need =
    AnyOrLog(&["knots.sound_count", "knots.dead_count", "knots.hole_count", "knots.loose_count"], KNOTTY);
const DEAD_KNOTS: Need = AnyOrLog(&["knots.dead_count", "knots.hole_count", "knots.loose_count"], KNOTTY);
/// Branches of a stem have bark, knots in pictures and slices have none.
const BARK: Need = AnyOrLog(
    &[
        "knots.dead_count",
        "knots.hole_count",
        "knots.loose_count",
        "inclusions.bark_pocket_count",
        "wane.width_mm",
        "stem.outline_wane",
    ],
    &["stem", "measured"],
);
/// Bark scatters as knots do.
const KNOTS_OR_BARK: Need = AnyOrLog(
    &[
        "knots.sound_count",
        "knots.dead_count",
        "knots.hole_count",
        "knots.loose_count",
        "inclusions.bark_pocket_count",
        "wane.width_mm",
        "stem.outline_wane",
    ],
    KNOTTY,
);
const TEETH: Need = Amount("machining.teeth_um");
const ROT: Need = Any(&["rot.reach_mm", "rot.heart_mm", "rot.pocket_count"]);
const COMPRESSION: Need = Amount("compression.severity");
const STAIN: Need = Amount("stain.severity");
const RESIN: Need = Any(&["inclusions.resin_pocket_count", "inclusions.resin_streak_count", "anatomy.canals_per_mm2"]);
const PORES: Need = Amount("anatomy.pores_per_mm2");
const RAYS: Need = Amount("anatomy.ray_share");
const POCKETS: Need = Any(&["inclusions.resin_pocket_count", "inclusions.bark_pocket_count"]);
const INCLUSIONS: Need =
    Any(&["inclusions.resin_pocket_count", "inclusions.resin_streak_count", "inclusions.bark_pocket_count"]);

parameters! {
    /// The sawn board and how it lies on the conveyor.
    board: Board {
        /// Width along the laser line.
        width_mm: 2.0, 2000.0, 94.0, "[T]", fixed;
        /// Length along the scan.
        length_mm: 2.0, 10000.0, 210.0, "[T]", fixed;
        /// Thickness.
        thickness_mm: 1.0, 200.0, 22.0, "[T]; spread [M]", normal(22.0, 0.3);
        /// Centre of the board along the laser line.
        offset_mm: -1000.0, 1000.0, 0.0, "free; spread [M]", uniform(-0.5, 0.5);
        /// Conveyor before the board's front edge enters the laser.
        lead_in_mm: 0.0, 1000.0, 20.0, "free", fixed;
        /// Height of the upper surface's middle over its edges (cupping).
        cup_mm: -5.0, 5.0, 0.3, "[L]; spread [M]", uniform(0.0, 0.6);
        /// Turn of the upper surface about the scan axis from front to back (twist).
        twist_deg: -5.0, 5.0, 0.1, "[L]; spread [M]", uniform(-0.1, 0.3);
        /// Ripple left by the saw, root mean square.
        saw_ripple_um: 0.0, 500.0, 30.0, "[L] 20 to 100", log_uniform(20.0, 100.0);
        /// Distance between two ridges of the ripple.
        saw_pitch_mm: 0.5, 100.0, 12.0, "[L] 5 to 25", uniform(5.0, 25.0), of [Amount("board.saw_ripple_um")];
        /// Roughness of torn fibres, root mean square.
        roughness_um: 0.0, 200.0, 12.0, "[L] 10 to 50", log_uniform(10.0, 50.0);
        /// How far the long edges leave straight lines, root mean square.
        edge_wander_mm: 0.0, 3.0, 0.0, "[E] 0.05 to 0.3", fixed;
    }
}

parameters! {
    /// The log that the board was cut from.
    log: Log {
        /// Depth of the pith below the upper surface, before the board is turned over; negative is above it, so that
        /// the bark side lies down.
        pith_depth_mm: -400.0, 400.0, 70.0, "[G]; spread [M]", uniform(30.0, 110.0), needs [PLACED];
        /// Offset of the pith along the laser line from the board's middle; to the other side where the board is
        /// turned.
        pith_offset_mm: -400.0, 400.0, 10.0, "[G]; spread [M]", normal(0.0, 35.0), needs [PLACED];
        /// Dive of the pith line against the board, towards the far end.
        pith_tilt_deg: -10.0, 10.0, 0.6, "[G] 0.6 over 1 m; spread [M]", normal(0.0, 0.6), needs [GROWN];
        /// Sideways wander of the pith line, root mean square.
        pith_wander_mm: 0.0, 30.0, 2.0, "[G] 3.5 to 4.0 over 4 m; spread [M]", uniform(1.0, 4.0), needs [PLACED];
        /// Turn of the log against the board about the vertical.
        grain_angle_deg: -90.0, 90.0, 0.0, "[L] sd 2 to 4; spread [M]", normal(0.0, 3.0), needs [GROWN];
        /// Whether the board is turned end for end, so that the end nearer to the tree's top comes first: 0 or 1.
        turned: 0.0, 1.0, 0.0, "free; boards lie either way", one_of(0.0, 1.0), count, needs [GROWN];
        /// Whether the board is turned over, so that the pith lies on the other side of its upper face: 0 or 1.
        flipped: 0.0, 1.0, 0.0, "free; boards lie either way", one_of(0.0, 1.0), count, needs [PLACED];
        /// Spiral grain near the pith, left-handed positive; at the pith itself there is none.
        spiral_deg: -10.0, 10.0, 2.5, "[L] Säll 2002; spread [M]", normal(2.5, 1.2), needs [GROWN];
        /// Change of the spiral grain with the distance from the pith.
        spiral_slope_deg_per_mm: -0.2, 0.2, -0.025, "[L] Säll 2002; spread [M]", normal(-0.025, 0.015), needs [GROWN];
        /// Mean width of an annual ring.
        ring_width_mm: 0.3, 15.0, 1.8, "[L] 0.5 to 6; spread [M]", log_uniform(0.8, 4.0), needs [GROWN];
        /// Standard deviation of the logarithm of the ring width.
        ring_width_log_sd: 0.0, 1.0, 0.35, "[L]; spread [M]", uniform(0.2, 0.45), needs [GROWN];
        /// Correlation of one ring's width with the next.
        ring_width_correlation: 0.0, 0.99, 0.6, "[L]; spread [M]", uniform(0.4, 0.75),
            needs [GROWN], of [Amount("log.ring_width_log_sd")];
        /// Width of the rings at the pith over that of rings far out, whose mean is `ring_width_mm`; 1 for no trend.
        ring_width_pith_ratio: 0.3, 5.0, 1.0, "[E] 1.5 to 3 in open stands", fixed, needs [GROWN];
        /// Rings from the pith over which that trend falls to 1/e.
        ring_width_trend_rings: 1.0, 200.0, 12.0, "[E]", log_uniform(8.0, 18.0),
            needs [GROWN], of [Factor("log.ring_width_pith_ratio")];
        /// Rings of the juvenile core about the pith; 0 for none.
        juvenile_rings: 0.0, 60.0, 0.0, "[L] 5 to 20", fixed, needs [GROWN], of [Factor("log.juvenile_latewood_ratio")];
        /// Share of latewood at the pith over that outside of the juvenile core.
        juvenile_latewood_ratio: 0.05, 1.0, 0.4, "[E]", uniform(0.25, 0.6),
            needs [GROWN], of [Amount("log.juvenile_rings")];
        /// Share of latewood in a ring.
        latewood_share: 0.02, 0.8, 0.2, "[L] 0.1 to 0.4", uniform(0.1, 0.4), needs [SEEN];
        /// Distance beyond a ring over which its latewood ends; 0 for at once.
        latewood_end_mm: 0.0, 2.0, 0.0, "[E] 0.2 to 0.5 on sawn faces", fixed, needs [SEEN];
        /// Relative variation of the coefficients from fibre bundle to fibre bundle.
        streak: 0.0, 0.5, 0.06, "[C]", uniform(0.03, 0.1), needs [GROWN];
        /// Radius of the heartwood; 0 for none.
        heartwood_mm: 0.0, 400.0, 0.0, "[L] about half of a log's radius", fixed, needs [GROWN];
        /// Radius of the pith's own dark tissue; 0 leaves it out.
        pith_mm: 0.0, 10.0, 0.0, "[L] 1 to 3", fixed, needs [GROWN];
    }
}

parameters! {
    /// Knots that the upper surface shows.
    knots: Knots {
        /// How many were alive where the saw met them.
        sound_count: 0.0, 40.0, 0.0, "per board", fixed, count, needs [PLACED];
        /// How many had died before.
        dead_count: 0.0, 40.0, 0.0, "per board", fixed, count, needs [PLACED];
        /// How many dead ones have fallen out and left a hole.
        hole_count: 0.0, 40.0, 0.0, "per board", fixed, count, needs [PLACED];
        /// Depth of such a hole.
        hole_depth_mm: 0.5, 200.0, 12.0, "[E]", log_uniform(6.0, 20.0), needs [PLACED], of [Amount("knots.hole_count")];
        /// How many dead ones are loose.
        loose_count: 0.0, 40.0, 0.0, "per board", fixed, count, needs [PLACED];
        /// Width of the gap around a loose one, mean over its outline.
        loose_gap_mm: 0.05, 3.0, 0.3, "[E] 0.1 to 1", log_uniform(0.1, 1.0),
            needs [PLACED], of [Amount("knots.loose_count")];
        /// How far the face of a loose one has sunk, mean.
        loose_sunk_mm: 0.0, 10.0, 0.4, "[E] 0 to 2", uniform(0.0, 2.0),
            needs [PLACED], of [Amount("knots.loose_count")];
        /// Median width at the upper surface.
        width_mm: 1.0, 80.0, 12.0, "[G] times 2 for fast-grown stock; spread [M]", log_uniform(7.0, 20.0),
            needs [PLACED], of [KNOTS];
        /// Standard deviation of the logarithm of the width from knot to knot.
        width_log_sd: 0.0, 1.5, 0.35, "[G] 0.64 over a whole log; spread [M]", uniform(0.2, 0.5),
            needs [PLACED], of [KNOTS];
        /// Slope of the axes against the plane across the pith, upwards positive, median.
        slope_deg: -45.0, 45.0, -10.0, "[G]; spread [M]", normal(-10.0, 7.0), needs [PLACED], of [KNOTS];
        /// Spread of that slope from knot to knot.
        slope_sd_deg: 0.0, 30.0, 8.0, "[G]; spread [M]", uniform(4.0, 10.0), needs [PLACED], of [KNOTS];
        /// Share of knots that an edge or an end of the board may cut.
        cut_share: 0.0, 1.0, 0.0, "free; saws don't mind", fixed, needs [PLACED], of [KNOTS];
        /// Standard deviation of the logarithm of the bulge of rings around a knot, and so of the dive of its fibres.
        bulge_log_sd: 0.0, 1.5, 0.5, "[E]", uniform(0.4, 0.8), needs [GROWN], of [KNOTS];
        /// Standard deviation of how far rings lean along the grain at a knot; two half widths away 0.4 of it is left.
        lean_sd_deg: 0.0, 20.0, 5.0, "[E]", uniform(3.0, 8.0), needs [GROWN], of [KNOTS];
        /// Standard deviation of the logarithm of the absorption from knot to knot.
        tone_log_sd: 0.0, 1.5, 0.5, "[P] 0.6 live, 0.7 dead; spread [M]", uniform(0.3, 0.7), needs [GROWN], of [KNOTS];
        /// Absorption at a knot's pith over that at its outline, median; at half its radius it has that of its kind.
        heart_mu_a_ratio: 1.0, 100.0, 14.0, "[P] 3 to 20", log_uniform(3.0, 20.0), needs [GROWN], of [KNOTS];
        /// Distance of a knot's pith from the middle of its outline over its half width, mean.
        pith_shift: 0.0, 0.6, 0.2, "[E]", uniform(0.1, 0.3), needs [GROWN], of [KNOTS];
        /// Share of knots that have cracked from the pith outwards.
        crack_share: 0.0, 1.0, 0.06, "[P] 0.05; spread [M]", uniform(0.0, 0.12), needs [GROWN], of [KNOTS];
        /// Absorption of the stem's wood beside a knot over that without it, resin and tannins, median where most.
        stain_mu_a_ratio: 1.0, 20.0, 2.0, "[E]", log_uniform(1.2, 4.0), needs [GROWN], of [KNOTS];
        /// Half distance of source and sink over the knot's radius in the flow of fibres around it (Rankine oval).
        flow_ratio: 0.05, 4.0, 1.0, "[L] 0.5 to 1.5", uniform(0.5, 1.5), needs [GROWN], of [KNOTS];
        /// Distance from the pith where a dead knot died, over the distance where the saw met it.
        death_share: 0.05, 0.98, 0.7, "[G] mean 0.79 of the end radius; spread [M]", uniform(0.5, 0.9),
            needs [PLACED], of [DEAD_KNOTS];
        /// Thickness of the bark ring around a dead knot.
        bark_mm: 0.0, 5.0, 0.7, "[L] 0.3 to 1.5", log_uniform(0.3, 1.5), needs [GROWN], of [DEAD_KNOTS];
        /// Amplitude of its thickness about the knot over its mean, mean of knots; beyond 1 a part has none.
        bark_uneven: 0.0, 4.0, 0.8, "[P]; spread [M]", uniform(0.3, 1.6),
            needs [GROWN], of [DEAD_KNOTS, Amount("knots.bark_mm")];
    }
}

impl Log {
    /// Turn of the log against the board about the vertical, end for end included [deg].
    pub fn turn_deg(&self) -> f64 {
        self.grain_angle_deg + 180.0 * self.turned
    }

    /// Depth of the pith below the upper face of a board of that thickness as it lies [mm].
    pub fn depth_mm(&self, thickness: f64) -> f64 {
        if self.flipped < 0.5 { self.pith_depth_mm } else { thickness - self.pith_depth_mm }
    }
}

parameters! {
    /// Decay: along one long edge, about the pith, in pockets.
    rot: Rot {
        /// How far it reaches in from one long edge; 0 for none there.
        reach_mm: 0.0, 500.0, 0.0, "[T] a strip along the whole edge", fixed, needs [GROWN];
        /// Which long edge: -1 or 1.
        edge: -1.0, 1.0, 1.0, "free", one_of(-1.0, 1.0), of [Amount("rot.reach_mm")];
        /// Radius of decay about the pith (heart rot); 0 for none there.
        heart_mm: 0.0, 400.0, 0.0, "[L] 10 to 60", fixed, needs [GROWN];
        /// Pockets of decay that the upper surface shows.
        pocket_count: 0.0, 100.0, 0.0, "per board", fixed, count, needs [GROWN];
        /// Median length of a pocket along the grain; it is a fifth as wide.
        pocket_length_mm: 1.0, 300.0, 25.0, "[E]", log_uniform(15.0, 40.0), of [Amount("rot.pocket_count")];
        /// Severity in the middle of it, 0 to 1.
        severity: 0.0, 1.0, 0.5, "[C] 0.5 is the medium of the class table", uniform(0.3, 0.9), of [ROT];
        /// Width of the change from sound to decayed wood.
        transition_mm: 0.2, 50.0, 4.0, "[L] 2 to 8", uniform(2.0, 8.0), of [ROT];
        /// How much the front wanders, root mean square.
        front_mm: 0.0, 30.0, 3.0, "[L]; spread [M]", uniform(1.5, 5.0), of [ROT];
        /// Length over width of the wandering, along the fibre.
        elongation: 1.0, 40.0, 8.0, "[L] 5 to 20", log_uniform(5.0, 20.0), of [ROT, Amount("rot.front_mm")];
        /// Width of the dark rim of reaction before the front.
        rim_mm: 0.0, 20.0, 2.0, "[L] 1 to 4", uniform(1.0, 4.0), of [ROT];
        /// Width of discoloured, still hard wood before the front (incipient decay); 0 for none.
        incipient_mm: 0.0, 100.0, 0.0, "[L] 5 to 30", fixed, of [ROT];
        /// Length along the board of the decay at an edge; 0 for the whole edge.
        edge_length_mm: 0.0, 5000.0, 0.0, "[E] 30 to 500", fixed, of [Amount("rot.reach_mm")];
        /// How much severity varies inside, root mean square of its own.
        mottle: 0.0, 0.6, 0.25, "[E] 0.1 to 0.4", uniform(0.1, 0.4), of [ROT];
        /// Size across the grain of the cubes that brown rot cracks into; 0 for none.
        cube_mm: 0.0, 40.0, 0.0, "[L] brown rot 3 to 15", fixed, of [ROT];
        /// Share of the decay that white pockets take, spindles of bleached cellulose.
        white_pocket_share: 0.0, 0.6, 0.0, "[L] white pocket rot 0.1 to 0.4", fixed, of [ROT];
        /// Width of dark zone lines; 0 for none.
        zone_line_mm: 0.0, 3.0, 0.0, "[L] 0.3 to 1", fixed, of [ROT];
        /// How far the face sinks where decay is fully developed: severity 1, behind the front.
        loss_mm: 0.0, 20.0, 0.0, "[E] 0.2 to 2", fixed, of [ROT];
    }
}

parameters! {
    /// Optical coefficients of the kinds of wood at the laser's wavelength.
    media: Media {
        /// Absorption of earlywood.
        earlywood_mu_a_per_mm: 0.001, 20.0, 0.08, "[C] 0.04 to 0.16", log_uniform(0.04, 0.16);
        /// Isotropic reduced scattering of earlywood.
        earlywood_sigma_i_per_mm: 0.05, 50.0, 2.0, "[C] 1 to 4", log_uniform(1.0, 4.0);
        /// Cylinder scattering of earlywood.
        earlywood_k_per_mm: 0.0, 200.0, 10.0, "[C] 5 to 16", log_uniform(5.0, 16.0);
        /// Absorption of latewood over that of earlywood.
        latewood_mu_a_ratio: 0.2, 20.0, 2.5, "[C] goes with density, 800 over 320 kg/m3", log_uniform(1.8, 3.5);
        /// Isotropic reduced scattering of latewood over that of earlywood.
        latewood_sigma_i_ratio: 0.2, 5.0, 1.1, "[E] see docs/theory/wood.md", log_uniform(0.9, 1.3);
        /// Cylinder scattering of latewood over that of earlywood.
        latewood_k_ratio: 0.0, 5.0, 1.1, "[E] see docs/theory/wood.md", log_uniform(0.9, 1.3);
        /// Absorption of a sound knot over that of earlywood.
        knot_mu_a_ratio: 0.2, 50.0, 2.75, "[C] 1.3 to 3.4, see docs/theory/wood.md", log_uniform(1.3, 3.4),
            needs [GROWN], of [KNOTS];
        /// Absorption of a dead knot over that of earlywood.
        dead_knot_mu_a_ratio: 0.2, 100.0, 10.0, "[C]", log_uniform(6.5, 14.0), needs [GROWN], of [DEAD_KNOTS];
        /// Isotropic reduced scattering of knots over that of earlywood.
        knot_sigma_i_ratio: 0.2, 5.0, 1.5, "[C]", log_uniform(1.2, 1.9), needs [SEEN], of [KNOTS_OR_BARK];
        /// Cylinder scattering of knots over that of earlywood.
        knot_k_ratio: 0.0, 5.0, 1.4, "[C]", log_uniform(1.1, 1.75), needs [SEEN], of [KNOTS_OR_BARK];
        /// Absorption of bark.
        bark_mu_a_per_mm: 0.001, 50.0, 2.5, "[L] 1.5 to 4", log_uniform(1.5, 4.0), of [BARK];
        /// Absorption of rot at severity 0.5 over that of earlywood; it grows from the clear wood's with the severity.
        rot_mu_a_ratio: 0.2, 100.0, 6.25, "[C] 2.5 to 15", log_uniform(2.5, 15.0), of [ROT];
        /// Isotropic reduced scattering of rot at severity 0.5 over that of earlywood.
        rot_sigma_i_ratio: 0.2, 10.0, 2.0, "[C]", log_uniform(1.5, 2.6), of [ROT];
        /// Cylinder scattering of rot at severity 0.5 over that of earlywood.
        rot_k_ratio: 0.0, 5.0, 0.8, "[C]", uniform(0.6, 1.0), of [ROT];
        /// Absorption of heartwood over that of sapwood.
        heartwood_mu_a_ratio: 0.2, 10.0, 1.08, "[L] 0.95 to 1.15 in spruce, more in pine and larch",
            uniform(0.95, 1.15), of [Amount("log.heartwood_mm")];
        /// Absorption of the pith over that of earlywood.
        pith_mu_a_ratio: 0.2, 50.0, 5.0, "[E]", log_uniform(3.5, 7.0), of [Amount("log.pith_mm")];
        /// Absorption of compression wood over that of the wood it is in the place of.
        compression_mu_a_ratio: 0.2, 10.0, 3.0, "[E] spreads less light, see docs/theory/wood.md",
            log_uniform(2.5, 3.6), of [COMPRESSION];
        /// Isotropic reduced scattering of compression wood over that of the wood it is in the place of.
        compression_sigma_i_ratio: 0.2, 5.0, 1.12, "[E] grooved walls guide less light", log_uniform(1.05, 1.2),
            of [COMPRESSION];
        /// Cylinder scattering of compression wood over that of the wood it is in the place of.
        compression_k_ratio: 0.0, 5.0, 0.68, "[E] thick walls leave narrow lumina", log_uniform(0.6, 0.78),
            of [COMPRESSION];
        /// Effective refractive index of compression wood.
        compression_n_eff: 1.0, 1.55, 1.25, "[C]", uniform(1.22, 1.28), of [COMPRESSION];
        /// Absorption of fully blue-stained wood over that of the same wood without stain.
        stain_mu_a_ratio: 0.2, 50.0, 3.2, "[C] 0.35 per mm where clear wood has 0.11", log_uniform(2.2, 4.5),
            of [STAIN];
        /// Absorption of wood full of resin.
        resin_mu_a_per_mm: 0.001, 20.0, 0.12, "[C]", log_uniform(0.08, 0.18), of [RESIN];
        /// Isotropic reduced scattering of wood full of resin.
        resin_sigma_i_per_mm: 0.05, 50.0, 0.7, "[C]", log_uniform(0.5, 1.0), of [RESIN];
        /// Cylinder scattering of wood full of resin.
        resin_k_per_mm: 0.0, 50.0, 3.0, "[C]", log_uniform(2.0, 4.5), of [RESIN];
        /// Effective refractive index of wood full of resin.
        resin_n_eff: 1.0, 1.55, 1.45, "[C]", uniform(1.42, 1.48), of [RESIN];
        /// Standard deviation of single fibres' tilt against the grain in each of two directions.
        fibre_dispersion_deg: 3.0, 14.0, 5.0, "[E] see docs/theory/wood.md", uniform(4.0, 7.0), of [TANGLED];
        /// The same in a knot and at its border, from where it falls to that of clear wood at four radii.
        knot_fibre_dispersion_deg: 3.0, 14.0, 11.0, "[E] see docs/theory/wood.md", uniform(9.0, 13.0),
            needs [SEEN], of [KNOTS, TANGLED];
        /// Effective refractive index of clear wood.
        clear_n_eff: 1.0, 1.55, 1.18, "[C] density 420 kg/m3", uniform(1.15, 1.21);
        /// Effective refractive index of knots.
        knot_n_eff: 1.0, 1.55, 1.22, "[C]", uniform(1.19, 1.25), needs [SEEN], of [KNOTS_OR_BARK];
        /// Effective refractive index of rot.
        rot_n_eff: 1.0, 1.55, 1.15, "[C]", uniform(1.12, 1.18), of [ROT];
        /// Share of the surface that reflects like a dielectric facet.
        gloss: 0.0, 1.0, 0.3, "[C] 0.1 to 0.6", uniform(0.1, 0.6);
    }
}

parameters! {
    /// Compression wood of the stem: a crescent of dark, dense rings on the lower side of a leaning tree.
    compression: Compression {
        /// How far it is developed, 0 for none.
        severity: 0.0, 1.0, 0.0, "[C] 1 is the medium of the class table", fixed, needs [GROWN];
        /// Thickness of the crescent, outwards.
        width_mm: 1.0, 200.0, 12.0, "[E]", log_uniform(6.0, 25.0), of [COMPRESSION];
        /// Distance of its middle from the ring that the middle of the face shows, outwards.
        offset_mm: -200.0, 200.0, 0.0, "free", fixed, of [COMPRESSION];
        /// Direction of its middle from the pith; 0 points at the board's middle.
        azimuth_deg: -180.0, 180.0, 0.0, "free", fixed, of [COMPRESSION];
        /// Angle about the pith that it takes.
        arc_deg: 5.0, 360.0, 80.0, "[E]", uniform(60.0, 110.0), of [COMPRESSION];
    }
}

parameters! {
    /// Blue stain: fungi that colour the sapwood in wedges along the rays and leave its structure.
    stain: Stain {
        /// How dark it is, 0 for none.
        severity: 0.0, 1.0, 0.0, "[C] 1 is the medium of the class table", fixed, needs [GROWN];
        /// Wedges that the upper surface shows.
        wedge_count: 1.0, 50.0, 3.0, "[E]", uniform(1.0, 5.0), count, of [STAIN];
        /// Angle about the pith that a wedge takes, median.
        wedge_deg: 0.5, 90.0, 9.0, "[E]", log_uniform(6.0, 14.0), of [STAIN];
        /// Length of a wedge along the grain, median.
        length_mm: 5.0, 5000.0, 150.0, "[E]", log_uniform(90.0, 250.0), of [STAIN];
    }
}

parameters! {
    /// Resin in pockets and streaks, and bark that the tree enclosed.
    inclusions: Inclusions {
        /// Resin pockets that the upper surface shows.
        resin_pocket_count: 0.0, 50.0, 0.0, "per board", fixed, count, needs [GROWN];
        /// Resin streaks that the upper surface shows.
        resin_streak_count: 0.0, 50.0, 0.0, "per board", fixed, count, needs [GROWN];
        /// Bark pockets that the upper surface shows.
        bark_pocket_count: 0.0, 50.0, 0.0, "per board", fixed, count, needs [GROWN];
        /// Median length of a pocket along the grain.
        length_mm: 2.0, 300.0, 35.0, "[L] 10 to 80", log_uniform(10.0, 80.0), of [POCKETS];
        /// Median width of a pocket around the log; of a bark pocket, 0.3 times that.
        width_mm: 1.0, 100.0, 12.0, "[L] 5 to 30", log_uniform(5.0, 30.0), of [INCLUSIONS];
        /// Median thickness of a pocket outwards.
        thickness_mm: 0.2, 20.0, 2.5, "[L] 1 to 6", log_uniform(1.0, 6.0), of [INCLUSIONS];
        /// Median length of a streak along the grain; it is as wide and thick as a pocket.
        streak_length_mm: 10.0, 2000.0, 120.0, "[E]", log_uniform(70.0, 200.0),
            of [Amount("inclusions.resin_streak_count")];
    }
}

parameters! {
    /// Marks of handling and machining on the upper surface.
    marks: Marks {
        /// Spots of dirt.
        dirt_count: 0.0, 200.0, 0.0, "per board", fixed, count;
        /// Median size of a spot.
        dirt_mm: 0.3, 100.0, 6.0, "[E]", log_uniform(3.0, 12.0), of [Amount("marks.dirt_count")];
        /// Light that dirt lets through, each way.
        dirt_coat: 0.05, 0.99, 0.6, "[L] 0.45 to 0.9", uniform(0.45, 0.9), of [Amount("marks.dirt_count")];
        /// Depth of the marks of a serrated feed roller; 0 for none.
        roller_um: 0.0, 1000.0, 0.0, "[E] 50 to 300", fixed;
        /// Distance between two of its teeth.
        roller_pitch_mm: 1.0, 50.0, 5.0, "[E]", uniform(4.0, 6.5), of [Amount("marks.roller_um")];
        /// Width of the roller.
        roller_width_mm: 2.0, 200.0, 25.0, "[E]", uniform(20.0, 35.0), of [Amount("marks.roller_um")];
        /// Places that the planer has missed.
        skip_count: 0.0, 20.0, 0.0, "per board", fixed, count;
        /// Median length of such a place along the board; it is a third as wide.
        skip_mm: 5.0, 1000.0, 60.0, "[E]", log_uniform(30.0, 120.0), of [Amount("marks.skip_count")];
        /// How far it lies below the face.
        skip_um: 20.0, 2000.0, 250.0, "[E]", log_uniform(120.0, 500.0), of [Amount("marks.skip_count")];
        /// Places where an arris is chipped off.
        chip_count: 0.0, 200.0, 0.0, "per board", fixed, count;
        /// Median length of such a place along the arris.
        chip_mm: 0.5, 200.0, 8.0, "[E] 3 to 30", log_uniform(3.0, 30.0), of [Amount("marks.chip_count")];
        /// Burns across the board, where the planer's knives stood still.
        burn_count: 0.0, 20.0, 0.0, "per board", fixed, count;
        /// Median width of a burn along the board.
        burn_mm: 0.5, 100.0, 6.0, "[E]", log_uniform(3.0, 12.0), of [Amount("marks.burn_count")];
        /// Light that the middle of a burn lets through, each way.
        burn_coat: 0.05, 0.99, 0.45, "[E]", uniform(0.3, 0.6), of [Amount("marks.burn_count")];
    }
}

parameters! {
    /// Wet places of the face, or a board that is wet all over.
    moisture: Moisture {
        /// How many.
        patch_count: 0.0, 50.0, 0.0, "per board", fixed, count, of [Amount("moisture.filled")];
        /// Median width of one across the grain; it is two to four times as long.
        patch_mm: 2.0, 500.0, 25.0, "[E] 10 to 80", log_uniform(10.0, 80.0), of [Amount("moisture.patch_count")];
        /// Share of the lumina that is full of water in the middle of one.
        filled: 0.0, 1.0, 0.4, "[E] 0.1 to 0.8", uniform(0.1, 0.8), of [Amount("moisture.patch_count")];
        /// Share of the lumina that is full of water in the whole board.
        board_filled: 0.0, 1.0, 0.0, "[E] off; 0.3 to 0.9 of green sapwood", fixed;
        /// Share of the face that shines with a film of water instead of the gloss of dry wood.
        film: 0.0, 1.0, 0.0, "[E] off; 0.2 to 1 of a face in the rain", fixed;
        /// Roughness alpha of that film.
        film_roughness: 0.03, 0.6, 0.15, "[E] water levels, fibres stand out", log_uniform(0.08, 0.3),
            of [Amount("moisture.film")];
    }
}

parameters! {
    /// How the upper face was made, on top of the ripple and the roughness of `board`: marks of a planer's knives, of a
    /// band or frame saw, of a circular saw, of single teeth.
    machining: Machining {
        /// Height of a planer's knife marks, root mean square; 0 for a face that was not planed.
        planer_um: 0.0, 100.0, 0.0, "[E] 2 to 8", fixed;
        /// Distance between two knife marks.
        planer_pitch_mm: 0.4, 20.0, 1.6, "[L] 1 to 3", uniform(1.0, 3.0), of [Amount("machining.planer_um")];
        /// Height of the marks of a band or frame saw, root mean square; 0 for none.
        band_um: 0.0, 500.0, 0.0, "[E] 30 to 150", fixed;
        /// Distance between two of them: the feed a tooth or a stroke.
        band_pitch_mm: 0.4, 50.0, 2.5, "[E] 1 to 10", log_uniform(1.0, 10.0), of [Amount("machining.band_um")];
        /// Slant of the marks against the laser line; a frame saw's are straight across.
        band_slant_deg: -45.0, 45.0, 4.0, "[E]", uniform(0.0, 8.0), of [Amount("machining.band_um")];
        /// Height of the marks of a circular saw, root mean square; 0 for none.
        circular_um: 0.0, 500.0, 0.0, "[E] 20 to 120", fixed;
        /// Distance between two of them along the feed.
        circular_pitch_mm: 0.4, 50.0, 3.0, "[E] 1 to 10", log_uniform(1.0, 10.0), of [Amount("machining.circular_um")];
        /// Radius of the saw; one that is too small for the board is as large as it must be.
        circular_radius_mm: 40.0, 2000.0, 200.0, "[E] 100 to 500", log_uniform(100.0, 500.0),
            of [Amount("machining.circular_um")];
        /// Height of torn fibre and scores that single teeth of a saw leave, root mean square; 0 for none.
        teeth_um: 0.0, 200.0, 0.0, "[E] 3 to 12", fixed, needs [GROWN];
        /// Distance between two scores of the tooth that stands out.
        teeth_pitch_mm: 0.8, 50.0, 2.2, "[P] 1.9 to 2.6", uniform(1.9, 2.6), of [TEETH];
        /// Slant of scores and torn fibre against the laser line.
        teeth_slant_deg: -45.0, 45.0, 4.0, "[P] 2.5 to 5.4", uniform(2.5, 5.4), of [TEETH];
        /// Share of the scores in the root mean square; the rest is torn fibre.
        teeth_scores: 0.0, 1.0, 0.3, "[P] 0.2 to 0.7", uniform(0.2, 0.7), of [TEETH];
        /// Light that the hollows between torn fibres take, each way, for each root mean square of their depth.
        teeth_shade: 0.0, 0.2, 0.03, "[P] 0.035 to 0.06; spread [M]", uniform(0.03, 0.06), of [TEETH];
        /// How much cut and crushed cell walls between the marks vary light, each way, root mean square.
        teeth_mottle: 0.0, 0.1, 0.0, "[P] 0.01 to 0.03", fixed, of [TEETH];
    }
}

parameters! {
    /// What knives do to grain that dives against them.
    grain: Grain {
        /// Height and depth of torn grain, root mean square; 0 for none.
        torn_um: 0.0, 1000.0, 0.0, "[E] 30 to 300", fixed, needs [GROWN];
        /// Dive of the fibres where half of the grain tears.
        torn_dive_deg: 1.0, 60.0, 8.0, "[E]", uniform(6.0, 11.0), of [Any(&["grain.torn_um", "grain.fuzzy_um"])];
        /// Height of fuzz, fibres that are bent up and not cut, root mean square; 0 for none.
        fuzzy_um: 0.0, 300.0, 0.0, "[E] 20 to 80", fixed, needs [GROWN];
    }
}

parameters! {
    /// Resin canals, vessels and rays that the face cuts.
    anatomy: Anatomy {
        /// Resin canals across the grain, as in latewood; earlywood has 0.15 times as many.
        canals_per_mm2: 0.0, 20.0, 0.0, "[E] 0.5 to 2 in spruce", fixed, needs [GROWN];
        /// Diameter of a canal.
        canal_um: 20.0, 500.0, 90.0, "[L] 60 to 120 in spruce", uniform(60.0, 120.0),
            of [Amount("anatomy.canals_per_mm2")];
        /// Vessels across the grain, as in earlywood.
        pores_per_mm2: 0.0, 200.0, 0.0, "[E] oak 5 to 10, birch 40 to 100", fixed, needs [GROWN];
        /// Diameter of a vessel.
        pore_um: 20.0, 600.0, 100.0, "[E] oak 200 to 350, birch 60 to 120", uniform(60.0, 120.0), of [PORES];
        /// How ring-porous it is: 0 for vessels alike in all of a ring, 1 for few and narrow ones in latewood.
        pore_ring: 0.0, 1.0, 0.0, "free", fixed, of [PORES];
        /// Light that dust and shade in a vessel take, each way.
        pore_dust: 0.0, 0.9, 0.2, "[E]", uniform(0.1, 0.35), of [PORES];
        /// Rays' share of the volume.
        ray_share: 0.0, 0.3, 0.0, "[E] conifers 0.05, oak 0.2", fixed, needs [GROWN];
        /// Height of a ray along the grain.
        ray_height_mm: 0.05, 100.0, 0.2, "[L] conifers 0.1 to 0.3; [E] beech 2, oak 20", log_uniform(0.1, 0.3),
            of [RAYS];
        /// Width of a ray around the log.
        ray_width_um: 5.0, 2000.0, 20.0, "[L] conifers 10 to 20; [E] beech 100, oak 300", uniform(10.0, 20.0),
            of [RAYS];
        /// Absorption in a ray over that of the wood around.
        ray_mu_a_ratio: 0.2, 5.0, 1.1, "[E]", uniform(0.9, 1.3), of [RAYS];
    }
}

parameters! {
    /// The whole stem and where a board lies in it, for boards that are sawn from a stem.
    stem: StemParameters {
        /// Length of the stem.
        length_mm: 200.0, 20000.0, 4000.0, "[G]", fixed, needs [STEM];
        /// Mean radius halfway along it.
        radius_mm: 20.0, 600.0, 123.0, "[G]; spread [M]", log_uniform(105.0, 145.0), needs [STEM];
        /// Loss of radius along it, over a metre.
        taper_mm_per_m: 0.0, 30.0, 2.5, "[G]; spread [M]", uniform(1.5, 4.0), needs [STEM];
        /// Largest over smallest diameter of a section, but for its lobes.
        oval: 1.0, 1.6, 1.05, "[G]; spread [M]", uniform(1.02, 1.1), needs [STEM];
        /// Root mean square of the lobes of the outline over the radius.
        lobes: 0.0, 0.1, 0.012, "[G]; spread [M]", uniform(0.006, 0.02), needs [STEM];
        /// Distance of the mean pith from the middle of the outline over the radius.
        eccentricity: 0.0, 0.5, 0.05, "[G]; spread [M]", uniform(0.0, 0.1), needs [STEM];
        /// Wander of the pith about its mean line, root mean square of the distance.
        pith_wander_mm: 0.0, 30.0, 5.7, "[G] 5.3 about the line through 4 m; spread [M]", uniform(3.0, 8.0),
            needs [STEM];
        /// Median length of a year's shoot, which ends in a whorl.
        whorl_spacing_mm: 40.0, 1500.0, 125.0, "[G] see docs/theory/wood.md; spread [M]", log_uniform(90.0, 175.0),
            needs [STEM];
        /// Standard deviation of the logarithm of that length from year to year.
        whorl_spacing_log_sd: 0.0, 1.0, 0.2, "[G]; spread [M]", uniform(0.15, 0.3), needs [STEM];
        /// Mean number of branches in a whorl.
        whorl_branches: 0.0, 10.0, 2.7, "[G]; spread [M]", uniform(2.0, 3.5), needs [STEM];
        /// Spread of a whorl's branches along the stem, standard deviation.
        whorl_height_mm: 0.0, 100.0, 12.0, "[G]; spread [M]", uniform(8.0, 18.0), needs [STEM];
        /// Share of all branches that sit between the whorls.
        between_whorls: 0.0, 0.7, 0.25, "[G]; spread [M]", uniform(0.15, 0.35), needs [STEM];
        /// Median width of a whorl's branches 100 mm from the pith.
        branch_width_mm: 1.0, 80.0, 7.6, "[G] times 2 for fast-grown stock; spread [M]", log_uniform(5.5, 11.0),
            needs [STEM];
        /// Standard deviation of the logarithm of the width from branch to branch.
        branch_width_log_sd: 0.0, 1.5, 0.36, "[G]; spread [M]", uniform(0.25, 0.5), needs [STEM];
        /// Width of branches between the whorls over that of a whorl's.
        between_width: 0.05, 2.0, 0.36, "[G]; spread [M]", uniform(0.28, 0.48), needs [STEM];
        /// Change of the width's logarithm towards the side with most light; the other side loses as much.
        branch_side: 0.0, 1.0, 0.2, "[G]; spread [M]", uniform(0.1, 0.3), needs [STEM];
        /// Slope of the axes against the plane across the stem 100 mm from the pith, upwards positive, mean.
        branch_slope_deg: -45.0, 60.0, -12.0, "[G]; spread [M]", normal(-12.0, 4.0), needs [STEM];
        /// Spread of that slope from branch to branch.
        branch_slope_sd_deg: 0.0, 30.0, 8.0, "[G]; spread [M]", uniform(5.0, 11.0), needs [STEM];
        /// Median distance from the pith where branches die, over the stem's radius; those that die beyond its surface
        /// live.
        death_share: 0.05, 5.0, 0.78, "[G]; spread [M]", uniform(0.6, 1.0), needs [STEM];
        /// Standard deviation of the logarithm of that distance.
        death_log_sd: 0.0, 1.5, 0.48, "[G]; spread [M]", uniform(0.35, 0.6), needs [STEM];
        /// Median length of a dead stub over its width; a stub that ends inside the stem is grown over.
        stub_length: 0.0, 1000.0, 22.0, "[G]; spread [M]", log_uniform(14.0, 35.0), needs [STEM];
        /// How far growth layers follow the outline: 0 round about the pith, 1 oval and off-centre so that the last
        /// ring is the outline.
        rings_follow_outline: 0.0, 1.0, 0.0, "geometry; trees have 1 under the bark", fixed, needs [SAWN];
        /// 1 for wane wherever the outline leaves the upper face, with bark as `wane.bark` says; 0 for boards with full
        /// edges.
        outline_wane: 0.0, 1.0, 0.0, "free", fixed, count, needs [SAWN];
        /// Where the middle of the board lies along the stem; moved so that the board ends within the stem if it can.
        board_along_mm: 0.0, 20000.0, 2000.0, "free; spread [M]", uniform(500.0, 3500.0), needs [SAWN];
        /// Distance of the middle of the upper face from the pith.
        board_radius_mm: 0.0, 600.0, 70.0, "free; spread [M]", uniform(20.0, 90.0), needs [SAWN];
        /// Side of the stem on which that middle lies.
        board_azimuth_deg: -180.0, 180.0, 0.0, "free; spread [M]", uniform(-180.0, 180.0), needs [SAWN];
        /// Turn of the upper face's normal against the direction from the pith: 0 flat-sawn, 90 quarter-sawn, 180 bark
        /// side down.
        face_deg: -180.0, 180.0, 0.0, "free; spread [M]", uniform(-60.0, 60.0), needs [SAWN];
    }
}

parameters! {
    /// Where in a larger picture the board lies, for boards from pictures (`log.source: picture`).
    picture: PictureParameters {
        /// Place of the board along the picture: 0 at the near end, 1 at the far end of the room that it leaves.
        along: 0.0, 1.0, 0.5, "free; spread [M]", uniform(0.0, 1.0), needs [PICTURE];
        /// Place of the board across the picture: 0 at the left, 1 at the right of the room that it leaves.
        across: 0.0, 1.0, 0.5, "free; spread [M]", uniform(0.0, 1.0), needs [PICTURE];
        /// Whether the board is the mirror image of what the picture shows: 0 or 1.
        mirrored: 0.0, 1.0, 0.0, "free", one_of(0.0, 1.0), count, needs [PICTURE];
        /// Whether the board is turned end for end: 0 or 1.
        turned: 0.0, 1.0, 0.0, "free", one_of(0.0, 1.0), count, needs [PICTURE];
    }
}

parameters! {
    /// Where in a stack of slices the board lies, for boards from one (`log.source: slices`).
    slices: SlicesParameters {
        /// Place of the board along the fibres: 0 at the near end, 1 at the far end of the room that the stack leaves.
        along: 0.0, 1.0, 0.5, "free; spread [M]", uniform(0.0, 1.0), needs [SLICES];
        /// Place of the board across them: 0 at the left, 1 at the right of the room that the stack leaves.
        across: 0.0, 1.0, 0.5, "free; spread [M]", uniform(0.0, 1.0), needs [SLICES];
        /// Depth of its face below the side of the stack that lies up: 0 at that side, 1 as deep as the room goes.
        depth: 0.0, 1.0, 0.0, "free", fixed, needs [SLICES];
        /// Quarter turns of the stack about the fibres: which of its four sides lies up.
        quarter_turns: 0.0, 3.0, 0.0, "free", fixed, count, needs [SLICES];
        /// Whether the board is the mirror image of the wood in the stack, left for right: 0 or 1.
        mirrored: 0.0, 1.0, 0.0, "free", one_of(0.0, 1.0), count, needs [SLICES];
        /// Whether the board is turned end for end: 0 or 1.
        turned: 0.0, 1.0, 0.0, "free", one_of(0.0, 1.0), count, needs [SLICES];
    }
}
