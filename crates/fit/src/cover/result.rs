//! What `cover` has found.

use base::{Parameter, words};
use serde_json::{Value, json};

use crate::result::short;

words! {
    /// Where a real scan's statistic lies among those of simulated scans.
    CoverPlace {
        /// Within 5 to 95 % of them.
        Inside = "inside",
        /// Beyond that, as a scan of the recipe may lie too.
        Edge = "edge",
        /// Beyond what scans of the recipe show.
        Outside = "outside",
    }
}

/// A statistic of one real scan beside simulated ones, in its unit.
#[derive(Debug, Clone)]
pub struct CoveredStatistic {
    /// Its key.
    pub key: String,
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// 5, 50 and 95 % of simulated scans, where enough of them tell it.
    pub simulated: Option<[f64; 3]>,
    /// What the real scan has.
    pub real: Option<f64>,
    /// One standard error either side of it, from its halves.
    pub real_ends: Option<[f64; 2]>,
    /// Share of simulated scans below it [1].
    pub below: Option<f64>,
    /// Distance from the median over that of the farthest simulated scan on its side [1].
    pub out: Option<f64>,
    /// Where it lies; `None` where either side does not tell it.
    pub place: Option<CoverPlace>,
}

/// One real scan among simulated ones.
#[derive(Debug, Clone)]
pub struct CoveredScan {
    /// What it is called.
    pub name: String,
    /// Its statistics: of the whole scan, then of labelled classes.
    pub statistics: Vec<CoveredStatistic>,
    /// Robust distance from the middle of simulated scans, all statistics together.
    pub depth: f64,
    /// Distance beyond which the scan lies outside.
    pub limit: f64,
    /// [`CoveredStatistic::out`] beyond which a statistic lies outside.
    pub out_limit: f64,
    /// Share of simulated scans that lie as far among the others [1].
    pub share_beyond: f64,
}

/// A key that explains what lies outside, where it has values that the recipe does not draw.
#[derive(Debug, Clone)]
pub struct WidenedKey {
    /// Its path.
    pub path: String,
    /// Its declaration.
    pub parameter: &'static Parameter,
    /// What the recipe draws, from and to.
    pub drawn: [f64; 2],
    /// The values that explain most of the scans outside, least and greatest of them.
    pub values: [f64; 2],
    /// Share of the squared depth that is left with it [1].
    pub left: f64,
    /// Whether all scans lie within both limits with it.
    pub covers: bool,
    /// Others of these keys that do the same to the first of the scans.
    pub alike: Vec<String>,
}

/// A statistic that is nearly the same in all simulated scans.
#[derive(Debug, Clone)]
pub struct StillStatistic {
    /// Its key.
    pub key: String,
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// 5, 50 and 95 % of simulated scans.
    pub three: [f64; 3],
}

/// What a key does over the inner 90 % of its distribution.
#[derive(Debug, Clone)]
pub struct KeyEffect {
    /// Its path.
    pub path: String,
    /// Its declaration.
    pub parameter: &'static Parameter,
    /// The statistic that it moves most; empty where it moves none.
    pub statistic: String,
    /// By how many deviations of simulated scans.
    pub by: f64,
    /// Whether that is next to nothing.
    pub is_idle: bool,
}

/// What was found.
#[derive(Debug, Clone, Default)]
pub struct Cover {
    /// Name of the recipe.
    pub recipe: String,
    /// Seed.
    pub seed: u64,
    /// Simulated scans of the recipe as it is.
    pub simulations: usize,
    /// The real scans.
    pub scans: Vec<CoveredScan>,
    /// Keys that explain what lies outside, the best first.
    pub widen: Vec<WidenedKey>,
    /// How many keys were asked.
    pub asked: usize,
    /// Without real scans: statistics that hardly vary.
    pub still: Vec<StillStatistic>,
    /// Without real scans: the classes that simulated scans show.
    pub classes: Vec<String>,
    /// Without real scans: the keys that are drawn, those that do most first.
    pub keys: Vec<KeyEffect>,
    /// Without real scans: keys that are drawn and were not asked, since classes change them or others go with them.
    pub held: Vec<String>,
}

impl CoveredScan {
    /// Whether it lies outside of what the recipe makes.
    pub fn is_outside(&self) -> bool {
        self.depth > self.limit || self.outside().next().is_some()
    }

    /// Its statistics that lie outside.
    pub fn outside(&self) -> impl Iterator<Item = &CoveredStatistic> {
        self.statistics.iter().filter(|statistic| statistic.place == Some(CoverPlace::Outside))
    }

    /// How many of its statistics lie inside, at the edge and outside.
    pub fn counts(&self) -> [usize; 3] {
        CoverPlace::ALL.map(|place| self.statistics.iter().filter(|statistic| statistic.place == Some(place)).count())
    }
}

impl WidenedKey {
    /// What to do: `widen camera.blur_um above 6, to about 9 um`.
    pub fn words(&self) -> String {
        let [low, high] = self.drawn.map(short);
        let [least, greatest] = self.values.map(short);
        let path = &self.path;
        match () {
            () if self.values[0] > self.drawn[1] => format!("widen {path} above {high}, to about {greatest}"),
            () if self.values[1] < self.drawn[0] => format!("widen {path} below {low}, to about {least}"),
            () => format!("widen {path} on both sides, to {least} and {greatest}"),
        }
    }
}

impl Cover {
    /// Real scans that lie outside.
    pub fn outside(&self) -> usize {
        self.scans.iter().filter(|scan| scan.is_outside()).count()
    }

    /// All of it as JSON.
    pub fn json(&self) -> Value {
        let three = |numbers: [f64; 3]| json!({ "p05": numbers[0], "p50": numbers[1], "p95": numbers[2] });
        let statistic = |statistic: &CoveredStatistic| {
            json!({
                "key": statistic.key,
                "unit": statistic.unit,
                "simulated": statistic.simulated.map(three),
                "real": statistic.real,
                "real_ends": statistic.real_ends,
                "share_below": statistic.below,
                "out": statistic.out,
                "place": statistic.place.map(CoverPlace::name),
            })
        };
        let scan = |scan: &CoveredScan| {
            json!({
                "name": scan.name,
                "outside": scan.is_outside(),
                "depth": scan.depth,
                "depth_limit": scan.limit,
                "share_beyond": scan.share_beyond,
                "out_limit": scan.out_limit,
                "statistics": scan.statistics.iter().map(statistic).collect::<Vec<_>>(),
            })
        };
        let widen = |key: &WidenedKey| {
            json!({
                "key": key.path,
                "drawn": key.drawn,
                "values": key.values,
                "left": key.left,
                "covers": key.covers,
                "alike": key.alike,
                "words": key.words(),
            })
        };
        let still =
            |still: &StillStatistic| json!({ "key": still.key, "unit": still.unit, "simulated": three(still.three) });
        let effect = |key: &KeyEffect| {
            let KeyEffect { path, statistic, by, is_idle, .. } = key;
            json!({ "key": path, "moves_most": statistic, "deviations": by, "idle": is_idle })
        };
        json!({
            "program": format!("gen {}", env!("CARGO_PKG_VERSION")),
            "recipe": self.recipe,
            "seed": self.seed,
            "simulations": self.simulations,
            "scans": self.scans.iter().map(scan).collect::<Vec<_>>(),
            "widen": self.widen.iter().map(widen).collect::<Vec<_>>(),
            "keys_asked": self.asked,
            "classes": self.classes,
            "still": self.still.iter().map(still).collect::<Vec<_>>(),
            "keys": self.keys.iter().map(effect).collect::<Vec<_>>(),
            "keys_not_asked": self.held,
        })
    }
}
