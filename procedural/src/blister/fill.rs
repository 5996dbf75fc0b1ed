//! From numbers to a filled pack.

use base::{Class, Gloss, Instance, Medium, Stream};
use glam::Vec2;

use super::card_placement::CardPlacement;
use super::contaminants::{self, Powder};
use super::film_mark::{FilmMark, MarkKind};
use super::formed_pocket::FormedPocket;
use super::parameters::{Blister, Foil};
use super::plan::{self, PlannedDefect, graded, plan};
use super::tablet::{self, TabletForm};
use super::tablet_face::TabletFace;
use super::tablet_placement::{BESIDE_MM, SHALLOW, deepest};
use super::web::{FLANGE_MM, FormedWeb, highest_bump_mm};
use super::{Pack, flange};

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
    for cell in 0..pockets {
        pack.pocket(cell, &plan);
    }
    let probes = form.probes();
    for cell in 0..pockets {
        pack.fill(stream, blister, cell, &form, &probes, &plan);
    }
    pack.flange(stream, blister, &form);
    pack.strew(blister, &plan);
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
    let over = pocket.max(blister.card.code_mm as f32).max(flange::tent_mm(&form, &lay, slack, flat));
    let height = blister.foil.thickness_mm as f32 + flat + over + flange::RAISED_MM + lay.highest();
    (2.0 * formed.reach() + FLANGE_MM, height)
}

/// The foil's bright side.
fn metal(foil: &Foil) -> Medium {
    let (along, across) = (foil.roughness_along as f32, foil.roughness_across as f32);
    let roughness = if foil.rolled_along_line >= 0.5 { [along, across] } else { [across, along] };
    Medium::opaque(Gloss { share: 1.0, reflectance: foil.reflectance as f32, roughness, matte: 0.0 })
}

impl Pack {
    /// Adds the instance of a pocket, and forms it as deep as planned.
    fn pocket(&mut self, cell: usize, plan: &[PlannedDefect]) {
        let of_whole = plan.iter().find(|p| p.cell == cell && plan::whole(p.class));
        let (class, severity) = of_whole.map_or((Class::Pocket, f32::NAN), |p| (p.class, p.severity));
        if class == Class::Shallow {
            self.web.deepen(cell, graded(severity, SHALLOW[0], SHALLOW[1]));
        }
        let size = 2.0 * self.web.formed.outline.half().x;
        self.enter(class, 0, self.web.cells[cell].middle, size, severity);
    }

    /// Adds an instance and returns its number.
    pub(super) fn enter(&mut self, class: Class, within: u16, p: Vec2, size: f32, severity: f32) -> u16 {
        let id = self.instances.len() as u16 + 1;
        let at = self.lay.conveyor(p);
        self.instances.push(Instance {
            id,
            class,
            state: class,
            within,
            x_mm: f64::from(at.x),
            y_mm: f64::from(at.y),
            diameter_mm: f64::from(size),
            dive_deg: f64::NAN,
            death_radius_mm: f64::NAN,
            severity: f64::from(severity),
            depth_mm: f64::NAN,
            knot: None,
        });
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
        for class in [Class::Wrinkle, Class::Delamination, Class::TabletOnFlange] {
            for i in 0..plan::asked(&blister.defects, class) {
                let stream = stream.child("defects").child(class.name()).index(i as u64);
                let severity = plan::severity(&blister.defects, stream);
                let number = self.instances.len() as u16 + 1;
                let mark = if class == Class::TabletOnFlange {
                    let medium = tablet::medium(&blister.tablet);
                    let Some((solid, mark)) = flange::tablet_on_flange(self, form, medium, stream, number) else {
                        break;
                    };
                    for cell in self.web.cells_in(mark.middle - mark.reach(), mark.middle + mark.reach()) {
                        self.contents[cell].push(self.solids.len());
                    }
                    self.solids.push(solid);
                    mark
                } else {
                    flange::on_flange(self, class, severity, stream, number)
                };
                self.enter(class, 0, mark.middle, 2.0 * mark.outline.half().x, severity);
                self.draw(mark);
            }
        }
    }

    /// Powder, then particles and fibres.
    fn strew(&mut self, blister: &Blister, plan: &[PlannedDefect]) {
        for planned in plan {
            let (within, number) = (planned.cell as u16 + 1, self.instances.len() as u16 + 1);
            let middle = self.web.cells[planned.cell].middle;
            match planned.class {
                Class::Powder => {
                    let powder = Powder::new(self, planned, tablet::medium(&blister.tablet), number);
                    let size = 2.0 * self.web.formed.outline.half().x;
                    self.enter(planned.class, within, middle, size, planned.severity);
                    self.powders[planned.cell] = Some(powder);
                }
                Class::Particle | Class::Fibre => {
                    let Some((solid, size)) = contaminants::foreign(self, planned, number) else { continue };
                    let ends = if planned.class == Class::Fibre { [1.0, 10.0] } else { [0.2, 1.5] };
                    let severity = ((size - ends[0]) / (ends[1] - ends[0])).clamp(0.0, 1.0);
                    let at = 0.5 * (solid.bounds[0] + solid.bounds[1]);
                    self.enter(planned.class, within, self.lay.card(at.x, at.y), size, severity);
                    self.add(planned.cell, solid);
                }
                _ => {}
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
