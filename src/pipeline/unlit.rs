//! What of a sample follows from its scene without any light: bench, effective physics, the body's own instances.

use procedural::Instance;

use super::{Scan, body, set_up};
use crate::optics::speckle::Tiles;
use crate::recipe::Scene;
use crate::record::{Labels, Maps, Record};

/// What of a sample follows without light: a record whose maps hold nothing, and every instance of its body.
pub fn unlit(scene: &Scene, tiles: &Tiles) -> (Record, Vec<Instance>) {
    // What stays with single pixels is drawn for each of them, and nothing here asks for it.
    let mut even = scene.clone();
    let exposure = &mut even.bench.exposure;
    (exposure.prnu, exposure.dsnu_dn, exposure.column_pattern_dn, exposure.defect_share) = (0.0, 0.0, 0.0, 0.0);
    let (sensor, specimen) = set_up(&even, body(scene), tiles);
    let scan = Scan { maps: Maps::default(), labels: Labels::default(), truth: None, stack: Vec::new() };
    let instances = specimen.body().instances().to_vec();
    (scan.record(scene, &sensor, &specimen), instances)
}
