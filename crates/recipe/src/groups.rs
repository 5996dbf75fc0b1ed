//! Groups: which samples have an instrument, a log or a batch in common, and which split each group is in.
//!
//! **Lots.** Samples in a row are boards of one log (`log.boards_per_log`, see [`super::log_group`]) or of one batch
//! (`samples_per_batch`). Boards of a log have one class; the samples of a batch have classes as ever.
//!
//! **Rigs.** With `rigs: N` each lot is scanned by one of N instruments. Lot or sample r of a class is scanned by the
//! instrument (r + shift) mod N, with a shift drawn for every N of them: of each such block each instrument has one,
//! and no instrument meets always the same split. Without `rigs` each sample has an instrument of its own.
//!
//! **Splits** ([`super::balance`]) part what `splits.by` does not name. An instrument has whole lots, so the largest
//! group that is named is what goes to a split as one: instruments, else lots, else samples. Instruments are dealt out
//! by their number: each split that has a share gets one, and further ones go where most is missing. Lots of one class
//! are split in the order of that class, batches in their own.

use base::Stream;
use optical_bench::settings::{SplitBy, Splits};
use optical_bench::split::{SampleGroups, Split};
use yaml::{Mapping, NumberRange, YamlReader};

use super::Subject;
use super::balance::{self, ClassRotation};
use super::keys::settings::Settings;
use super::log_group::{self, BOARDS_PER_LOG};

/// The key of a recipe that says how many instruments there are.
pub(super) const RIGS: &str = "rigs";
/// What it is about.
pub(super) const RIGS_DOC: &str = "\
Instruments that scan the samples, evenly; each is drawn once. Without it every sample has one of its own.";
/// Most of them.
pub(super) const MAX_RIGS: u32 = 1000;
/// The key of a recipe that says how many samples are of one batch.
pub(super) const BATCH: &str = "samples_per_batch";
/// What it is about.
pub(super) const BATCH_DOC: &str = "\
Samples in a row that are of one batch, and have matter and tools in common; boards have `log.boards_per_log` in its \
place. Without it every sample is a batch of its own.";
/// Most of them.
pub(super) const MAX_BATCH: u32 = 100_000;

/// How many samples have something in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GroupSizes {
    /// Instruments; `None` where each sample has its own.
    pub rigs: Option<u64>,
    /// Samples of a log or a batch.
    pub lot: u64,
}

/// Reads how many samples have something in common, of objects that are a `subject`.
pub(super) fn read(
    yaml: &mut YamlReader,
    top: &mut Mapping,
    subject: Option<Subject>,
    settings: &Settings,
) -> GroupSizes {
    let mut count = |name: &str, max: u32| {
        let node = top.take(yaml, name)?;
        let range = NumberRange { min: 1.0, max: max.into(), whole: true, unit: "" };
        yaml.number_in(node, name, range).map(|count| count as u64)
    };
    let (rigs, batch) = (count(RIGS, MAX_RIGS), count(BATCH, MAX_BATCH));
    if subject == Some(Subject::Wood) && batch.is_some() {
        let remedy = format!("give `{BOARDS_PER_LOG}`, or remove it");
        yaml.joint_fault(&[BATCH], "has no effect on boards, which are sawn from logs", remedy);
    }
    let is_wood = subject == Some(Subject::Wood);
    let lot = if is_wood { log_group::boards_per_log(settings) } else { batch.unwrap_or(1) };
    GroupSizes { rigs, lot }
}

/// Notes what cannot be parted as it is asked for.
pub(super) fn check(yaml: &mut YamlReader, settings: &Settings, rigs: Option<u64>) {
    if !settings.splits.by.contains(&SplitBy::Rig) {
        return;
    }
    let keys = ["splits.by", RIGS];
    let splits = shares(settings.splits()).iter().filter(|share| **share > 0.0).count() as u64;
    match rigs {
        None => {
            let problem = "names `rig`, and each sample has an instrument of its own";
            yaml.joint_fault(&keys, problem, format!("give `{RIGS}` too, or remove it"));
        }
        Some(rigs) if rigs < splits => {
            let problem = format!("names `rig`, and {rigs} of them cannot be parted into {splits} splits");
            yaml.joint_fault(&keys, problem, format!("give at least `{RIGS}: {splits}`, or remove it"));
        }
        Some(_) => {}
    }
}

/// What goes to a split as one, where that is more than a sample.
pub(super) fn unparted(subject: Subject, settings: &Settings, sizes: GroupSizes) -> Option<&'static str> {
    let (by, is_wood) = (&settings.splits.by, subject == Subject::Wood);
    let (lot, lots) = if is_wood { (SplitBy::Log, "logs") } else { (SplitBy::Batch, "batches") };
    match sizes.rigs {
        Some(_) if by.contains(&SplitBy::Rig) => Some("rigs"),
        _ => (sizes.lot > 1 && by.contains(&lot)).then_some(lots),
    }
}

/// What goes to a split as one.
#[derive(Debug, Clone, PartialEq)]
enum SplitUnit {
    /// All that an instrument has scanned; the split of each.
    Rig(Vec<Split>),
    /// A log or a batch.
    Lot,
    /// A sample.
    Sample,
}

/// The groups, classes and splits of a recipe's samples for one seed.
pub(super) struct Groups {
    rotation: ClassRotation,
    classes: usize,
    sizes: GroupSizes,
    is_wood: bool,
    unit: SplitUnit,
    splits: Splits,
    root: Stream,
}

/// What [`Groups`] are made from.
pub(super) struct GroupsOf<'a> {
    pub shares: Vec<f64>,
    pub sizes: GroupSizes,
    pub subject: Subject,
    pub settings: &'a Settings,
}

impl Groups {
    /// The groups under the root of a recipe's streams.
    pub fn new(of: GroupsOf, root: Stream) -> Self {
        let GroupsOf { shares, sizes, subject, settings } = of;
        let (splits, is_wood) = (settings.splits(), subject == Subject::Wood);
        let unit = match (unparted(subject, settings, sizes), sizes.rigs) {
            (Some("rigs"), Some(rigs)) => SplitUnit::Rig(dealt(splits, rigs, root.child("split").child("rig"))),
            (Some(_), _) => SplitUnit::Lot,
            (None, _) => SplitUnit::Sample,
        };
        let (classes, rotation) = (shares.len(), ClassRotation::new(shares.into_iter(), root.child("class")));
        Self { rotation, classes, sizes, is_wood, unit, splits, root }
    }

    /// Whether all samples of a lot have one class.
    fn is_of_one_class(&self) -> bool {
        self.is_wood || self.sizes.lot == 1
    }

    /// Number of the class of sample `index`.
    pub fn class(&self, index: u64) -> usize {
        self.rotation.class(if self.is_wood { self.lot(index) } else { index })
    }

    /// Number of its log or batch.
    pub fn lot(&self, index: u64) -> u64 {
        index / self.sizes.lot
    }

    /// Its number among the samples of its class; of boards, that of its log among the logs of the class.
    pub fn rank(&self, index: u64) -> u64 {
        self.rotation.rank(self.class(index), if self.is_wood { self.lot(index) } else { index })
    }

    /// Its number among the samples of its class.
    pub fn sample_rank(&self, index: u64) -> u64 {
        if self.is_wood { self.rank(index) * self.sizes.lot + index % self.sizes.lot } else { self.rank(index) }
    }

    /// What sample `index` has in common with others.
    pub fn of(&self, index: u64) -> SampleGroups {
        let lot = Some(self.lot(index));
        let (log, batch) = if self.is_wood { (lot, None) } else { (None, lot) };
        SampleGroups { rig: self.rig(index), log, batch }
    }

    fn rig(&self, index: u64) -> u64 {
        let Some(rigs) = self.sizes.rigs else { return index };
        if self.is_of_one_class() {
            self.rig_of(self.class(index), self.rank(index), rigs)
        } else {
            self.rig_of(self.classes, self.lot(index), rigs)
        }
    }

    /// The instrument of the `rank`-th lot of a sequence.
    fn rig_of(&self, sequence: usize, rank: u64, rigs: u64) -> u64 {
        let shift = self.root.child("rigs").index(sequence as u64).index(rank / rigs).key() % rigs;
        (rank % rigs + shift) % rigs
    }

    /// The split of sample `index`.
    pub fn split(&self, index: u64) -> Split {
        match &self.unit {
            SplitUnit::Rig(dealt) => dealt[self.rig(index) as usize],
            SplitUnit::Lot if self.is_of_one_class() => self.balanced(self.class(index), self.rank(index)).0,
            SplitUnit::Lot => self.of_batch(self.lot(index)),
            SplitUnit::Sample => self.balanced(self.class(index), self.sample_rank(index)).0,
        }
    }

    fn balanced(&self, class: usize, rank: u64) -> (Split, [u64; 3]) {
        balance::split(self.splits, self.root.child("split"), class, rank)
    }

    fn of_batch(&self, batch: u64) -> Split {
        balance::split(self.splits, self.root.child("split").child("batch"), 0, batch).0
    }

    /// Samples of each class among the first `samples`, by split. Takes no longer for many, but of batches.
    pub fn counts(&self, samples: u64) -> Vec<[u64; 3]> {
        if !self.is_of_one_class() && self.unit != SplitUnit::Sample {
            return self.counts_of_batches(samples);
        }
        let (units, rest) = if self.is_wood { (self.lot(samples), samples % self.sizes.lot) } else { (samples, 0) };
        let size = if self.is_wood { self.sizes.lot } else { 1 };
        let of_class = |class: usize| {
            let rank = self.rotation.rank(class, units);
            match &self.unit {
                SplitUnit::Rig(dealt) => self.dealt_counts(dealt, class, rank).map(|count| count * size),
                SplitUnit::Lot => self.balanced(class, rank).1.map(|count| count * size),
                SplitUnit::Sample => self.balanced(class, rank * size).1,
            }
        };
        let mut counts: Vec<[u64; 3]> = (0..self.classes).map(of_class).collect();
        for index in samples - rest..samples {
            counts[self.class(index)][self.split(index) as usize] += 1;
        }
        counts
    }

    /// How many of the first `rank` lots of a class each split has, where instruments are dealt out.
    fn dealt_counts(&self, dealt: &[Split], class: usize, rank: u64) -> [u64; 3] {
        let (rigs, mut counts) = (dealt.len() as u64, [0; 3]);
        dealt.iter().for_each(|split| counts[*split as usize] += rank / rigs);
        for left in rank - rank % rigs..rank {
            counts[dealt[self.rig_of(class, left, rigs) as usize] as usize] += 1;
        }
        counts
    }

    fn counts_of_batches(&self, samples: u64) -> Vec<[u64; 3]> {
        let mut counts = vec![[0; 3]; self.classes];
        for first in (0..samples).step_by(self.sizes.lot as usize) {
            let (split, end) = (self.split(first) as usize, samples.min(first + self.sizes.lot));
            for (class, counts) in counts.iter_mut().enumerate() {
                counts[split] += self.rotation.rank(class, end) - self.rotation.rank(class, first);
            }
        }
        counts
    }
}

/// The shares in the order of [`Split`].
fn shares(Splits { train, validation, test }: Splits) -> [f64; 3] {
    [train, validation, test]
}

/// The split of each of `rigs` instruments: as many as the shares say, and at least one for each that has a share.
fn dealt(splits: Splits, rigs: u64, stream: Stream) -> Vec<Split> {
    let shares = shares(splits);
    let mut counts = shares.map(|share| f64::from(u8::from(share > 0.0)));
    let missing = |counts: &[f64; 3], at: usize| shares[at] * rigs as f64 - counts[at];
    let dealt = counts.iter().sum::<f64>() as u64;
    for _ in dealt..rigs {
        let most = (0..3).max_by(|a, b| missing(&counts, *a).total_cmp(&missing(&counts, *b)));
        counts[most.unwrap_or(0)] += 1.0;
    }
    let mut order: Vec<u64> = (0..rigs).collect();
    order.sort_by_key(|rig| stream.index(*rig).key());
    let mut all = vec![Split::Train; rigs as usize];
    let of_splits = [Split::Train, Split::Validation, Split::Test].into_iter().zip(counts);
    let dealt_out = of_splits.flat_map(|(split, count)| std::iter::repeat_n(split, count as usize));
    order.into_iter().zip(dealt_out).for_each(|(rig, split)| all[rig as usize] = split);
    all
}

#[cfg(test)]
mod tests;
