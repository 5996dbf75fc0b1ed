//! Recipes, and the samples that they make.

use std::collections::BTreeMap;
use std::process;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::ThreadPool;
use sheetlight::api::{self, Change, Fault, LoadError, LoadedRecipe, Record, Simulator, Stop};

use crate::errors::{of_loading, of_program};
use crate::pool::{Outcome, pool, spawn, thread_count, wait};
use crate::sample::Sample;

/// A recipe.
#[pyclass(frozen, module = "sheetlight._sheetlight")]
pub(crate) struct Recipe {
    recipe: api::Recipe,
    /// The seed of the dataset that it was taken from.
    dataset_seed: Option<u64>,
    /// The simulator that was used last: patterns of speckle take a while.
    last: Mutex<Option<Rendering>>,
}

/// A simulator, and what tells whether it may be used after a `fork`.
#[derive(Clone)]
struct Rendering {
    simulator: Arc<Simulator>,
    process: u32,
    /// Samples that threads of this process are rendering: locks that they hold stay locked for ever in a process that
    /// is forked meanwhile.
    busy: Arc<AtomicUsize>,
}

/// A sample, and its numbers as a JSON text; `None` where the work was stopped.
type Rendered = Option<(Record, Result<String, String>)>;

impl Rendering {
    /// Renders sample `index` in `pool`; `made` makes what is sent of it.
    fn spawn<T: Send + 'static>(
        &self,
        pool: &ThreadPool,
        sender: Sender<Outcome<T>>,
        (index, stop): (u64, Arc<Stop>),
        made: impl FnOnce(Rendered) -> T + Send + 'static,
    ) {
        let Self { simulator, busy, .. } = self.clone();
        busy.fetch_add(1, Ordering::SeqCst);
        let done = CountsDone(busy);
        spawn(pool, sender, move || {
            let _done = done;
            let sample = simulator.sample(index, &stop).ok();
            made(sample.map(|sample| {
                let numbers = simulator.numbers(&sample).map(|numbers| serde_json::Value::Object(numbers).to_string());
                (sample, numbers)
            }))
        });
    }

    fn sample(&self, py: Python<'_>, rendered: Rendered) -> PyResult<Sample> {
        let (record, numbers) = rendered.ok_or_else(|| of_program("a sample was stopped that nobody stopped"))?;
        Sample::of_record(py, self.simulator.clone(), record, numbers.map_err(|what| of_program(&what))?)
    }
}

/// Counts the sample as done, however it ends.
struct CountsDone(Arc<AtomicUsize>);

impl Drop for CountsDone {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Recipe {
    fn loaded(
        py: Python<'_>,
        changes: Vec<(String, String)>,
        load: impl FnOnce(&[Change]) -> Result<LoadedRecipe, LoadError> + Send,
    ) -> PyResult<Self> {
        let change = |(key, value): (String, String)| {
            format!("{key}={value}").parse::<Change>().map_err(|what| PyValueError::new_err(format!("{key}: {what}")))
        };
        let changes: Vec<Change> = changes.into_iter().map(change).collect::<PyResult<_>>()?;
        let loaded = py.detach(|| load(&changes)).map_err(|error| of_loading(py, &error))?;
        let dataset_seed = loaded.dataset.map(|dataset| dataset.head().seed);
        Ok(Self { recipe: loaded.recipe, dataset_seed, last: Mutex::new(None) })
    }
}

#[pymethods]
impl Recipe {
    /// The recipe of that name, with changes: keys and values in YAML.
    #[staticmethod]
    fn load(py: Python<'_>, name: &str, changes: Vec<(String, String)>) -> PyResult<Self> {
        Self::loaded(py, changes, |changes| api::load(name, changes))
    }

    /// The recipe of that text.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str, changes: Vec<(String, String)>) -> PyResult<Self> {
        Self::loaded(py, changes, |changes| api::parse("recipe", text, changes))
    }

    #[getter]
    fn name(&self) -> &str {
        self.recipe.name()
    }

    #[getter]
    fn hash(&self) -> String {
        self.recipe.hash()
    }

    #[getter]
    fn subject(&self) -> &str {
        self.recipe.subject().name()
    }

    #[getter]
    fn text(&self) -> &str {
        self.recipe.text()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.recipe.notes().to_vec()
    }

    #[getter]
    fn dataset_seed(&self) -> Option<u64> {
        self.dataset_seed
    }

    /// The head that its datasets have, as JSON.
    fn head(&self, seed: u64) -> PyResult<String> {
        let simulator = self.rendering(seed).simulator;
        serde_json::to_string(simulator.head()).map_err(|error| of_program(&error.to_string()))
    }

    /// Everything that it means, as JSON.
    fn canonical(&self) -> String {
        self.recipe.canonical().to_string()
    }

    /// Renders sample `index`.
    fn sample(&self, py: Python<'_>, index: u64, seed: u64, threads: Option<usize>) -> PyResult<Sample> {
        let threads = thread_count(threads)?;
        let pool = pool(py, threads)?;
        let rendering = self.rendering(seed);
        rendering.simulator.check_memory_of_one(threads).map_err(no_memory)?;
        let (sender, receiver) = channel();
        let stop = Arc::new(Stop::default());
        rendering.spawn(&pool, sender, (index, stop.clone()), |rendered| rendered);
        let rendered = wait(py, &Mutex::new(receiver)).inspect_err(|_| stop.ask())?;
        rendering.sample(py, rendered)
    }

    /// Renders samples, several side by side; `numbers` are the first number, the step to the next, and how many.
    fn samples(
        &self,
        py: Python<'_>,
        numbers: (u64, i64, u64),
        seed: u64,
        threads: Option<usize>,
    ) -> PyResult<Samples> {
        let threads = thread_count(threads)?;
        let rendering = self.rendering(seed);
        rendering.simulator.check_memory(threads).map_err(no_memory)?;
        let (sender, receiver) = channel();
        Ok(Samples {
            most: rendering.simulator.samples_in_flight(threads),
            pool: pool(py, threads)?,
            process: process::id(),
            rendering,
            numbers,
            begun: 0,
            given: 0,
            ready: BTreeMap::new(),
            sender,
            receiver: Mutex::new(receiver),
            stop: Arc::default(),
        })
    }
}

impl Recipe {
    /// The simulator for `seed`.
    fn rendering(&self, seed: u64) -> Rendering {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let process = process::id();
        let usable = |known: &&mut Rendering| {
            known.simulator.seed() == seed && (known.process == process || known.busy.load(Ordering::SeqCst) == 0)
        };
        if let Some(known) = last.as_mut().filter(usable) {
            known.process = process;
            return known.clone();
        }
        let simulator = Arc::new(Simulator::new(self.recipe.clone(), seed));
        last.insert(Rendering { simulator, process, busy: Arc::default() }).clone()
    }
}

fn no_memory(fault: Fault) -> PyErr {
    PyMemoryError::new_err(fault.to_string())
}

/// Samples of a recipe one after the other; as many as are in flight are rendered ahead.
#[pyclass(module = "sheetlight._sheetlight")]
pub(crate) struct Samples {
    rendering: Rendering,
    pool: Arc<ThreadPool>,
    process: u32,
    /// First number, step, and how many.
    numbers: (u64, i64, u64),
    /// Samples rendered or being rendered.
    begun: u64,
    /// Samples handed out.
    given: u64,
    /// Most samples begun and not handed out.
    most: u64,
    /// Samples that were faster than those before them.
    ready: BTreeMap<u64, Rendered>,
    sender: Sender<Outcome<(u64, Rendered)>>,
    receiver: Mutex<Receiver<Outcome<(u64, Rendered)>>>,
    stop: Arc<Stop>,
}

#[pymethods]
impl Samples {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&mut self, py: Python<'_>) -> PyResult<Option<Sample>> {
        let (first, step, count) = self.numbers;
        if self.process != process::id() {
            let what = "these samples are being rendered by another process, which this one was forked from";
            return Err(PyRuntimeError::new_err(format!("{what}; ask the recipe for samples here")));
        }
        if self.given == count || self.stop.is_asked() {
            return Ok(None);
        }
        while self.begun < count.min(self.given + self.most) {
            let place = self.begun;
            let index = first.wrapping_add_signed(step.wrapping_mul(place as i64));
            let work = (index, self.stop.clone());
            self.rendering.spawn(&self.pool, self.sender.clone(), work, move |rendered| (place, rendered));
            self.begun += 1;
        }
        let rendered = loop {
            if let Some(rendered) = self.ready.remove(&self.given) {
                break rendered;
            }
            let (place, rendered) = wait(py, &self.receiver).inspect_err(|_| self.stop.ask())?;
            self.ready.insert(place, rendered);
        };
        self.given += 1;
        self.rendering.sample(py, rendered).map(Some)
    }
}

impl Drop for Samples {
    /// Nobody takes what is still being rendered.
    fn drop(&mut self) {
        self.stop.ask();
    }
}
