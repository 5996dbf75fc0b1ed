//! Conditional parameters: those that have an effect beside some settings, parameters or matter alone.
//!
//! A number that has no effect under the other keys of a recipe is a fault where a recipe gives it another value than its
//! default: nothing that is written is passed over in silence.

use std::collections::BTreeMap;

use super::bounds::DrawBounds;
use crate::class::Class;
use crate::distribution::Distribution;
use crate::keys;
use crate::keys::idle::{Idle, Wording};
use crate::keys::settings::Settings;
use crate::subject::Subject;
use bench::settings::{Fan, Filter, LineShape, LogSource, Movement, Scheimpflug, TransportName, Words};
use procedural::blister::parameters::DEFECT_COUNTS;
use procedural::wood::widest_tube_um;
use yaml::YamlReader;

/// What a parameter needs to have an effect.
#[derive(Debug, Clone, Copy)]
pub(super) enum ParameterNeeds {
    /// A movement of the object.
    Movement(Movement),
    /// One of some shapes of the laser's line.
    Profile(&'static [LineShape]),
    /// A lens of the laser.
    Fan(Fan),
    /// Who says how the sensor stands.
    Scheimpflug(Scheimpflug),
    /// A filter before the lens.
    Filter(Filter),
    /// One of some models of light below the surface.
    Transport(&'static [TransportName]),
    /// Facets of metal.
    Facets,
    /// Fibres.
    Fibres,
    /// Another parameter that can be other than 0, by its path.
    Amount(&'static str),
    /// A factor that can be other than 1, by its path.
    Factor(&'static str),
    /// One of several such parameters.
    Any(&'static [&'static str]),
    /// The same, or boards of some sources, which have knots whatever is counted.
    AnyKnots(&'static [LogSource], &'static [&'static str]),
    /// Where the log comes from, of some.
    Log(&'static [LogSource]),
    /// Room for a tablet that stands on its edge.
    RoomToStand,
    /// A tablet that is no ellipse or stadium as long as wide: of these both are a circle.
    Outline,
}

use ParameterNeeds::{Amount, Any, Facets, Fibres, Outline, Profile, RoomToStand};

const BEAM: ParameterNeeds = Profile(&[LineShape::Gaussian, LineShape::Point]);
const BEAM_OR_SLIT: ParameterNeeds = Profile(&[LineShape::Gaussian, LineShape::Slit]);
const LINE: ParameterNeeds = Profile(&[LineShape::Gaussian, LineShape::Slit, LineShape::Texture]);
const GAUSSIAN: ParameterNeeds = Profile(&[LineShape::Gaussian]);
const SLIT: ParameterNeeds = Profile(&[LineShape::Slit]);
const TEXTURE: ParameterNeeds = Profile(&[LineShape::Texture]);
const POINT: ParameterNeeds = Profile(&[LineShape::Point]);
const POWELL: ParameterNeeds = ParameterNeeds::Fan(Fan::Powell);
const TURNTABLE: ParameterNeeds = ParameterNeeds::Movement(Movement::Turntable);
const GIVEN: ParameterNeeds = ParameterNeeds::Scheimpflug(Scheimpflug::Given);
const BAND_PASS: ParameterNeeds = ParameterNeeds::Filter(Filter::BandPass);

const PLACED: ParameterNeeds = ParameterNeeds::Log(&[LogSource::Placed]);
const STEM: ParameterNeeds = ParameterNeeds::Log(&[LogSource::Stem]);
const SAWN: ParameterNeeds = ParameterNeeds::Log(&[LogSource::Stem, LogSource::Measured]);
const GROWN: ParameterNeeds = ParameterNeeds::Log(&[LogSource::Placed, LogSource::Stem, LogSource::Measured]);
const PICTURE: ParameterNeeds = ParameterNeeds::Log(&[LogSource::Picture]);
const SLICES: ParameterNeeds = ParameterNeeds::Log(&[LogSource::Slices]);
/// What a picture can show and a log has, and densities do not tell.
const SEEN: ParameterNeeds =
    ParameterNeeds::Log(&[LogSource::Placed, LogSource::Stem, LogSource::Measured, LogSource::Picture]);

/// Every conditional parameter by its path; of several needs the first that is not met is told.
const CONDITIONAL: &[(&str, &[ParameterNeeds])] = &[
    ("motion.turn_radius_mm", &[TURNTABLE]),
    ("motion.turn_axis_x_mm", &[TURNTABLE]),
    ("motion.turn_axis_y_mm", &[TURNTABLE]),
    ("motion.wow_period_mm", &[Amount("motion.wow_um")]),
    ("laser.waist_mm", &[BEAM]),
    ("laser.waist_height_mm", &[BEAM]),
    ("laser.m_squared", &[BEAM]),
    ("laser.fan_angle_deg", &[BEAM_OR_SLIT]),
    ("laser.fan_ripple", &[BEAM_OR_SLIT]),
    ("laser.fan_soft_ends", &[BEAM_OR_SLIT, POWELL]),
    ("laser.width_jitter", &[BEAM_OR_SLIT]),
    ("laser.width_jitter_mm", &[BEAM_OR_SLIT, Amount("laser.width_jitter")]),
    ("laser.smile_um", &[LINE]),
    ("laser.smile_cubic_um", &[LINE]),
    ("laser.second_line_mm", &[LINE]),
    ("laser.second_line_share", &[LINE, Amount("laser.second_line_mm")]),
    ("laser.lobe_share", &[GAUSSIAN]),
    ("laser.lobe_pairs", &[GAUSSIAN, Amount("laser.lobe_share")]),
    ("laser.lobe_distance", &[GAUSSIAN, Amount("laser.lobe_share")]),
    ("laser.skirt_share", &[GAUSSIAN]),
    ("laser.skirt_width", &[GAUSSIAN, Amount("laser.skirt_share")]),
    ("laser.line_width_mm", &[SLIT]),
    ("laser.texture_length_mm", &[TEXTURE]),
    ("laser.texture_width_mm", &[TEXTURE]),
    ("laser.point_x_mm", &[POINT]),
    ("laser.point_step_mm", &[POINT]),
    ("laser.point_span_mm", &[POINT]),
    ("laser.streaks_per_mm", &[Fibres]),
    ("laser.streak_width_um", &[Amount("laser.streaks_per_mm")]),
    ("laser.streak_length_mm", &[Amount("laser.streaks_per_mm")]),
    ("laser.streak_share", &[Amount("laser.streaks_per_mm")]),
    ("laser.glints_per_mm", &[Facets]),
    ("laser.glint_gain", &[Amount("laser.glints_per_mm")]),
    ("laser.glint_length_mm", &[Amount("laser.glints_per_mm")]),
    ("camera.sensor_tilt_deg", &[GIVEN]),
    ("camera.focus_distance_mm", &[GIVEN]),
    ("camera.filter_centre_nm", &[BAND_PASS]),
    ("camera.filter_width_nm", &[BAND_PASS]),
    ("material.fibre_azimuth_deg", &[Amount("material.k_per_mm")]),
    ("material.fibre_dive_deg", &[Amount("material.k_per_mm")]),
    ("material.fibre_dispersion_deg", &[Amount("material.k_per_mm")]),
    ("knots.sound_count", &[PLACED]),
    ("knots.dead_count", &[PLACED]),
    ("knots.hole_count", &[PLACED]),
    ("knots.hole_depth_mm", &[PLACED]),
    ("knots.loose_count", &[PLACED]),
    ("knots.loose_gap_mm", &[PLACED]),
    ("knots.loose_sunk_mm", &[PLACED]),
    ("knots.width_mm", &[PLACED]),
    ("knots.width_log_sd", &[PLACED]),
    ("knots.slope_deg", &[PLACED]),
    ("knots.slope_sd_deg", &[PLACED]),
    ("knots.death_share", &[PLACED]),
    ("log.pith_depth_mm", &[PLACED]),
    ("log.pith_offset_mm", &[PLACED]),
    ("log.pith_wander_mm", &[PLACED]),
    ("stem.length_mm", &[STEM]),
    ("stem.radius_mm", &[STEM]),
    ("stem.taper_mm_per_m", &[STEM]),
    ("stem.oval", &[STEM]),
    ("stem.lobes", &[STEM]),
    ("stem.eccentricity", &[STEM]),
    ("stem.pith_wander_mm", &[STEM]),
    ("stem.whorl_spacing_mm", &[STEM]),
    ("stem.whorl_spacing_log_sd", &[STEM]),
    ("stem.whorl_branches", &[STEM]),
    ("stem.whorl_height_mm", &[STEM]),
    ("stem.between_whorls", &[STEM]),
    ("stem.branch_width_mm", &[STEM]),
    ("stem.branch_width_log_sd", &[STEM]),
    ("stem.between_width", &[STEM]),
    ("stem.branch_side", &[STEM]),
    ("stem.branch_slope_deg", &[STEM]),
    ("stem.branch_slope_sd_deg", &[STEM]),
    ("stem.death_share", &[STEM]),
    ("stem.death_log_sd", &[STEM]),
    ("stem.stub_length", &[STEM]),
    ("stem.rings_follow_outline", &[SAWN]),
    ("stem.outline_wane", &[SAWN]),
    ("stem.board_along_mm", &[SAWN]),
    ("stem.board_radius_mm", &[SAWN]),
    ("stem.board_azimuth_deg", &[SAWN]),
    ("stem.face_deg", &[SAWN]),
    ("log.pith_tilt_deg", &[GROWN]),
    ("log.grain_angle_deg", &[GROWN]),
    ("log.turned", &[GROWN]),
    ("log.spiral_deg", &[GROWN]),
    ("log.spiral_slope_deg_per_mm", &[GROWN]),
    ("log.ring_width_mm", &[GROWN]),
    ("log.ring_width_log_sd", &[GROWN]),
    ("log.ring_width_correlation", &[GROWN]),
    ("log.ring_width_pith_ratio", &[GROWN]),
    ("log.ring_width_trend_rings", &[GROWN]),
    ("log.juvenile_rings", &[GROWN]),
    ("log.juvenile_latewood_ratio", &[GROWN]),
    ("log.streak", &[GROWN]),
    ("log.heartwood_mm", &[GROWN]),
    ("log.pith_mm", &[GROWN]),
    ("knots.flow_ratio", &[GROWN]),
    ("knots.bark_mm", &[GROWN]),
    ("rot.reach_mm", &[GROWN]),
    ("rot.heart_mm", &[GROWN]),
    ("rot.pocket_count", &[GROWN]),
    ("compression.severity", &[GROWN]),
    ("grain.torn_um", &[GROWN]),
    ("grain.fuzzy_um", &[GROWN]),
    ("anatomy.canals_per_mm2", &[GROWN]),
    ("anatomy.pores_per_mm2", &[GROWN]),
    ("anatomy.ray_share", &[GROWN]),
    ("stain.severity", &[GROWN]),
    ("inclusions.resin_pocket_count", &[GROWN]),
    ("inclusions.resin_streak_count", &[GROWN]),
    ("inclusions.bark_pocket_count", &[GROWN]),
    ("media.knot_mu_a_ratio", &[GROWN]),
    ("media.dead_knot_mu_a_ratio", &[GROWN]),
    ("log.latewood_share", &[SEEN]),
    ("media.knot_sigma_i_ratio", &[SEEN]),
    ("media.knot_k_ratio", &[SEEN]),
    ("media.knot_n_eff", &[SEEN]),
    ("media.knot_fibre_dispersion_deg", &[SEEN]),
    ("picture.along", &[PICTURE]),
    ("picture.across", &[PICTURE]),
    ("picture.mirrored", &[PICTURE]),
    ("picture.turned", &[PICTURE]),
    ("slices.along", &[SLICES]),
    ("slices.across", &[SLICES]),
    ("slices.depth", &[SLICES]),
    ("slices.quarter_turns", &[SLICES]),
    ("slices.mirrored", &[SLICES]),
    ("slices.turned", &[SLICES]),
];

/// Boards whose knots are not counted.
const KNOTTY: &[LogSource] = &[LogSource::Stem, LogSource::Measured, LogSource::Picture];
const KNOTS: ParameterNeeds = ParameterNeeds::AnyKnots(
    KNOTTY,
    &["knots.sound_count", "knots.dead_count", "knots.hole_count", "knots.loose_count"],
);
const DEAD_KNOTS: ParameterNeeds =
    ParameterNeeds::AnyKnots(KNOTTY, &["knots.dead_count", "knots.hole_count", "knots.loose_count"]);
/// Branches of a stem have bark, knots in pictures and slices have none.
const BARK: ParameterNeeds = ParameterNeeds::AnyKnots(
    &[LogSource::Stem, LogSource::Measured],
    &[
        "knots.dead_count",
        "knots.hole_count",
        "knots.loose_count",
        "inclusions.bark_pocket_count",
        "wane.width_mm",
        "stem.outline_wane",
    ],
);
/// Bark scatters as knots do.
const KNOTS_OR_BARK: ParameterNeeds = ParameterNeeds::AnyKnots(
    KNOTTY,
    &[
        "knots.sound_count",
        "knots.dead_count",
        "knots.hole_count",
        "knots.loose_count",
        "inclusions.bark_pocket_count",
        "wane.width_mm",
        "stem.outline_wane",
    ],
);
/// Diffusion along fibres that all run alike is what the other models know.
const TANGLED: ParameterNeeds = ParameterNeeds::Transport(&[TransportName::Kernel, TransportName::Path]);
const ROT: ParameterNeeds = Any(&["rot.reach_mm", "rot.heart_mm", "rot.pocket_count"]);
const COMPRESSION: ParameterNeeds = Amount("compression.severity");
const STAIN: ParameterNeeds = Amount("stain.severity");
const RESIN: ParameterNeeds =
    Any(&["inclusions.resin_pocket_count", "inclusions.resin_streak_count", "anatomy.canals_per_mm2"]);
const PORES: ParameterNeeds = Amount("anatomy.pores_per_mm2");
const RAYS: ParameterNeeds = Amount("anatomy.ray_share");
const POCKETS: ParameterNeeds = Any(&["inclusions.resin_pocket_count", "inclusions.bark_pocket_count"]);
const INCLUSIONS: ParameterNeeds =
    Any(&["inclusions.resin_pocket_count", "inclusions.resin_streak_count", "inclusions.bark_pocket_count"]);
const CRACKS: ParameterNeeds = Any(&["cracks.check_count", "cracks.shake_count", "cracks.split_count"]);
const SPECKLE: ParameterNeeds = Amount("speckle.strength");
const DEFECTS: ParameterNeeds = Any(&DEFECT_COUNTS);

/// Parameters that are for objects which no sample may have: a recipe may keep them for classes to come, so they are noted and
/// not refused.
const NOTED: &[(&str, &[ParameterNeeds])] = &[
    ("speckle.surface_patterns", &[SPECKLE]),
    ("speckle.volume_patterns", &[SPECKLE]),
    ("board.saw_pitch_mm", &[Amount("board.saw_ripple_um")]),
    ("log.ring_width_correlation", &[Amount("log.ring_width_log_sd")]),
    ("log.juvenile_rings", &[ParameterNeeds::Factor("log.juvenile_latewood_ratio")]),
    ("log.juvenile_latewood_ratio", &[Amount("log.juvenile_rings")]),
    ("log.ring_width_trend_rings", &[ParameterNeeds::Factor("log.ring_width_pith_ratio")]),
    ("knots.width_mm", &[KNOTS]),
    ("knots.width_log_sd", &[KNOTS]),
    ("knots.slope_deg", &[KNOTS]),
    ("knots.slope_sd_deg", &[KNOTS]),
    ("knots.flow_ratio", &[KNOTS]),
    ("knots.death_share", &[DEAD_KNOTS]),
    ("knots.bark_mm", &[DEAD_KNOTS]),
    ("knots.hole_depth_mm", &[Amount("knots.hole_count")]),
    ("knots.loose_gap_mm", &[Amount("knots.loose_count")]),
    ("knots.loose_sunk_mm", &[Amount("knots.loose_count")]),
    ("marks.chip_mm", &[Amount("marks.chip_count")]),
    ("moisture.patch_count", &[Amount("moisture.filled")]),
    ("moisture.patch_mm", &[Amount("moisture.patch_count")]),
    ("moisture.filled", &[Amount("moisture.patch_count")]),
    ("rot.edge", &[Amount("rot.reach_mm")]),
    ("rot.pocket_length_mm", &[Amount("rot.pocket_count")]),
    ("rot.incipient_mm", &[ROT]),
    ("rot.severity", &[ROT]),
    ("rot.transition_mm", &[ROT]),
    ("rot.front_mm", &[ROT]),
    ("rot.elongation", &[ROT, Amount("rot.front_mm")]),
    ("rot.rim_mm", &[ROT]),
    ("media.heartwood_mu_a_ratio", &[Amount("log.heartwood_mm")]),
    ("media.pith_mu_a_ratio", &[Amount("log.pith_mm")]),
    ("media.compression_mu_a_ratio", &[COMPRESSION]),
    ("media.compression_sigma_i_ratio", &[COMPRESSION]),
    ("media.compression_k_ratio", &[COMPRESSION]),
    ("media.compression_n_eff", &[COMPRESSION]),
    ("media.stain_mu_a_ratio", &[STAIN]),
    ("media.resin_mu_a_per_mm", &[RESIN]),
    ("media.resin_sigma_i_per_mm", &[RESIN]),
    ("media.resin_k_per_mm", &[RESIN]),
    ("media.resin_n_eff", &[RESIN]),
    ("compression.width_mm", &[COMPRESSION]),
    ("compression.offset_mm", &[COMPRESSION]),
    ("compression.azimuth_deg", &[COMPRESSION]),
    ("compression.arc_deg", &[COMPRESSION]),
    ("stain.wedge_count", &[STAIN]),
    ("stain.wedge_deg", &[STAIN]),
    ("stain.length_mm", &[STAIN]),
    ("inclusions.length_mm", &[POCKETS]),
    ("inclusions.width_mm", &[INCLUSIONS]),
    ("inclusions.thickness_mm", &[INCLUSIONS]),
    ("inclusions.streak_length_mm", &[Amount("inclusions.resin_streak_count")]),
    ("cracks.length_mm", &[CRACKS]),
    ("cracks.width_mm", &[CRACKS]),
    ("cracks.depth_mm", &[CRACKS]),
    ("holes.diameter_mm", &[Amount("holes.count")]),
    ("holes.depth_mm", &[Amount("holes.count")]),
    ("holes.frass", &[Amount("holes.count")]),
    ("wane.edge", &[Amount("wane.width_mm")]),
    ("wane.angle_deg", &[Amount("wane.width_mm")]),
    ("wane.bark", &[Any(&["wane.width_mm", "stem.outline_wane"])]),
    ("marks.dirt_mm", &[Amount("marks.dirt_count")]),
    ("marks.dirt_coat", &[Amount("marks.dirt_count")]),
    ("marks.roller_pitch_mm", &[Amount("marks.roller_um")]),
    ("marks.roller_width_mm", &[Amount("marks.roller_um")]),
    ("marks.skip_mm", &[Amount("marks.skip_count")]),
    ("marks.skip_um", &[Amount("marks.skip_count")]),
    ("marks.burn_mm", &[Amount("marks.burn_count")]),
    ("marks.burn_coat", &[Amount("marks.burn_count")]),
    ("rot.loss_mm", &[ROT]),
    ("grain.torn_dive_deg", &[Any(&["grain.torn_um", "grain.fuzzy_um"])]),
    ("anatomy.canal_um", &[Amount("anatomy.canals_per_mm2")]),
    ("anatomy.pore_um", &[PORES]),
    ("anatomy.pore_ring", &[PORES]),
    ("anatomy.pore_dust", &[PORES]),
    ("anatomy.ray_height_mm", &[RAYS]),
    ("anatomy.ray_width_um", &[RAYS]),
    ("anatomy.ray_mu_a_ratio", &[RAYS]),
    ("machining.planer_pitch_mm", &[Amount("machining.planer_um")]),
    ("machining.band_pitch_mm", &[Amount("machining.band_um")]),
    ("machining.band_slant_deg", &[Amount("machining.band_um")]),
    ("machining.circular_pitch_mm", &[Amount("machining.circular_um")]),
    ("machining.circular_radius_mm", &[Amount("machining.circular_um")]),
    ("media.knot_mu_a_ratio", &[KNOTS]),
    ("media.dead_knot_mu_a_ratio", &[DEAD_KNOTS]),
    ("media.knot_sigma_i_ratio", &[KNOTS_OR_BARK]),
    ("media.knot_k_ratio", &[KNOTS_OR_BARK]),
    ("media.knot_n_eff", &[KNOTS_OR_BARK]),
    ("media.fibre_dispersion_deg", &[TANGLED]),
    ("media.knot_fibre_dispersion_deg", &[KNOTS, TANGLED]),
    ("material.fibre_dispersion_deg", &[TANGLED]),
    ("media.bark_mu_a_per_mm", &[BARK]),
    ("media.rot_mu_a_ratio", &[ROT]),
    ("media.rot_sigma_i_ratio", &[ROT]),
    ("media.rot_k_ratio", &[ROT]),
    ("media.rot_n_eff", &[ROT]),
    ("pack.knurl_pitch_mm", &[Amount("pack.knurl_um")]),
    ("pocket.bump_size_mm", &[Any(&["pocket.bumps_um", "film.thinning_spread"])]),
    ("tablet.shape", &[Outline]),
    ("tablet.on_edge", &[RoomToStand]),
    ("defects.severity", &[DEFECTS]),
];

/// Reflectance above which facets are taken for metal ([`procedural::Gloss::is_metal`]) [1].
const MIN_METAL_REFLECTANCE: f64 = 0.5;

/// Notes parameters that have no effect, at the top level and in each class.
pub(crate) fn refuse(
    yaml: &mut YamlReader,
    subject: Option<Subject>,
    settings: &Settings,
    base: &BTreeMap<String, Distribution>,
    classes: &[Class],
) {
    idle(CONDITIONAL, (subject, settings, base, classes), &mut |key, problem, remedy| {
        yaml.joint_fault(&[key], problem, remedy);
    });
}

/// What parameters have no effect although a recipe may have them, each with what to do.
pub(crate) fn notes(
    subject: Option<Subject>,
    settings: &Settings,
    base: &BTreeMap<String, Distribution>,
    classes: &[Class],
) -> Vec<String> {
    let mut notes = Vec::new();
    idle(NOTED, (subject, settings, base, classes), &mut |key, problem, remedy| {
        notes.push(format!("{key} {problem}; {remedy}"));
    });
    if subject == Some(Subject::Wood) {
        narrowed(base, classes, &mut notes);
    }
    notes
}

/// Notes tubes of wood that can be drawn wider than so many have room for.
fn narrowed(base: &BTreeMap<String, Distribution>, classes: &[Class], notes: &mut Vec<String>) {
    for (count, width, tubes) in [
        ("anatomy.canals_per_mm2", "anatomy.canal_um", "canals"),
        ("anatomy.pores_per_mm2", "anatomy.pore_um", "vessels"),
    ] {
        for class in classes {
            let own = [count, width].iter().any(|path| class.overrides.contains_key(*path));
            let prefix = if own { format!("classes.{}.", class.name) } else { String::new() };
            let scene = DrawBounds { prefix: &prefix, base, overrides: &class.overrides };
            let (most, widest) = (scene.most(count), scene.most(width));
            let room = widest_tube_um(most);
            if most > 0.0 && widest > room {
                let note = format!(
                    "{prefix}{width} can be {widest:.0}, and where {most} {tubes} stand on a mm2 they are at most {room:.0} um wide: \
                     wider ones are narrowed; give less, or fewer {tubes}"
                );
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
        }
    }
}

/// The keys of a table that have no effect, at the top level and in each class, with the reason and the remedy.
fn idle(
    table: &[(&str, &[ParameterNeeds])],
    (subject, settings, base, classes): (Option<Subject>, &Settings, &BTreeMap<String, Distribution>, &[Class]),
    tell: &mut dyn FnMut(String, String, String),
) {
    let none = BTreeMap::new();
    let top = DrawBounds { prefix: "", base, overrides: &none };
    let prefixes: Vec<_> = classes.iter().map(|class| format!("classes.{}.", class.name)).collect();
    let scenes: Vec<_> = classes
        .iter()
        .zip(&prefixes)
        .map(|(class, prefix)| DrawBounds { prefix, base, overrides: &class.overrides })
        .collect();
    for (path, needs) in table {
        let Some(parameter) = keys::parameters(subject).find(|parameter| parameter.path() == *path) else { continue };
        let usual = Distribution::Fixed(parameter.default);
        let refusal = |scene: &DrawBounds| needs.iter().find_map(|need| need.refusal(subject, settings, scene));
        if base.get(*path) != Some(&usual)
            && scenes.iter().all(|scene| refusal(scene).is_some())
            && let Some((problem, remedy)) = refusal(&top).or_else(|| scenes.iter().find_map(refusal))
        {
            tell((*path).to_owned(), problem, remedy);
        }
        for (class, scene) in classes.iter().zip(&scenes) {
            let own = class.overrides.get(*path).filter(|own| **own != usual);
            if let (Some(_), Some((problem, remedy))) = (own, refusal(scene)) {
                tell(format!("{}{path}", scene.prefix), problem, remedy);
            }
        }
    }
}

impl ParameterNeeds {
    /// Why a parameter with this need has no effect, and what to do; `None` where the need is met.
    fn refusal(self, subject: Option<Subject>, settings: &Settings, scene: &DrawBounds) -> Option<(String, String)> {
        match self {
            Self::Movement(wanted) => unmet(("motion", "kind"), settings.motion.kind, &[wanted], Wording::OnPair),
            Self::Profile(wanted) => unmet(("laser", "profile"), settings.laser.profile, wanted, Wording::OnPair),
            Self::Fan(wanted) => unmet(("laser", "fan"), settings.laser.fan, &[wanted], Wording::OnPair),
            Self::Scheimpflug(wanted) => {
                unmet(("camera", "scheimpflug"), settings.camera.scheimpflug, &[wanted], Wording::While)
            }
            Self::Filter(wanted) => unmet(("camera", "filter"), settings.camera.filter, &[wanted], Wording::While),
            Self::Transport(wanted) => unmet(("transport", "model"), settings.transport.model, wanted, Wording::While),
            Self::Log(wanted) => unmet(("log", "source"), settings.log.source, wanted, Wording::While),
            Self::Facets => no_facets(subject?, scene).map(no_matter),
            Self::Fibres => no_fibres(subject?, scene).map(no_matter),
            Self::RoomToStand => no_room_to_stand(scene),
            _ if !self.is_unmet(subject, settings.log.source, scene) => None,
            Self::Amount(path) => {
                Some((format!("has no effect while `{path}` is 0"), format!("give `{path}` too, or remove it")))
            }
            Self::Factor(path) => {
                Some((format!("has no effect while `{path}` is 1"), format!("give `{path}` too, or remove it")))
            }
            Self::Any(paths) | Self::AnyKnots(_, paths) => {
                // What boards from elsewhere alone can have is no remedy.
                let open = paths.iter().copied().filter(|path| has_room_in(path, settings.log.source));
                let open: Vec<_> = if subject == Some(Subject::Wood) { open.collect() } else { paths.to_vec() };
                let Some(first) = open.first() else {
                    let problem = format!("has no effect while `log.source` is `{}`", settings.log.source.name());
                    return Some((problem, "remove it".to_owned()));
                };
                let named = if open.len() > 3 { &open[..1] } else { &open };
                let (zero, other) = match open.len() {
                    1 => (" is 0", ""),
                    count if named.len() < count => (" and all others of their kind are 0", ", or another of them"),
                    _ => (" are 0", ", or another of them"),
                };
                let problem = format!("has no effect while `{}`{zero}", named.join("` and `"));
                Some((problem, format!("give `{first}` too{other}, or remove it")))
            }
            Self::Outline => {
                let what = "has no effect: an ellipse and a stadium that are as long as wide are the same circle";
                Some((what.to_owned(), "give another `tablet.width_mm`, or remove it".to_owned()))
            }
        }
    }

    /// Whether one sample may meet it and another not; else all samples of a dataset do, or none does.
    pub(super) fn is_of_samples(self, subject: Subject, source: LogSource) -> bool {
        match self {
            Self::Facets | Self::Fibres => matches!(subject, Subject::Sawtooth | Subject::Mesh),
            Self::AnyKnots(sources, _) => !sources.contains(&source),
            _ => !self.deciders().is_empty(),
        }
    }

    /// Paths of the parameters whose draws say whether it is met; none where settings do.
    pub(super) fn deciders(self) -> Vec<&'static str> {
        match self {
            Self::Movement(_)
            | Self::Profile(_)
            | Self::Fan(_)
            | Self::Scheimpflug(_)
            | Self::Filter(_)
            | Self::Transport(_)
            | Self::Log(_) => Vec::new(),
            Self::Facets => vec!["material.gloss", "material.reflectance"],
            Self::Fibres => vec!["material.k_per_mm"],
            Self::Amount(path) | Self::Factor(path) => vec![path],
            Self::Any(paths) | Self::AnyKnots(_, paths) => paths.to_vec(),
            Self::RoomToStand => [&ROOM[..], &STANDING[..]].concat(),
            Self::Outline => vec!["tablet.length_mm", "tablet.width_mm", "tablet.shape"],
        }
    }

    /// Whether draws within `scene` never meet it; what settings decide counts as met.
    pub(super) fn is_unmet(self, subject: Option<Subject>, source: LogSource, scene: &DrawBounds) -> bool {
        match self {
            Self::Movement(_)
            | Self::Profile(_)
            | Self::Fan(_)
            | Self::Scheimpflug(_)
            | Self::Filter(_)
            | Self::Transport(_)
            | Self::Log(_) => false,
            Self::Facets => subject.is_some_and(|subject| no_facets(subject, scene).is_some()),
            Self::Fibres => subject.is_some_and(|subject| no_fibres(subject, scene).is_some()),
            Self::Amount(path) => is_zero(scene, path),
            Self::Factor(path) => scene.ends(path) == [1.0, 1.0],
            Self::AnyKnots(sources, _) if sources.contains(&source) => false,
            Self::Any(paths) | Self::AnyKnots(_, paths) => paths.iter().all(|path| is_zero(scene, path)),
            Self::RoomToStand => no_room_to_stand(scene).is_some(),
            Self::Outline => {
                let [length, width] = ["tablet.length_mm", "tablet.width_mm"].map(|path| scene.ends(path));
                length == width && length[0] == length[1] && scene.most("tablet.shape") < 2.0
            }
        }
    }
}

/// What the parameter `path` needs.
pub(super) fn needs(path: &str) -> impl Iterator<Item = ParameterNeeds> {
    let of = CONDITIONAL.iter().chain(NOTED).filter(move |(conditional, _)| *conditional == path);
    of.flat_map(|(_, needs)| *needs).copied()
}

/// Whether boards of a source can have the parameter `path`.
pub(super) fn has_room_in(path: &str, source: LogSource) -> bool {
    let needs = CONDITIONAL.iter().filter(|(conditional, _)| *conditional == path).flat_map(|(_, needs)| *needs);
    needs.into_iter().all(|need| !matches!(need, ParameterNeeds::Log(wanted) if !wanted.contains(&source)))
}

/// The refusal of a parameter that needs one of the words `wanted` of a setting, where another is chosen.
fn unmet<T: Words>(
    (section, key): (&'static str, &'static str),
    chosen: T,
    wanted: &[T],
    wording: Wording,
) -> Option<(String, String)> {
    let words = wanted.iter().map(|word| word.name()).collect();
    (!wanted.contains(&chosen)).then(|| Idle { section, key, chosen: chosen.name(), words, wording }.refusal())
}

/// What matter lacks, and what to do, as a refusal.
fn no_matter((lack, remedy): (&str, &str)) -> (String, String) {
    (format!("has no effect: {lack}"), remedy.to_owned())
}

fn is_zero(scene: &DrawBounds, path: &str) -> bool {
    scene.least(path) == 0.0 && scene.most(path) == 0.0
}

/// What a tablet that stands has room in, and what stands.
const ROOM: [&str; 3] = ["tablet.thickness_mm", "pocket.headroom_mm", "pocket.dome_mm"];
const STANDING: [&str; 2] = ["tablet.length_mm", "tablet.width_mm"];

/// Why no tablet has room to stand on its edge, and what to do: at its highest the film leaves the tablet's thickness, the room
/// above it and the roof's dome, and a tablet that stands is as high as it is wide.
fn no_room_to_stand(scene: &DrawBounds) -> Option<(String, String)> {
    let room: f64 = ROOM.map(|path| scene.most(path)).iter().sum();
    let [length, width] = STANDING.map(|path| scene.least(path));
    let stands = length.min(width);
    (stands > room).then(|| {
        let what =
            format!("has no effect: a tablet that stands is {stands} mm high, and a pocket has room for {room:.1} mm");
        (what, "give more `pocket.headroom_mm`, or remove it".to_owned())
    })
}

/// Why matter has no facets of metal, and what to do.
fn no_facets(subject: Subject, scene: &DrawBounds) -> Option<(&'static str, &'static str)> {
    match subject {
        Subject::Wood => Some(("boards have no metal", "remove it")),
        Subject::Blister => Some(("the foil of a pack lies below its film", "remove it")),
        Subject::Sawtooth | Subject::Mesh => {
            let dull =
                scene.most("material.gloss") == 0.0 || scene.most("material.reflectance") <= MIN_METAL_REFLECTANCE;
            dull.then_some((
                "the material has no facets of metal",
                "give `material.gloss` above 0 and `material.reflectance` above 0.5, or remove it",
            ))
        }
    }
}

/// Why matter has no fibres, and what to do.
fn no_fibres(subject: Subject, scene: &DrawBounds) -> Option<(&'static str, &'static str)> {
    match subject {
        Subject::Wood => None,
        Subject::Blister => Some(("packs have no fibres", "remove it")),
        Subject::Sawtooth | Subject::Mesh => (scene.most("material.k_per_mm") == 0.0)
            .then_some(("the material has no fibres", "give `material.k_per_mm` above 0, or remove it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_of_parameters_that_are_declared() {
        let declared = |path: &str| keys::parameters(None).any(|parameter| parameter.path() == path);
        for (path, needs) in CONDITIONAL.iter().chain(NOTED) {
            assert!(declared(path), "{path}");
            for need in *needs {
                assert!(
                    !matches!(need, Amount(other) | ParameterNeeds::Factor(other) if !declared(other)),
                    "{path} needs {need:?}"
                );
                assert!(
                    !matches!(need, Any(amounts) | ParameterNeeds::AnyKnots(_, amounts) if !amounts.iter().all(|amount| declared(amount))),
                    "{path}"
                );
            }
        }
        // Every count of defects is asked for.
        let counts = keys::parameters(Some(Subject::Blister)).filter(|p| p.group == "defects" && p.integer).count();
        assert!(matches!(DEFECTS, Any(paths) if paths.len() == counts));
    }
}
