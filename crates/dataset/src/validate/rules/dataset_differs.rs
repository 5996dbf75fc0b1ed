//! `dataset.json` says something else than its recipe ([`expected::head`](crate::validate::expected)) or than all
//! manifests, which agree with each other: then it alone was changed.

use std::path::Path;

use output_schema::file::{DATASET, manifest_path};
use output_schema::{DatasetHead, Generator, Manifest};

use super::{Code, RESTORE, Rule, ValidationReport};
use crate::validate::Expect;
use crate::{enclosed, largest};

pub(super) const RULE: Rule = Rule {
    meaning: "`dataset.json` says something else than its recipe gives, or is not written as the program writes it.",
    remedy: RESTORE,
};

/// Generator, recipe hash and seed.
type Origin = (Generator, String, u64);

/// Takes the origin of all manifests into `head` where they agree on another one, and tells it once; `true` where it
/// did.
///
/// One manifest alone is believed if the id of its first sample is not the one that `expect` draws for the head.
pub(in crate::validate) fn check(
    root: &Path,
    head: &mut DatasetHead,
    expect: Option<Expect>,
    report: &mut ValidationReport,
) -> bool {
    let most = largest::manifest_bytes(head);
    let read = |shard: u64| -> Option<Manifest> {
        let text = enclosed::read(root, &manifest_path(shard), most).ok()?;
        serde_json::from_slice(&text).ok()
    };
    let origin = |manifest: Manifest| -> Origin { (manifest.generator, manifest.recipe_hash, manifest.seed) };
    let own: Origin = (head.generator.clone(), head.recipe.hash.clone(), head.seed);
    let mut manifests = (0..head.shards).filter_map(read);
    let Some(first) = manifests.next() else { return false };
    let drawn = expect.zip(first.samples.first()).is_some_and(|(expect, sample)| expect(sample.index).id != sample.id);
    let found = origin(first);
    // Nearly always the first one says that all is well.
    if found == own {
        return false;
    }
    let mut others = 0;
    for other in manifests.map(origin) {
        if other != found {
            return false;
        }
        others += 1;
    }
    if others == 0 && !drawn {
        return false;
    }
    let text = |(generator, hash, seed): &Origin| format!("{} {}, {hash}, {seed}", generator.name, generator.version);
    let (said, all) = (text(&own), text(&found));
    let what = format!("its generator, recipe hash and seed are {said}; all manifests agree on {all}");
    report.fault(Code::DatasetDiffers, DATASET, what);
    (head.generator, head.recipe.hash, head.seed) = found;
    true
}
