//! From numbers to a filled pack.

use base::{Class, Gloss, Instance, Medium, Stream};
use glam::Vec2;

use super::card_placement::CardPlacement;
use super::defects::content::PocketContent;
use super::defects::flange::{FlangeDefect, FlangeDraw, RAISED_MM, tent_mm};
use super::defects::{DefectOf, KINDS, PlannedDefect, plan};
use super::film_mark::{FilmMark, MarkKind};
use super::formed_pocket::FormedPocket;
use super::parameters::Foil;
use super::tablet::TabletForm;
use super::tablet_face::TabletFace;
use super::tablet_placement::{BESIDE_MM, deepest};
use super::web::{FLANGE_MM, FormedWeb, highest_bump_mm};
use super::{Blister, Pack};

/// Forms and fills a pack.
pub fn form(stream: Stream, blister: &Blister) -> Pack {
    let lay = CardPlacement::new(&blister.card);
    let form = TabletForm::new(&blister.tablet);
    let slack = lay.slack(form.outline().half().length() + blister.pocket.clearance_mm as f32);
    let web = FormedWeb::new(stream, blister, &form, lay.half, slack);
    let pockets = web.cells.len();
    let mut pack = Pack {
        lay,
        foil: metal(&blister.foil),
        solids: Vec::new(),
        contents: vec![Vec::new(); pockets],
        marks: vec![Vec::new(); pockets],
        wounds: vec![None; pockets],
        powders: vec![None; pockets],
        face: TabletFace::new(stream, &blister.tablet, &form),
        instances: Vec::new(),
        height: 0.0,
        slack,
        web,
    };
    let plan = plan(stream, &blister.defects, pockets);
    let contents: Vec<PocketContent> = (0..pockets).map(|cell| pack.pocket(cell, blister, &form, &plan)).collect();
    for (cell, content) in contents.iter().enumerate() {
        pack.fill(stream, blister, cell, &form, content, &plan);
    }
    pack.flange(stream, blister, &form);
    for planned in &plan {
        if let DefectOf::Room(strew) = planned.kind.of {
            strew(&mut pack, blister, planned);
        }
    }
    pack.judge();
    pack.height = pack.highest_film();
    pack
}

/// What [`super::extent`] says: room across and along the card, and height [mm].
pub fn extent_mm(blister: &Blister) -> (Vec2, f32) {
    let (lay, form) = (CardPlacement::new(&blister.card), TabletForm::new(&blister.tablet));
    let slack = lay.slack(form.outline().half().length() + blister.pocket.clearance_mm as f32);
    let formed = FormedPocket::new(&blister.pocket, &blister.web, &form, slack);
    let (depth, crown) = formed.depth_mm();
    let (depth, bump) = (depth + crown, highest_bump_mm(&blister.pocket));
    let flat = blister.web.thickness_mm as f32;
    // On the crown's slope the film takes more of the room than its thickness.
    let spare = slack + bump + formed.crown_slope() * (flat + BESIDE_MM);
    let pocket = deepest(&form, depth, spare, blister.defects.double > 0.0) * depth + bump;
    let over = pocket.max(blister.card.code_mm as f32).max(tent_mm(&form, &lay, slack, flat));
    let height = blister.foil.thickness_mm as f32 + flat + over + RAISED_MM + lay.highest();
    (2.0 * formed.reach() + FLANGE_MM, height)
}

/// The foil's bright side.
fn metal(foil: &Foil) -> Medium {
    let (along, across) = (foil.roughness_along as f32, foil.roughness_across as f32);
    let roughness = if foil.rolled_along_line >= 0.5 { [along, across] } else { [across, along] };
    Medium::opaque(Gloss { share: 1.0, reflectance: foil.reflectance as f32, roughness, matte: 0.0 })
}

impl Pack {
    /// Adds the instance of a pocket, forms it as deep as planned, and says what is to lie in it.
    fn pocket(&mut self, cell: usize, blister: &Blister, form: &TabletForm, plan: &[PlannedDefect]) -> PocketContent {
        let of_whole = plan.iter().filter(|p| p.cell == cell).find_map(|p| match p.kind.of {
            DefectOf::Pocket(content) => Some((p.kind.class, p.severity, content(blister, form, p))),
            _ => None,
        });
        let sound = || (Class::Pocket, f32::NAN, PocketContent::sound(blister, form));
        let (class, severity, content) = of_whole.unwrap_or_else(sound);
        if content.depth < 1.0 {
            self.web.deepen(cell, content.depth);
        }
        let size = 2.0 * self.web.formed.outline.half().x;
        self.enter(class, 0, self.web.cells[cell].middle, size, severity);
        content
    }

    /// Number of the instance that comes next.
    pub(super) fn next_id(&self) -> u16 {
        self.instances.len() as u16 + 1
    }

    /// Adds the instance of a defect in a pocket and returns its number.
    pub(super) fn enter_in(&mut self, planned: &PlannedDefect, p: Vec2, size: f32, severity: f32) -> u16 {
        self.enter(planned.kind.class, planned.cell as u16 + 1, p, size, severity)
    }

    /// Adds an instance and returns its number.
    fn enter(&mut self, class: Class, within: u16, p: Vec2, size: f32, severity: f32) -> u16 {
        let id = self.next_id();
        let at = self.lay.conveyor(p).as_dvec2().to_array();
        let own = Instance::new(id, class, at, f64::from(size), f64::from(severity));
        self.instances.push(Instance { within, ..own });
        id
    }

    /// Adds a mark to every cell that it reaches.
    pub(super) fn draw(&mut self, mark: FilmMark) {
        for cell in self.web.cells_in(mark.middle - mark.reach(), mark.middle + mark.reach()) {
            self.marks[cell].push(mark);
        }
    }

    /// Defects of the flange.
    fn flange(&mut self, stream: Stream, blister: &Blister, form: &TabletForm) {
        if self.web.cells.is_empty() {
            return;
        }
        for kind in KINDS {
            let DefectOf::Flange(make) = kind.of else { continue };
            for i in 0..blister.defects.asked(kind) {
                let stream = kind.stream(stream).index(i as u64);
                let (class, severity) = (kind.class, blister.defects.severity(stream));
                let instance = self.next_id();
                let draw = FlangeDraw { pack: self, blister, form, class, instance, severity, stream };
                let Some(FlangeDefect { mark, solid }) = make(&draw) else { break };
                if let Some(solid) = solid {
                    for cell in self.web.cells_in(mark.middle - mark.reach(), mark.middle + mark.reach()) {
                        self.contents[cell].push(self.solids.len());
                    }
                    self.solids.push(solid);
                }
                self.enter(class, 0, mark.middle, 2.0 * mark.outline.half().x, severity);
                self.draw(mark);
            }
        }
    }

    /// What each pocket counts as: its own class where that is a defect, else the worst of what lies in it.
    fn judge(&mut self) {
        for cell in 0..self.web.cells.len() {
            let id = self.instances[cell].id;
            if self.instances[cell].class != Class::Pocket {
                continue;
            }
            let within = self.instances.iter().filter(|i| i.within == id);
            if let Some(worst) = within.max_by(|a, b| a.severity.total_cmp(&b.severity)) {
                let (state, severity) = (worst.class, worst.severity);
                self.instances[cell].state = state;
                self.instances[cell].severity = severity;
            }
        }
    }

    /// Highest place that the film may have [mm].
    fn highest_film(&self) -> f32 {
        let (depth, crown) = self.web.formed.depth_mm();
        let deepest = self.web.cells.iter().map(|cell| cell.factor).fold(0.0, f32::max);
        let pocket = deepest * (depth + crown) + self.web.highest_bump();
        let raised = |kind: MarkKind| {
            let heights = self.marks.iter().flatten().filter(|m| m.kind == kind).map(|m| m.height);
            heights.fold(0.0, f32::max)
        };
        let over = pocket.max(self.web.highest_relief()).max(raised(MarkKind::Tent)) + raised(MarkKind::Raised);
        self.web.foil_mm + self.web.flat_mm + over + self.lay.highest()
    }
}
