//! The numbers that make a blister pack: card, pockets, tablets, film and foil; those of defects are in `defects`.
//!
//! Sources: [T] Kihl and Källberg 2021; [L] the literature named in docs/theory/blister.md; [M] engineering estimate.

use base::Need::{Amount, Any, Outline, RoomToStand};
use base::parameters;

parameters! {
    /// The card and how it lies on the conveyor, film up.
    pack: Card {
        /// Size along the laser line.
        width_mm: 10.0, 300.0, 58.0, "[M] 40 to 65", fixed;
        /// Size along the scan.
        length_mm: 10.0, 400.0, 56.0, "[M] 80 to 145 for whole cards", fixed;
        /// Radius of the corners.
        corner_mm: 0.0, 30.0, 5.0, "[M] 3 to 8", fixed;
        /// Pockets along the laser line; fewer where the card has no room for them.
        columns: 1.0, 20.0, 3.0, "[M] 2 to 5", fixed, count;
        /// Pockets along the scan; fewer where the card has no room for them.
        rows: 1.0, 30.0, 3.0, "[M] 2 to 5", fixed, count;
        /// Distance between pockets along the laser line; their own size where that is more.
        pitch_x_mm: 4.0, 60.0, 18.0, "[M] 13 to 22", fixed;
        /// Distance between pockets along the scan; their own size where that is more.
        pitch_y_mm: 4.0, 60.0, 17.0, "[M] 13 to 22", fixed;
        /// Centre of the card along the laser line.
        offset_mm: -500.0, 500.0, 0.0, "free; spread [M]", uniform(-0.5, 0.5);
        /// Conveyor before the card's front edge enters the laser.
        lead_in_mm: 0.0, 500.0, 6.0, "free", fixed;
        /// Turn of the card on the conveyor.
        turn_deg: -45.0, 45.0, 0.0, "free; spread [M]", normal(0.0, 0.8);
        /// Height of the card's middle over its edges along the laser line (bow).
        bow_mm: -3.0, 3.0, 0.1, "[M] 0.3", uniform(-0.1, 0.3);
        /// Height of its far corners against each other (curl).
        curl_mm: -3.0, 3.0, 0.1, "[M] 0.3", uniform(-0.1, 0.3);
        /// Distance between ridges of the sealing knurl.
        knurl_pitch_mm: 0.2, 5.0, 0.8, "[M] 0.5 to 1.2", uniform(0.5, 1.2), of [Amount("pack.knurl_um")];
        /// Height of the knurl that shows on the flange, peak to valley.
        knurl_um: 0.0, 200.0, 25.0, "[M] 10 to 40", uniform(10.0, 40.0);
        /// Depth of the embossed code; 0 for none.
        code_mm: 0.0, 0.5, 0.15, "[M] 0.1 to 0.3", uniform(0.1, 0.3);
        /// Distance between the cuts of the perforation between pockets along the laser line; 0 for none.
        perforation_mm: 0.0, 10.0, 0.0, "[M] 1.5 to 3", fixed;
    }
}

parameters! {
    /// The formed pockets; their outline is that of the tablet and some room.
    pocket: Pocket {
        /// Room beside the lying tablet where the wall comes nearest.
        clearance_mm: 0.1, 5.0, 0.6, "[M] 0.3 to 1", uniform(0.5, 0.7);
        /// Room above the lying tablet.
        headroom_mm: 0.1, 8.0, 0.6, "[M] 0.3 to 1", uniform(0.45, 0.75);
        /// Angle of the wall against the vertical.
        draft_deg: 3.0, 60.0, 15.0, "[M] 10 to 20", uniform(14.0, 16.0);
        /// Radius of the edge between flange and wall.
        edge_radius_mm: 0.1, 5.0, 0.8, "[M] 0.5 to 1.5", uniform(0.67, 0.93);
        /// Radius of the edge between wall and roof.
        shoulder_radius_mm: 0.2, 10.0, 1.6, "[M]", uniform(1.3, 1.9);
        /// Height of the roof's middle over its rim.
        dome_mm: 0.0, 5.0, 0.5, "[M]", uniform(0.35, 0.65);
        /// Turn of the pockets' long axis against the laser line.
        turn_deg: -90.0, 90.0, 0.0, "free", fixed;
        /// Small bumps and crevices of the formed film, root mean square; at most a twentieth of their size.
        bumps_um: 0.0, 300.0, 25.0, "[T] seen, not measured; spread [M]", log_uniform(15.0, 40.0);
        /// Size of them.
        bump_size_mm: 0.3, 20.0, 2.5, "[M]", log_uniform(1.5, 4.0),
            of [Any(&["pocket.bumps_um", "film.thinning_spread"])];
    }
}

parameters! {
    /// The tablets.
    tablet: Tablet {
        /// Outline: 0 ellipse (round where length equals width), 1 stadium (caplet), 2 hard capsule.
        shape: 0.0, 2.0, 0.0, "free", fixed, count, of [Outline];
        /// Length.
        length_mm: 2.0, 30.0, 11.0, "[L] 6 to 13 round, 14 to 19 caplets", fixed;
        /// Width; the longer of length and width is the long axis.
        width_mm: 2.0, 20.0, 11.0, "[L] 6 to 13 round, 6 to 9 caplets", fixed;
        /// Thickness over all; hard capsules are as thick as wide.
        thickness_mm: 0.5, 15.0, 4.6, "[L] 4 to 6; spread [M]", uniform(4.5, 4.7);
        /// Height of the straight side; the rest is shared by two caps, and none is left for a flat tablet.
        band_mm: 0.2, 15.0, 2.4, "[L] 1.5 to 3.5; spread [M]", uniform(2.3, 2.5);
        /// Depth of the score line; 0 for none.
        score_mm: 0.0, 1.0, 0.0, "[L] 0.3", fixed;
        /// Depth of the debossed mark; 0 for none.
        deboss_mm: 0.0, 1.0, 0.2, "[L] 0.15 to 0.3", uniform(0.15, 0.3);
        /// Absorption.
        mu_a_per_mm: 0.0001, 20.0, 0.005, "[M] 0.002 to 0.01", log_uniform(0.002, 0.01);
        /// Reduced scattering.
        sigma_per_mm: 1.0, 300.0, 40.0, "[M] 20 to 80", log_uniform(20.0, 80.0);
        /// Refractive index.
        n: 1.3, 1.55, 1.5, "[M]", uniform(1.45, 1.54);
        /// Share of light that the coat lets through, each way.
        coat: 0.05, 1.0, 1.0, "[M] 1 white, 0.6 to 0.9 coloured", fixed;
        /// Share of the surface that is glossy.
        gloss: 0.0, 1.0, 0.6, "[M]", uniform(0.4, 0.8);
        /// Roughness alpha of the gloss.
        roughness: 0.05, 1.0, 0.3, "[M] 0.25 to 0.4", uniform(0.25, 0.4);
        /// Standard deviation of the tilt in the pocket, as far as there is room.
        tilt_deg: 0.0, 40.0, 4.0, "[M] 0 to 25", uniform(0.0, 25.0);
        /// Part of the room in the pocket that the tablet may be off its middle.
        rattle: 0.0, 1.0, 0.8, "[M]", uniform(0.6, 1.0);
        /// Share of tablets that stand on their edge, where there is room.
        on_edge: 0.0, 1.0, 0.01, "[M]", log_uniform(0.003, 0.03), of [RoomToStand];
    }
}

parameters! {
    /// The formed film.
    film: Web {
        /// Thickness of the flange.
        thickness_mm: 0.05, 1.0, 0.25, "[L] 0.19 to 0.38", uniform(0.19, 0.38);
        /// Part of the thickness that stretching takes where it would by the drawn area; 1 by geometry.
        thinning: 0.0, 1.5, 1.0, "[M] t = t0 flat area / formed area", uniform(0.8, 1.1);
        /// Relative variation of the formed thickness from place to place.
        thinning_spread: 0.0, 0.5, 0.1, "[M] 0.3", uniform(0.05, 0.3);
        /// Reduced scattering by the pigment.
        sigma_per_mm: 0.01, 200.0, 12.0, "[M] 4 to 40, opaque 60 to 150; of one film 6 to 20", log_uniform(6.0, 20.0);
        /// Absorption by the tint.
        mu_a_per_mm: 0.0005, 10.0, 0.02, "[M] 0.005 to 1", log_uniform(0.005, 0.2);
        /// Refractive index.
        n: 1.4, 1.55, 1.53, "[L] PVC 1.53 to 1.55", uniform(1.53, 1.55);
        /// Roughness alpha of the flange's gloss.
        roughness: 0.03, 1.0, 0.05, "[M] 0.03 to 0.15", log_uniform(0.03, 0.15);
        /// Roughness alpha of the formed film's gloss.
        formed_roughness: 0.03, 1.0, 0.15, "[M] 0.1 to 0.3", log_uniform(0.1, 0.3);
    }
}

parameters! {
    /// The aluminium foil that closes the pockets from below.
    foil: Foil {
        /// Thickness.
        thickness_mm: 0.01, 0.2, 0.025, "[M] 20 to 25 um", uniform(0.02, 0.025);
        /// Reflectance.
        reflectance: 0.51, 0.99, 0.9, "[L] 0.907 at 633 nm, 0.868 at 800 nm; spread [M]", uniform(0.87, 0.91);
        /// Roughness alpha along the rolling direction.
        roughness_along: 0.03, 1.0, 0.1, "[M] 0.08 to 0.15", uniform(0.08, 0.15);
        /// Roughness alpha across the rolling direction.
        roughness_across: 0.03, 1.0, 0.3, "[M] 0.2 to 0.35", uniform(0.2, 0.35);
        /// Whether the foil was rolled along the laser line (1) or along the scan (0).
        rolled_along_line: 0.0, 1.0, 0.0, "free", fixed, count;
    }
}
