//! Batches of a model's input: images are decoded and windows cut on all cores while the model works on earlier
//! batches.
//!
//! Batches come in the order of the tables whatever the number of threads, so that the same check gives the same
//! report.

use std::sync::mpsc::{Receiver, SyncSender};

use base::Stream;
use rayon::prelude::*;

use super::CheckError;
use super::evaluation_plan::{EvaluationPlan, SampleWindows};
use super::sampling::{CentreRegion, draw_pixels};
use super::sidecar::Sidecar;
use super::split_samples::{SampleFacts, SplitSamples};
use super::window::{InputWindow, SampleMaps, fill_input, truth};
use dataset::{RowBatch, Table};

/// Most samples whose maps are in memory at once.
const MAX_SAMPLES_IN_MEMORY: usize = 4;

/// Numbers that one core cuts before it is worth waking another.
const MIN_NUMBERS_PER_CORE: usize = 1 << 20;

/// One window for the model, with its true class.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LabelledWindow {
    /// Number of its sample in the order of the facts.
    pub sample: usize,
    /// Where it was cut.
    pub window: InputWindow,
    /// What it is.
    pub truth: WindowLabel,
}

/// The truth about a window.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum WindowLabel {
    /// Of one class.
    Class(usize),
    /// The class of each cell, [`super::window::NO_CLASS`] for none.
    Cells(Vec<u8>),
}

/// Windows that go to the model together.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// The windows.
    pub units: Vec<LabelledWindow>,
    /// Their inputs, one behind the other.
    pub data: Vec<f32>,
}

/// Reads a split and cuts the windows that the plan asks for.
pub(crate) struct BatchReader<'a> {
    /// The split.
    pub samples: &'a SplitSamples,
    /// What to cut.
    pub sidecar: &'a Sidecar,
    /// What the rows say, table by table.
    pub facts: &'a [SampleFacts],
    /// The windows of each sample.
    pub plan: &'a EvaluationPlan,
    /// Seed of drawn pixels.
    pub seed: u64,
    /// Windows in a batch.
    pub batch: usize,
}

/// The reader's ends of the two channels between it and the model.
pub(crate) struct BatchChannels {
    /// Batches on their way to the model.
    pub batches: SyncSender<Batch>,
    /// Inputs that the model has seen: fresh pages cost more than filling old ones.
    pub spare: Receiver<Vec<f32>>,
}

impl BatchReader<'_> {
    /// Sends every batch; stops early when the receiver is gone. Call it in the thread pool that is to do the work.
    ///
    /// # Errors
    /// Where the dataset is damaged.
    pub fn run(&self, channels: &BatchChannels) -> Result<(), CheckError> {
        let labels = self.plan.work.iter().any(|work| matches!(work, SampleWindows::Pixels(_) | SampleWindows::Tiles));
        let maps: Vec<String> = self.sidecar.channels.iter().map(|channel| channel.name.clone()).collect();
        let mut names = maps.clone();
        names.extend(labels.then(|| "label".to_owned()));
        let step = rayon::current_num_threads().clamp(1, MAX_SAMPLES_IN_MEMORY);
        let (mut batch, mut first) = (Batch::default(), 0);
        for table in &self.samples.tables {
            for rows in self.samples.images(table, &names, step)? {
                let rows = rows?;
                let here: Vec<(usize, RowBatch)> = (0..rows.len()).map(|i| (first + i, rows.row(i))).collect();
                let read = |(sample, row): &(usize, RowBatch)| self.sample(table, row, *sample, &maps, labels);
                let read: Result<Vec<_>, CheckError> = here.par_iter().map(read).collect();
                for (picture, units) in read?.into_iter().flatten() {
                    if !self.cut(&picture, units, &mut batch, channels) {
                        return Ok(());
                    }
                }
                first += rows.len();
            }
        }
        if !batch.units.is_empty() {
            let _ = channels.batches.send(batch);
        }
        Ok(())
    }

    /// The maps of a sample and its windows; `None` where the plan has none.
    fn sample(
        &self,
        table: &Table,
        row: &RowBatch,
        sample: usize,
        maps: &[String],
        labels: bool,
    ) -> Result<Option<(SampleMaps, Vec<LabelledWindow>)>, CheckError> {
        let (Some(work), Some(facts)) = (self.plan.work.get(sample), self.facts.get(sample)) else { return Ok(None) };
        if work.is_empty() {
            return Ok(None);
        }
        let picture = self.samples.picture(table, row, facts, maps, labels)?;
        let sidecar = self.sidecar;
        let of_class = |window, class| LabelledWindow { sample, window, truth: WindowLabel::Class(class) };
        let units = match work {
            SampleWindows::Windows(windows) => windows.iter().map(|&(window, class)| of_class(window, class)).collect(),
            SampleWindows::Pixels(wanted) => {
                let window = sidecar.window.unwrap_or(picture.size);
                let inside = CentreRegion::new(window, picture.size);
                let stream = Stream::root(self.seed).child("check").index(facts.index);
                let found = draw_pixels(&picture.labels, picture.size[1], inside, &sidecar.truth, wanted, stream);
                let units = found.into_iter().enumerate().flat_map(|(class, places)| {
                    let around = move |place: [usize; 2]| InputWindow::around(place.map(|side| side as i64), window);
                    places.into_iter().map(move |place| of_class(around(place), class))
                });
                units.collect()
            }
            SampleWindows::Tiles => {
                let unit = |&window: &InputWindow| {
                    let cells = truth(&picture, window, sidecar.size, &sidecar.truth);
                    LabelledWindow { sample, window, truth: WindowLabel::Cells(cells) }
                };
                self.plan.tiles.iter().map(unit).collect()
            }
        };
        Ok(Some((picture, units)))
    }

    /// Cuts windows out of their maps and sends every full batch; false when the receiver is gone.
    fn cut(
        &self,
        picture: &SampleMaps,
        units: Vec<LabelledWindow>,
        batch: &mut Batch,
        channels: &BatchChannels,
    ) -> bool {
        let each = self.sidecar.channels.len() * self.sidecar.size[0] * self.sidecar.size[1];
        let mut units = units.into_iter().peekable();
        while units.peek().is_some() {
            let begin = batch.units.len();
            if begin == 0 {
                batch.data = channels.spare.try_recv().unwrap_or_else(|_| vec![0.0; self.batch * each]);
            }
            batch.units.extend(units.by_ref().take(self.batch - begin));
            // Every window is written as a whole, so what stood there before does not matter.
            batch.data.resize(batch.units.len() * each, 0.0);
            let windows = batch.data[begin * each..]
                .par_chunks_mut(each)
                .zip(&batch.units[begin..])
                .with_min_len(MIN_NUMBERS_PER_CORE / each + 1);
            windows.for_each(|(out, unit)| {
                fill_input(out, picture, unit.window, &self.sidecar.channels, self.sidecar.size, self.sidecar.layout);
            });
            if batch.units.len() == self.batch && channels.batches.send(std::mem::take(batch)).is_err() {
                return false;
            }
        }
        true
    }
}
