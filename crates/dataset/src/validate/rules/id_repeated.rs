//! No two samples of a dataset have one id.

use output_schema::file::manifest_path;

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport};

pub(super) const RULE: Rule = Rule { meaning: "Two samples have one id.", remedy: REMAKE_OR_REPORT };

/// Checks the digest of the id, index and shard of every sample.
pub(in crate::validate) fn check(ids: &mut [(u128, u64, u64)], report: &mut ValidationReport) {
    ids.sort_unstable();
    for pair in ids.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let what = format!("samples {} and {} have the same id", pair[0].1, pair[1].1);
        report.fault(Code::IdRepeated, manifest_path(pair[1].2), what);
    }
}
