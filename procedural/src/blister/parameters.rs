//! The numbers that make a blister pack: card, pockets, tablets, film, foil and defects.
//!
//! Sources: [T] Kihl and Källberg 2021; [L] the literature named in docs/theory/blister.md; [M] engineering estimate.

use base::Need::{self, Amount, Any, Outline, RoomToStand};
use base::parameters;

/// Paths of the numbers that say how many of each defect a pack has.
pub const DEFECT_COUNTS: [&str; 19] = [
    "defects.missing",
    "defects.broken",
    "defects.chipped",
    "defects.cracked",
    "defects.capped",
    "defects.foreign_tablet",
    "defects.wrong_coat",
    "defects.double",
    "defects.particle",
    "defects.fibre",
    "defects.powder",
    "defects.shallow",
    "defects.collapsed",
    "defects.punctured",
    "defects.pinhole",
    "defects.channel",
    "defects.wrinkle",
    "defects.delamination",
    "defects.tablet_on_flange",
];

const DEFECTS: Need = Any(&DEFECT_COUNTS);

/// Those of them that a pocket has at most one of: all but the last three, which lie on the flange.
pub const POCKET_DEFECT_COUNTS: &[&str] = DEFECT_COUNTS.split_at(DEFECT_COUNTS.len() - 3).0;

/// Defects that exclude each other in a pocket: another content, or a damaged tablet.
pub const EXCLUSIVE_DEFECT_COUNTS: [&str; 8] = [
    "defects.missing",
    "defects.foreign_tablet",
    "defects.double",
    "defects.shallow",
    "defects.broken",
    "defects.chipped",
    "defects.cracked",
    "defects.capped",
];

parameters! {
    /// The card and how it lies on the conveyor, film up.
    pack: Card {
        /// Size along the laser line.
        width_mm: 10.0, 300.0, 58.0, "[M] 40 to 65";
        /// Size along the scan.
        length_mm: 10.0, 400.0, 56.0, "[M] 80 to 145 for whole cards";
        /// Radius of the corners.
        corner_mm: 0.0, 30.0, 5.0, "[M] 3 to 8";
        /// Pockets along the laser line; fewer where the card has no room for them.
        columns: 1.0, 20.0, 3.0, "[M] 2 to 5", count;
        /// Pockets along the scan; fewer where the card has no room for them.
        rows: 1.0, 30.0, 3.0, "[M] 2 to 5", count;
        /// Distance between pockets along the laser line; their own size where that is more.
        pitch_x_mm: 4.0, 60.0, 18.0, "[M] 13 to 22";
        /// Distance between pockets along the scan; their own size where that is more.
        pitch_y_mm: 4.0, 60.0, 17.0, "[M] 13 to 22";
        /// Centre of the card along the laser line.
        offset_mm: -500.0, 500.0, 0.0, "free";
        /// Conveyor before the card's front edge enters the laser.
        lead_in_mm: 0.0, 500.0, 6.0, "free";
        /// Turn of the card on the conveyor.
        turn_deg: -45.0, 45.0, 0.0, "free";
        /// Height of the card's middle over its edges along the laser line (bow).
        bow_mm: -3.0, 3.0, 0.1, "[M] 0.3";
        /// Height of its far corners against each other (curl).
        curl_mm: -3.0, 3.0, 0.1, "[M] 0.3";
        /// Distance between ridges of the sealing knurl.
        knurl_pitch_mm: 0.2, 5.0, 0.8, "[M] 0.5 to 1.2", of [Amount("pack.knurl_um")];
        /// Height of the knurl that shows on the flange, peak to valley.
        knurl_um: 0.0, 200.0, 25.0, "[M] 10 to 40";
        /// Depth of the embossed code; 0 for none.
        code_mm: 0.0, 0.5, 0.15, "[M] 0.1 to 0.3";
        /// Distance between the cuts of the perforation between pockets along the laser line; 0 for none.
        perforation_mm: 0.0, 10.0, 0.0, "[M] 1.5 to 3";
    }
}

parameters! {
    /// The formed pockets; their outline is that of the tablet and some room.
    pocket: Pocket {
        /// Room beside the lying tablet where the wall comes nearest.
        clearance_mm: 0.1, 5.0, 0.6, "[M] 0.3 to 1";
        /// Room above the lying tablet.
        headroom_mm: 0.1, 8.0, 0.6, "[M] 0.3 to 1";
        /// Angle of the wall against the vertical.
        draft_deg: 3.0, 60.0, 15.0, "[M] 10 to 20";
        /// Radius of the edge between flange and wall.
        edge_radius_mm: 0.1, 5.0, 0.8, "[M] 0.5 to 1.5";
        /// Radius of the edge between wall and roof.
        shoulder_radius_mm: 0.2, 10.0, 1.6, "[M]";
        /// Height of the roof's middle over its rim.
        dome_mm: 0.0, 5.0, 0.5, "[M]";
        /// Turn of the pockets' long axis against the laser line.
        turn_deg: -90.0, 90.0, 0.0, "free";
        /// Small bumps and crevices of the formed film, root mean square; at most a twentieth of their size.
        bumps_um: 0.0, 300.0, 25.0, "[T] seen, not measured";
        /// Size of them.
        bump_size_mm: 0.3, 20.0, 2.5, "[M]", of [Any(&["pocket.bumps_um", "film.thinning_spread"])];
    }
}

parameters! {
    /// The tablets.
    tablet: Tablet {
        /// Outline: 0 ellipse (round where length equals width), 1 stadium (caplet), 2 hard capsule.
        shape: 0.0, 2.0, 0.0, "free", count, of [Outline];
        /// Length.
        length_mm: 2.0, 30.0, 11.0, "[L] 6 to 13 round, 14 to 19 caplets";
        /// Width; the longer of length and width is the long axis.
        width_mm: 2.0, 20.0, 11.0, "[L] 6 to 13 round, 6 to 9 caplets";
        /// Thickness over all; hard capsules are as thick as wide.
        thickness_mm: 0.5, 15.0, 4.6, "[L] 4 to 6";
        /// Height of the straight side; the rest is shared by two caps, and none is left for a flat tablet.
        band_mm: 0.2, 15.0, 2.4, "[L] 1.5 to 3.5";
        /// Depth of the score line; 0 for none.
        score_mm: 0.0, 1.0, 0.0, "[L] 0.3";
        /// Depth of the debossed mark; 0 for none.
        deboss_mm: 0.0, 1.0, 0.2, "[L] 0.15 to 0.3";
        /// Absorption.
        mu_a_per_mm: 0.0001, 20.0, 0.005, "[M] 0.002 to 0.01";
        /// Reduced scattering.
        sigma_per_mm: 1.0, 300.0, 40.0, "[M] 20 to 80";
        /// Refractive index.
        n: 1.3, 1.55, 1.5, "[M]";
        /// Share of light that the coat lets through, each way.
        coat: 0.05, 1.0, 1.0, "[M] 1 white, 0.6 to 0.9 coloured";
        /// Share of the surface that is glossy.
        gloss: 0.0, 1.0, 0.6, "[M]";
        /// Roughness alpha of the gloss.
        roughness: 0.05, 1.0, 0.3, "[M] 0.25 to 0.4";
        /// Standard deviation of the tilt in the pocket, as far as there is room.
        tilt_deg: 0.0, 40.0, 4.0, "[M] 0 to 25";
        /// Part of the room in the pocket that the tablet may be off its middle.
        rattle: 0.0, 1.0, 0.8, "[M]";
        /// Share of tablets that stand on their edge, where there is room.
        on_edge: 0.0, 1.0, 0.01, "[M]", of [RoomToStand];
    }
}

parameters! {
    /// The formed film.
    film: Web {
        /// Thickness of the flange.
        thickness_mm: 0.05, 1.0, 0.25, "[L] 0.19 to 0.38";
        /// Part of the thickness that stretching takes where it would by the drawn area; 1 by geometry.
        thinning: 0.0, 1.5, 1.0, "[M] t = t0 flat area / formed area";
        /// Relative variation of the formed thickness from place to place.
        thinning_spread: 0.0, 0.5, 0.1, "[M] 0.3";
        /// Reduced scattering by the pigment.
        sigma_per_mm: 0.01, 200.0, 12.0, "[M] 4 to 40, opaque 60 to 150";
        /// Absorption by the tint.
        mu_a_per_mm: 0.0005, 10.0, 0.02, "[M] 0.005 to 1";
        /// Refractive index.
        n: 1.4, 1.55, 1.53, "[L] PVC 1.53 to 1.55";
        /// Roughness alpha of the flange's gloss.
        roughness: 0.03, 1.0, 0.05, "[M] 0.03 to 0.15";
        /// Roughness alpha of the formed film's gloss.
        formed_roughness: 0.03, 1.0, 0.15, "[M] 0.1 to 0.3";
    }
}

parameters! {
    /// The aluminium foil that closes the pockets from below.
    foil: Foil {
        /// Thickness.
        thickness_mm: 0.01, 0.2, 0.025, "[M] 20 to 25 um";
        /// Reflectance.
        reflectance: 0.51, 0.99, 0.9, "[L] 0.907 at 633 nm, 0.868 at 800 nm";
        /// Roughness alpha along the rolling direction.
        roughness_along: 0.03, 1.0, 0.1, "[M] 0.08 to 0.15";
        /// Roughness alpha across the rolling direction.
        roughness_across: 0.03, 1.0, 0.3, "[M] 0.2 to 0.35";
        /// Whether the foil was rolled along the laser line (1) or along the scan (0).
        rolled_along_line: 0.0, 1.0, 0.0, "free", count;
    }
}

parameters! {
    /// How many of each defect a pack has, and how bad they are.
    defects: Defects {
        /// Pockets without tablet.
        missing: 0.0, 600.0, 0.0, "free", count;
        /// Broken tablets.
        broken: 0.0, 600.0, 0.0, "free", count;
        /// Tablets with a chipped edge.
        chipped: 0.0, 600.0, 0.0, "free", count;
        /// Cracked tablets.
        cracked: 0.0, 600.0, 0.0, "free", count;
        /// Tablets that lost a cap.
        capped: 0.0, 600.0, 0.0, "free", count;
        /// Pockets with another product.
        foreign_tablet: 0.0, 600.0, 0.0, "free", count;
        /// Tablets of the wrong colour, or with a damaged coat.
        wrong_coat: 0.0, 600.0, 0.0, "free", count;
        /// Pockets with two tablets.
        double: 0.0, 600.0, 0.0, "free", count;
        /// Foreign particles, in pockets.
        particle: 0.0, 600.0, 0.0, "free", count;
        /// Foreign fibres, in pockets.
        fibre: 0.0, 600.0, 0.0, "free", count;
        /// Pockets with powder.
        powder: 0.0, 600.0, 0.0, "free", count;
        /// Pockets that were not formed to their full depth.
        shallow: 0.0, 600.0, 0.0, "free", count;
        /// Pockets with a dent.
        collapsed: 0.0, 600.0, 0.0, "free", count;
        /// Pockets with a hole.
        punctured: 0.0, 600.0, 0.0, "free", count;
        /// Holes in the foil.
        pinhole: 0.0, 600.0, 0.0, "free", count;
        /// Channels through the seal.
        channel: 0.0, 600.0, 0.0, "free", count;
        /// Wrinkles of the foil.
        wrinkle: 0.0, 600.0, 0.0, "free", count;
        /// Places where film and foil have come apart.
        delamination: 0.0, 600.0, 0.0, "free", count;
        /// Tablets caught beside the pockets.
        tablet_on_flange: 0.0, 600.0, 0.0, "free", count;
        /// Severity of the worst, from barely there to as bad as its kind can be; each defect's own lies between half
        /// and all of it.
        severity: 0.0, 1.0, 0.6, "free", of [DEFECTS];
    }
}

/// Everything that makes a pack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blister {
    /// Card.
    pub card: Card,
    /// Pockets.
    pub pocket: Pocket,
    /// Tablets.
    pub tablet: Tablet,
    /// Film.
    pub web: Web,
    /// Foil.
    pub foil: Foil,
    /// Defects.
    pub defects: Defects,
}

impl Blister {
    /// Fills every field from `value`, asked once for each declaration, group by group.
    pub fn from_values(value: &mut dyn FnMut(&'static base::Parameter) -> f64) -> Self {
        Self {
            card: Card::from_values(value),
            pocket: Pocket::from_values(value),
            tablet: Tablet::from_values(value),
            web: Web::from_values(value),
            foil: Foil::from_values(value),
            defects: Defects::from_values(value),
        }
    }

    /// Every declaration with its value here, in the same order.
    pub fn values(&self) -> Vec<(&'static base::Parameter, f64)> {
        let groups = [
            self.card.values(),
            self.pocket.values(),
            self.tablet.values(),
            self.web.values(),
            self.foil.values(),
            self.defects.values(),
        ];
        groups.into_iter().flatten().collect()
    }
}
