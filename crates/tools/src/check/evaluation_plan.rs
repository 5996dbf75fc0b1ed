//! Evaluation plan: which windows of which samples the model sees, decided from the tables before any image is read.

use super::sampling::even_share;
use super::sidecar::{ModelTask, Sidecar};
use super::split_samples::{SampleFacts, SampleObject};
use super::window::InputWindow;

/// Windows of one sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum SampleWindows {
    /// These windows, each with its class.
    Windows(Vec<(InputWindow, usize)>),
    /// Windows around pixels that are yet to be drawn: as many of each class.
    Pixels(Vec<u64>),
    /// The class of each pixel of every tile.
    Tiles,
}

impl SampleWindows {
    /// Whether the model sees nothing of the sample.
    pub fn is_empty(&self) -> bool {
        match self {
            Self::Windows(windows) => windows.is_empty(),
            Self::Pixels(wanted) => wanted.iter().all(|&n| n == 0),
            Self::Tiles => false,
        }
    }
}

/// Windows of a split.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct EvaluationPlan {
    /// Of each sample, in the order of the facts.
    pub work: Vec<SampleWindows>,
    /// Windows that cover an image, for segmentation.
    pub tiles: Vec<InputWindow>,
    /// Number of windows; an upper bound where pixels are drawn.
    pub units: u64,
    /// Samples or objects whose class is none of the model's, or of which there were enough.
    pub left_out: u64,
}

/// Plans for samples with images of `image`, rows and columns [px].
pub fn plan(sidecar: &Sidecar, facts: &[SampleFacts], image: [usize; 2]) -> EvaluationPlan {
    let class = |value: usize| sidecar.truth.get(value).copied().flatten();
    let whole = InputWindow { first: [0, 0], size: image };
    let window = sidecar.window.unwrap_or(image);
    let (mut left_out, mut tiles) = (0, Vec::new());
    let work: Vec<SampleWindows> = match sidecar.task {
        ModelTask::Samples => {
            let cut = sidecar.window.map_or(whole, |size| InputWindow::around(image.map(|side| side as i64 / 2), size));
            let known = facts.iter().map(|facts| class(facts.class));
            left_out = known.clone().filter(Option::is_none).count() as u64;
            known.map(|class| SampleWindows::Windows(class.map(|class| (cut, class)).into_iter().collect())).collect()
        }
        ModelTask::Objects => {
            let mut totals = vec![0_u64; sidecar.classes.len()];
            let all = || facts.iter().flat_map(|facts| &facts.objects);
            all().filter_map(|object| class(object.state)).for_each(|class| totals[class] += 1);
            let mut seen = vec![0; totals.len()];
            let mut take = |state: usize| {
                let taken = class(state).filter(|&class| {
                    let rank = seen[class];
                    seen[class] += 1;
                    even_share(sidecar.patches_per_class.min(totals[class]), rank, totals[class]) > 0
                });
                left_out += u64::from(taken.is_none());
                taken
            };
            let windows = facts.iter().map(|facts| {
                let cut =
                    |object: &SampleObject| Some((InputWindow::around(object.middle, window), take(object.state)?));
                SampleWindows::Windows(facts.objects.iter().filter_map(cut).collect())
            });
            windows.collect()
        }
        ModelTask::Pixels => {
            let shows = |facts: &SampleFacts, wanted: usize| {
                facts.area.iter().enumerate().any(|(value, &area)| area > 0 && class(value) == Some(wanted))
            };
            let mut work = vec![vec![0; sidecar.classes.len()]; facts.len()];
            for class in 0..sidecar.classes.len() {
                let showing: Vec<usize> = (0..facts.len()).filter(|&i| shows(&facts[i], class)).collect();
                for (rank, &i) in showing.iter().enumerate() {
                    work[i][class] = even_share(sidecar.patches_per_class, rank as u64, showing.len() as u64);
                }
            }
            work.into_iter().map(SampleWindows::Pixels).collect()
        }
        ModelTask::Segment => {
            let firsts = |side: usize| (0..image[side]).step_by(window[side]).map(|first| first as i64);
            tiles.extend(
                firsts(0).flat_map(|row| firsts(1).map(move |col| InputWindow { first: [row, col], size: window })),
            );
            facts.iter().map(|_| SampleWindows::Tiles).collect()
        }
    };
    let units = work.iter().map(|work| match work {
        SampleWindows::Windows(windows) => windows.len() as u64,
        SampleWindows::Pixels(wanted) => wanted.iter().sum(),
        SampleWindows::Tiles => tiles.len() as u64,
    });
    EvaluationPlan { units: units.sum(), work, tiles, left_out }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::sidecar::{InputChannel, Layout, OutputKind};

    /// Two classes: dataset classes 1 and 2 are the first, 3 is the second.
    fn sidecar(task: ModelTask, window: Option<[usize; 2]>, patches: u64) -> Sidecar {
        Sidecar {
            task,
            channels: vec![InputChannel { name: "scatter".into(), mean: 0.0, sd: 1.0, missing: 0.0, relative: false }],
            window,
            size: [4, 4],
            layout: Layout::Nchw,
            output: OutputKind::Logits,
            output_name: None,
            patches_per_class: patches,
            classes: vec!["a".into(), "b".into()],
            truth: vec![None, Some(0), Some(0), Some(1)],
            trained_on: None,
        }
    }

    fn facts(class: usize, area: [u64; 4], states: &[usize]) -> SampleFacts {
        let objects = states.iter().map(|&state| SampleObject { state, middle: [10, 20] }).collect();
        SampleFacts { index: 0, id: String::new(), class, area: area.to_vec(), objects, numbers: Vec::new() }
    }

    fn planned(sidecar: &Sidecar, all: &[SampleFacts]) -> EvaluationPlan {
        plan(sidecar, all, [30, 40])
    }

    #[test]
    fn samples_are_whole_or_their_middle() {
        let all = [facts(0, [0; 4], &[]), facts(2, [0; 4], &[]), facts(9, [0; 4], &[])];
        let whole = planned(&sidecar(ModelTask::Samples, None, 9), &all);
        assert_eq!((whole.units, whole.left_out), (1, 2));
        assert_eq!(whole.work[1], SampleWindows::Windows(vec![(InputWindow { first: [0, 0], size: [30, 40] }, 0)]));
        let middle = planned(&sidecar(ModelTask::Samples, Some([10, 10]), 9), &all);
        assert_eq!(middle.work[1], SampleWindows::Windows(vec![(InputWindow { first: [10, 15], size: [10, 10] }, 0)]));
    }

    /// Objects keep their order; of too many of a class every so-many-th is taken.
    #[test]
    fn objects_are_thinned_evenly() {
        let all = [facts(0, [0; 4], &[1, 3, 0]), facts(0, [0; 4], &[2, 1, 2]), facts(0, [0; 4], &[])];
        let plan = planned(&sidecar(ModelTask::Objects, Some([4, 4]), 2), &all);
        assert_eq!((plan.units, plan.left_out), (3, 3));
        let window = InputWindow { first: [8, 18], size: [4, 4] };
        // Of the first class numbers 1 and 3 of four.
        assert_eq!(
            plan.work,
            [
                SampleWindows::Windows(vec![(window, 1)]),
                SampleWindows::Windows(vec![(window, 0); 2]),
                SampleWindows::Windows(vec![])
            ]
        );
    }

    /// Each class is wanted as often, from the samples that show it.
    #[test]
    fn pixels_are_balanced() {
        let all = [facts(0, [5, 1, 0, 0], &[]), facts(0, [0, 0, 1, 1], &[]), facts(0, [9, 0, 0, 0], &[])];
        let plan = planned(&sidecar(ModelTask::Pixels, Some([4, 4]), 7), &all);
        assert_eq!(
            plan.work,
            [SampleWindows::Pixels(vec![3, 0]), SampleWindows::Pixels(vec![4, 7]), SampleWindows::Pixels(vec![0, 0])]
        );
        assert!(plan.work[2].is_empty() && !plan.work[1].is_empty());
        assert_eq!(plan.units, 14);
    }

    #[test]
    fn tiles_cover_the_image() {
        let plan = planned(&sidecar(ModelTask::Segment, Some([16, 40]), 1), &[facts(0, [1; 4], &[])]);
        let tile = |row| InputWindow { first: [row, 0], size: [16, 40] };
        assert_eq!((plan.work, plan.tiles, plan.units), (vec![SampleWindows::Tiles], vec![tile(0), tile(16)], 2));
    }
}
