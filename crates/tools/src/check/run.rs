//! Evaluation of a model on a split: one thread reads and cuts windows, this one runs the model and counts.

use std::sync::mpsc::{channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::accuracy::Accuracy;
use super::batches::{Batch, BatchChannels, BatchReader, LabelledWindow, WindowLabel};
use super::evaluation_plan::plan;
use super::external_data::{no_onnx, sha256_with_weights};
use super::metrics::ClassificationMetrics;
use super::misclassified::{Misclassification, draw_panels, keep_worst};
use super::model::{OnnxModel, Scores};
use super::prediction::predict;
use super::report::{AccuracySlice, CheckReport, CheckTiming};
use super::sidecar::{OutputKind, Sidecar, beside};
use super::slices::{SlicePoint, group_by_quantiles};
use super::split_samples::{SampleFacts, SplitSamples};
use super::window::NO_CLASS;
use super::{CheckError, CheckOptions, DEFAULT_BATCH_BYTES, MAX_DEFAULT_BATCH, SampleTests, slice_paths};
use dataset::Fault;
use output_schema::DatasetHead;

/// Most numbers of a batch's input, 4 GiB, and most pixels of an image.
const MAX_NUMBERS: usize = 1 << 30;
/// Batches that may wait for the model.
const MAX_WAITING_BATCHES: usize = 2;

/// Checks the model on the dataset; `tests` says which samples lack what a number describes, `progress` takes windows
/// done and windows in all.
///
/// # Errors
/// Where dataset, sidecar, model or library are not as they should be; each error says where, what and what to do.
pub fn check(
    options: &CheckOptions,
    tests: SampleTests,
    progress: &dyn Fn(u64, u64),
) -> Result<CheckReport, CheckError> {
    let samples = SplitSamples::open(&options.dir, options.split)?;
    let (sidecar, sidecar_sha256) = read_sidecar(options, samples.head())?;
    let numbers = slice_paths(&options.slices, samples.head())?;
    let (mut model, model_sha256) = open_model(options, &sidecar)?;
    let begun = Instant::now();
    let facts = samples.facts(&numbers, tests)?;
    let images = &samples.head().images;
    if images.rows.saturating_mul(images.cols) > MAX_NUMBERS as u64 {
        let what = format!("it claims images of {} x {} pixels", images.cols, images.rows);
        return Err(CheckError::at(&options.dir, what, "`gen validate` says what is damaged"));
    }
    let image = [images.rows as usize, images.cols as usize];
    let plan = plan(&sidecar, &facts, image);
    if plan.units == 0 {
        let what = format!("it has no {} of the model's classes", sidecar.task.units());
        return Err(CheckError::nothing(
            &options.dir,
            what,
            "correct `classes` in the sidecar, or give another --split",
        ));
    }
    let batch = batch_size(options, &model)?;
    let reader =
        BatchReader { samples: &samples, sidecar: &sidecar, facts: &facts, plan: &plan, seed: options.seed, batch };
    let mut scorer = Scorer {
        facts: &facts,
        sidecar: &sidecar,
        options,
        image,
        metrics: ClassificationMetrics::new(sidecar.classes.len()),
        rights: vec![(0, 0); facts.len()],
        left_out: 0,
        worst: Vec::new(),
    };
    let asked = evaluate(&reader, &mut model, &mut scorer, progress)?;
    let timing = CheckTiming { seconds: begun.elapsed().as_secs_f64(), model_seconds: asked.as_secs_f64(), batch };
    let slices = scorer.slices(&numbers, options.slices.is_empty());
    let Scorer { metrics, rights, worst, left_out, .. } = scorer;
    let mut share = Accuracy::default();
    rights.iter().for_each(|&(right, of)| share.add(right, of));
    if share.of == 0 {
        let what = format!("no {} of it lie inside the images and have a class of the model", sidecar.task.units());
        let remedy = "correct `classes` or give a smaller window_px in the sidecar";
        return Err(CheckError::nothing(&options.dir, what, remedy));
    }
    let answers = facts.iter().zip(&rights).map(|(facts, &(right, of))| (facts.index, [right, of])).collect();
    Ok(CheckReport {
        options: options.clone(),
        head: samples.head().clone(),
        sidecar,
        model_sha256,
        sidecar_sha256,
        samples: share.samples,
        left_out: plan.left_out + left_out,
        unfinished: samples.unfinished,
        share,
        answers,
        metrics,
        slices,
        worst,
        timing,
    })
}

/// A model that answers questions of a kind of dataset.
#[derive(Debug)]
pub struct TriedModel {
    /// Description of the model.
    pub sidecar: Sidecar,
    /// SHA-256 of the model with its external weights, hexadecimal.
    pub sha256: String,
    /// SHA-256 of the sidecar, hexadecimal.
    pub sidecar_sha256: String,
}

/// Tries whether the model of `options` can be asked about datasets like the one that `head` describes.
///
/// # Errors
/// Where sidecar, model or library are not as they should be.
pub fn try_model(options: &CheckOptions, head: &DatasetHead) -> Result<TriedModel, CheckError> {
    let (sidecar, sidecar_sha256) = read_sidecar(options, head)?;
    let (model, sha256) = open_model(options, &sidecar)?;
    batch_size(options, &model)?;
    Ok(TriedModel { sidecar, sha256, sidecar_sha256 })
}

fn read_sidecar(options: &CheckOptions, head: &DatasetHead) -> Result<(Sidecar, String), CheckError> {
    let path = options.sidecar.clone().map_or_else(|| beside(&options.model), Ok)?;
    Sidecar::load(&path, head)
}

/// The model, and its SHA-256.
fn open_model(options: &CheckOptions, sidecar: &Sidecar) -> Result<(OnnxModel, String), CheckError> {
    // First, since onnxruntime would wait for a pipe among the weights.
    let sha256 = sha256_with_weights(&options.model)?;
    let model = OnnxModel::open(&options.model, sidecar, options.threads)?;
    Ok((model, sha256.ok_or_else(|| no_onnx(&options.model))?))
}

/// Windows in a batch: those that the model takes, that the options say, or that fit the default size.
fn batch_size(options: &CheckOptions, model: &OnnxModel) -> Result<usize, CheckError> {
    let fitting = (DEFAULT_BATCH_BYTES / (4 * model.input_len()).max(1)).clamp(1, MAX_DEFAULT_BATCH);
    let batch = match (model.fixed_batch(), options.batch) {
        (Some(fixed), Some(asked)) if asked != fixed => {
            return Err(CheckError::Argument(format!(
                "--batch {asked}: the model takes {fixed} at once; leave it out"
            )));
        }
        (Some(fixed), _) => fixed,
        (None, asked) => asked.unwrap_or(fitting).max(1),
    };
    if batch.saturating_mul(model.input_len()) > MAX_NUMBERS {
        let what = format!("a batch of {batch} windows takes more than 4 GiB; give a smaller --batch or size_px");
        return Err(CheckError::Argument(what));
    }
    Ok(batch)
}

/// Runs the model on every window of the reader, which works in a thread of its own, and scores the answers. Returns
/// the time spent within the model.
fn evaluate(
    reader: &BatchReader,
    model: &mut OnnxModel,
    scorer: &mut Scorer,
    progress: &dyn Fn(u64, u64),
) -> Result<Duration, CheckError> {
    let options = scorer.options;
    let mut asked = Duration::ZERO;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build();
    let pool = pool.map_err(|e| CheckError::Argument(format!("threads do not start: {e}; give fewer --threads")))?;
    thread::scope(|scope| {
        let (sender, batches) = sync_channel(MAX_WAITING_BATCHES);
        let (used, spare) = channel();
        let pool = &pool;
        let reading = scope.spawn(move || pool.install(move || reader.run(&BatchChannels { batches: sender, spare })));
        let mut done = 0;
        let asking = || {
            for Batch { units, mut data } in batches {
                let start = Instant::now();
                let scores = model.run(&mut data, units.len())?;
                asked += start.elapsed();
                for (i, unit) in units.into_iter().enumerate() {
                    let input = &data[i * model.input_len()..][..model.input_len()];
                    scorer.take(&unit, &scores, i, input)?;
                }
                done += scores.values.len() as u64 / (scores.classes * scores.cells) as u64;
                progress(done, reader.plan.units);
                // Nobody takes it once everything is read.
                let _ = used.send(data);
            }
            Ok(())
        };
        // A reader that failed says why the batches ended; the model's own failure comes first.
        let answered: Result<(), CheckError> = asking();
        let read =
            reading.join().unwrap_or_else(|_| Err(CheckError::at(&options.dir, "reading stopped".into(), "report it")));
        answered.and(read)
    })?;
    Ok(asked)
}

/// Compares predictions with the truth and keeps the counts.
struct Scorer<'a> {
    facts: &'a [SampleFacts],
    sidecar: &'a Sidecar,
    options: &'a CheckOptions,
    /// Rows and columns of an image [px].
    image: [usize; 2],
    metrics: ClassificationMetrics,
    /// Right guesses and guesses of each sample.
    rights: Vec<(u64, u64)>,
    /// Cells inside an image that are of no class of the model.
    left_out: u64,
    worst: Vec<Misclassification>,
}

impl Scorer<'_> {
    /// Takes what the model says of unit `i` of a batch.
    fn take(&mut self, unit: &LabelledWindow, scores: &Scores, i: usize, input: &[f32]) -> Result<(), CheckError> {
        let &LabelledWindow { sample, window, ref truth } = unit;
        let output = self.sidecar.output;
        let facts = &self.facts[sample];
        let fault = |what: String| {
            let place = format!("{} on sample {}", self.options.model.display(), facts.index);
            let (what, remedy) =
                what.split_once("; ").map_or((what.clone(), ""), |(what, remedy)| (what.into(), remedy));
            CheckError::from(Fault::new(place, what, remedy.to_owned()))
        };
        let guesses = predictions(scores, i, output).map_err(fault)?;
        let (right, of) = &mut self.rights[sample];
        let mut wrong = Misclassification {
            index: facts.index,
            id: facts.id.clone(),
            window,
            truth: 0,
            guess: 0,
            confidence: 0.0,
            picture: None,
        };
        let cells = match truth {
            WindowLabel::Class(class) => {
                let (guess, confidence) = guesses[0];
                self.metrics.add(*class, guess, confidence);
                (*right, *of) = (*right + u64::from(guess == *class), *of + 1);
                if guess == *class {
                    return Ok(());
                }
                (wrong.truth, wrong.guess, wrong.confidence) = (*class, guess, confidence);
                None
            }
            WindowLabel::Cells(cells) => {
                let classes = self.sidecar.classes.len();
                let (mut count, mut weights) = (0_u64, vec![0.0; classes * classes]);
                for (&class, &(guess, confidence)) in cells.iter().zip(&guesses) {
                    if class == NO_CLASS {
                        continue;
                    }
                    let class = usize::from(class);
                    self.metrics.add(class, guess, confidence);
                    (*right, *of, count) = (*right + u64::from(guess == class), *of + 1, count + 1);
                    if guess != class {
                        weights[class * classes + guess] += confidence;
                    }
                }
                self.left_out += window.inside(self.sidecar.size, self.image) - count;
                let heaviest = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b]).then(b.cmp(&a)));
                let Some(pair) = heaviest.filter(|&pair| weights[pair] > 0.0) else { return Ok(()) };
                (wrong.truth, wrong.guess) = (pair / classes, pair % classes);
                wrong.confidence = weights.iter().sum::<f64>() / count as f64;
                Some(cells)
            }
        };
        let picture = |wrong: &Misclassification| {
            let answer: Vec<u8> = guesses.iter().map(|(guess, _)| *guess as u8).collect();
            let maps = cells.map(|cells| [cells.as_slice(), answer.as_slice()]);
            self.options.pictures.then(|| draw_panels(wrong, input, maps, self.sidecar))
        };
        keep_worst(&mut self.worst, self.options.worst, wrong, picture);
        Ok(())
    }

    /// Accuracy by each number; of `chosen` ones those that differ between samples.
    fn slices(&self, numbers: &[String], chosen: bool) -> Vec<AccuracySlice> {
        let points = |number: usize| -> Vec<SlicePoint> {
            let samples = self.facts.iter().zip(&self.rights);
            samples.map(|(facts, &(right, of))| SlicePoint { value: facts.numbers[number], right, of }).collect()
        };
        let slice =
            |(i, path): (usize, &String)| AccuracySlice { path: path.clone(), groups: group_by_quantiles(&points(i)) };
        numbers.iter().enumerate().map(slice).filter(|slice| !chosen || slice.groups.len() > 1).collect()
    }
}

/// Class and confidence of every answer of unit `i`.
fn predictions(scores: &Scores, i: usize, output: OutputKind) -> Result<Vec<(usize, f64)>, String> {
    let one = |numbers: &mut Vec<f32>, cell: usize| {
        scores.answer(i, cell, numbers);
        predict(numbers, output)
    };
    if scores.cells == 1 {
        return Ok(vec![one(&mut Vec::new(), 0)?]);
    }
    (0..scores.cells).into_par_iter().with_min_len(1024).map_init(Vec::new, one).collect()
}
