//! ONNX model in onnxruntime: opened, held to what its sidecar says, run batch by batch. Only this file and
//! `onnxruntime.rs` name ort.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use ort::session::Session;
use ort::value::{Outlet, TensorElementType, TensorRef, ValueType};

use super::sidecar::{Layout, ModelTask, Sidecar};
use super::{CheckError, onnxruntime};

/// An open model whose input and output agree with its sidecar.
#[derive(Debug)]
pub(crate) struct OnnxModel {
    path: PathBuf,
    session: Session,
    output: String,
    /// Samples in a batch where the model takes no other number.
    fixed: Option<usize>,
    shape: ModelShape,
}

/// Shapes of input and output for one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ModelShape {
    /// Without the batch.
    input: [usize; 3],
    classes: usize,
    /// Rows and columns that each have an answer; `None` where the whole has one.
    cells: Option<[usize; 2]>,
    layout: Layout,
}

/// Output of a model for a batch.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scores {
    /// The numbers as they came.
    pub values: Vec<f32>,
    /// Numbers of an answer: the classes, or 1 for one of two.
    pub classes: usize,
    /// Answers of a sample.
    pub cells: usize,
    /// Whether the numbers of an answer lie side by side.
    pub side_by_side: bool,
}

impl Scores {
    /// Takes the numbers of answer `cell` of sample `i`.
    pub fn answer(&self, i: usize, cell: usize, out: &mut Vec<f32>) {
        let sample = &self.values[i * self.classes * self.cells..][..self.classes * self.cells];
        out.clear();
        if self.side_by_side {
            out.extend_from_slice(&sample[cell * self.classes..][..self.classes]);
        } else {
            out.extend(sample.iter().skip(cell).step_by(self.cells));
        }
    }
}

impl OnnxModel {
    /// Opens the model at `path` with `threads` threads.
    ///
    /// # Errors
    /// Where onnxruntime or the model cannot be loaded, or the model takes or gives something else than the sidecar
    /// says.
    pub fn open(path: &Path, sidecar: &Sidecar, threads: usize) -> Result<Self, CheckError> {
        let damaged = "export the model again, for onnxruntime 1.17 or newer";
        let environment = onnxruntime::load().map_err(CheckError::Library)?;
        let session = guarded(path, || -> ort::Result<Session> {
            let builder = Session::builder(&environment)?;
            // Threads that spin while they wait take the cores from those that decode the next pictures.
            let builder = builder.with_intra_threads(threads)?.with_intra_op_spinning(false)?;
            builder.with_inter_threads(1)?.commit_from_file(path)
        });
        let session = session?
            .map_err(|e| CheckError::at(path, format!("it is no usable model: {}", message_of(&e)), damaged))?;
        let [rows, cols] = sidecar.size;
        let planes = sidecar.channels.len();
        let shape = ModelShape {
            input: if sidecar.layout == Layout::Nchw { [planes, rows, cols] } else { [rows, cols, planes] },
            classes: sidecar.classes.len(),
            cells: (sidecar.task == ModelTask::Segment).then_some(sidecar.size),
            layout: sidecar.layout,
        };
        let told = |(what, remedy): Mismatch| CheckError::at(path, what, &remedy);
        let fixed = check_input(session.inputs(), shape).map_err(told)?;
        let output = choose_output(session.outputs(), sidecar.output_name.as_deref()).map_err(told)?;
        Ok(Self { path: path.into(), session, output, fixed, shape })
    }

    /// Samples in a batch where the model takes no other number.
    pub(crate) fn fixed_batch(&self) -> Option<usize> {
        self.fixed
    }

    /// Numbers of one sample's input.
    pub(crate) fn input_len(&self) -> usize {
        self.shape.input.iter().product()
    }

    /// Runs the model on `n` samples, whose inputs follow each other in `batch`; with a fixed batch `n` is at most
    /// that, and the rest of `batch` is filled up with zeros.
    ///
    /// # Errors
    /// Where the model fails, or answers in another shape than the sidecar says.
    pub fn run(&mut self, batch: &mut Vec<f32>, n: usize) -> Result<Scores, CheckError> {
        let all = self.fixed.unwrap_or(n);
        batch.resize(all * self.input_len(), 0.0);
        let [a, b, c] = self.shape.input;
        let (path, name) = (&self.path, &self.output);
        let session = &mut self.session;
        let failure = |e: &ort::Error| {
            let remedy = "hold the sidecar's channels, size_px and layout against the model's input";
            CheckError::at(path, format!("it fails on a batch of {all} x {:?}: {}", [a, b, c], message_of(e)), remedy)
        };
        let answer = guarded(path, || -> ort::Result<(Vec<i64>, Vec<f32>)> {
            let outputs = session.run(ort::inputs![TensorRef::from_array_view(([all, a, b, c], batch.as_slice()))?])?;
            let value = outputs.get(name.as_str()).ok_or_else(|| ort::Error::new("the output is gone"))?;
            let (shape, values) = value.try_extract_tensor::<f32>()?;
            Ok((shape.to_vec(), values.to_vec()))
        });
        let (shape, mut values) = answer?.map_err(|e| failure(&e))?;
        let layout = answer_layout(&shape, all, self.shape);
        let (classes, side_by_side) = layout.map_err(|(what, remedy)| CheckError::at(&self.path, what, &remedy))?;
        let cells = self.shape.cells.map_or(1, |[rows, cols]| rows * cols);
        values.truncate(n * classes * cells);
        Ok(Scores { values, classes, cells, side_by_side })
    }
}

/// onnxruntime may panic on a malicious file; that becomes a fault of the file.
fn guarded<T>(path: &Path, work: impl FnOnce() -> T) -> Result<T, CheckError> {
    let gave_up = |_| CheckError::at(path, "onnxruntime gave up on it".into(), "export the model again");
    catch_unwind(AssertUnwindSafe(work)).map_err(gave_up)
}

/// First line of onnxruntime's message.
fn message_of(error: &ort::Error) -> String {
    const MAX_LETTERS: usize = 300;
    let line = error.message().lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or("no reason is given");
    let clean: String = line.chars().take(MAX_LETTERS).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if line.chars().count() > MAX_LETTERS { clean + "..." } else { clean }
}

/// How a model differs from what its sidecar says, and what to do.
type Mismatch = (String, String);

/// Compares the model's inputs with `shape` and returns the fixed batch size.
fn check_input(inputs: &[Outlet], shape: ModelShape) -> Result<Option<usize>, Mismatch> {
    let [one] = inputs else {
        let names: Vec<&str> = inputs.iter().map(Outlet::name).collect();
        let what =
            format!("it has {} inputs ({}), and one image is all there is to give", inputs.len(), names.join(", "));
        return Err((what, "export it with a single input".into()));
    };
    let ValueType::Tensor { ty, shape: dims, .. } = one.dtype() else {
        let what = format!("its input `{}` is no tensor", one.name());
        return Err((what, "export it with an image as input".into()));
    };
    if *ty != TensorElementType::Float32 {
        let what = format!("its input `{}` is of type {ty}, not float32", one.name());
        return Err((what, "export it with a float32 input".into()));
    }
    let fits = |dim: i64, n: usize| dim < 0 || dim == n as i64;
    if dims.len() != 4 || !dims[1..].iter().zip(shape.input).all(|(&dim, n)| fits(dim, n)) || dims[0] == 0 {
        let layout = if shape.layout == Layout::Nchw {
            "batch, channels, rows, columns"
        } else {
            "batch, rows, columns, channels"
        };
        let what = format!(
            "its input `{}` takes {}, the sidecar gives {} ({layout})",
            one.name(),
            describe_shape(dims),
            describe_shape(&[-1, shape.input[0] as i64, shape.input[1] as i64, shape.input[2] as i64])
        );
        return Err((what, "correct channels, size_px or layout in the sidecar".into()));
    }
    Ok(usize::try_from(dims[0]).ok())
}

/// The output to read.
fn choose_output(outputs: &[Outlet], asked: Option<&str>) -> Result<String, Mismatch> {
    let names: Vec<&str> = outputs.iter().map(Outlet::name).collect();
    let found = match (asked, outputs) {
        (Some(name), _) => outputs.iter().find(|output| output.name() == name).ok_or_else(|| {
            (format!("it has no output `{name}`"), format!("give one of {} as output_name", names.join(", ")))
        })?,
        (None, [one]) => one,
        (None, _) => {
            let what = format!("it has {} outputs: {}", names.len(), names.join(", "));
            return Err((what, "name the one with the classes as output_name in the sidecar".into()));
        }
    };
    match found.dtype().tensor_type() {
        Some(TensorElementType::Float32) => Ok(found.name().to_owned()),
        _ => {
            let what = format!("its output `{}` is no tensor of float32", found.name());
            Err((what, "export it with the scores of the classes as output (no ZipMap, no ArgMax)".into()))
        }
    }
}

/// Numbers of an answer, and whether they lie side by side, in an output of this shape for `n` samples.
fn answer_layout(dims: &[i64], n: usize, shape: ModelShape) -> Result<(usize, bool), Mismatch> {
    let given = |wanted: &[usize]| dims.iter().map(|&dim| dim as usize).eq(wanted.iter().copied());
    let wanted = |classes: usize| match (shape.cells, shape.layout) {
        (None, _) => vec![n, classes],
        (Some([rows, cols]), Layout::Nchw) => vec![n, classes, rows, cols],
        (Some([rows, cols]), Layout::Nhwc) => vec![n, rows, cols, classes],
    };
    // A single number tells two classes apart.
    for classes in [shape.classes, 1] {
        if classes == 1 && shape.classes != 2 {
            continue;
        }
        let fits = if shape.cells.is_none() {
            let longer = dims.get(1..).unwrap_or_default().iter().filter(|&&dim| dim != 1).copied();
            dims.first() == Some(&(n as i64)) && longer.eq((classes != 1).then_some(classes as i64))
        } else {
            given(&wanted(classes))
        };
        // One number a cell may come without an axis of its own.
        let flat = classes == 1 && shape.cells.is_some_and(|[rows, cols]| given(&[n, rows, cols]));
        if fits || flat {
            return Ok((classes, shape.cells.is_none() || shape.layout == Layout::Nhwc));
        }
    }
    let wanted: Vec<i64> = wanted(shape.classes).into_iter().map(|side| side as i64).collect();
    let what = format!("it answers in the shape {}, not {}", describe_shape(dims), describe_shape(&wanted));
    let remedy = match shape.cells {
        Some(_) => "list as many classes as it has, set layout, and let it answer at the size of its input",
        None => "list as many classes in the sidecar as the model has",
    };
    Err((what, remedy.into()))
}

/// A shape in words; `any` for a free side.
fn describe_shape(dims: &[i64]) -> String {
    let side = |&dim: &i64| if dim < 0 { "any".to_owned() } else { dim.to_string() };
    dims.iter().map(side).collect::<Vec<_>>().join(" x ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(classes: usize, cells: Option<[usize; 2]>, layout: Layout) -> ModelShape {
        ModelShape { input: [1, 4, 6], classes, cells, layout }
    }

    #[test]
    fn shapes_of_answers_are_told_apart() {
        let whole = shape(3, None, Layout::Nchw);
        assert_eq!(answer_layout(&[5, 3], 5, whole), Ok((3, true)));
        assert_eq!(answer_layout(&[5, 3, 1, 1], 5, whole), Ok((3, true)));
        for wrong in [&[5, 4][..], &[3, 5], &[5, 3, 2], &[5], &[5, 1], &[], &[15]] {
            assert!(answer_layout(wrong, 5, whole).is_err(), "{wrong:?}");
        }
        for one in [&[5][..], &[5, 1]] {
            assert_eq!(answer_layout(one, 5, shape(2, None, Layout::Nchw)), Ok((1, true)), "{one:?}");
        }
        let cells = |classes, layout| shape(classes, Some([4, 6]), layout);
        assert_eq!(answer_layout(&[5, 3, 4, 6], 5, cells(3, Layout::Nchw)), Ok((3, false)));
        assert_eq!(answer_layout(&[5, 4, 6, 3], 5, cells(3, Layout::Nhwc)), Ok((3, true)));
        assert_eq!(answer_layout(&[5, 4, 6], 5, cells(2, Layout::Nchw)), Ok((1, false)));
        for wrong in [&[5, 3, 6, 4][..], &[5, 4, 6, 3], &[5, 3, 2, 3], &[5, 4, 6]] {
            assert!(answer_layout(wrong, 5, cells(3, Layout::Nchw)).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn answers_are_taken_from_both_orders() {
        let mut answer = Vec::new();
        let planes = Scores { values: (0..12).map(|i| i as f32).collect(), classes: 2, cells: 3, side_by_side: false };
        planes.answer(1, 2, &mut answer);
        assert_eq!(answer, [8.0, 11.0]);
        Scores { side_by_side: true, ..planes }.answer(1, 2, &mut answer);
        assert_eq!(answer, [10.0, 11.0]);
    }
}
