//! Line charts: axes with ticks, also logarithmic ones, lines, marks with error bars, and a legend.

use image::Rgb;

use super::{Area, INK, LETTER, Page};

/// Space beside the plot for numbers, and above and below it for words [px].
const LEFT: f64 = 48.0;
const RIGHT: f64 = 10.0;
const ABOVE: f64 = 36.0;
const BELOW: f64 = 36.0;
const GRID: Rgb<u8> = Rgb([225, 225, 220]);

/// An axis of a chart.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Label, with the unit.
    pub words: String,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Whether the axis is logarithmic.
    pub log: bool,
}

/// A series of points.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Its colour.
    pub colour: Rgb<u8>,
    /// (x, y, standard error of y); bars are drawn where there is one.
    pub points: Vec<(f64, f64, f64)>,
    /// Whether points are joined.
    pub joined: bool,
}

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Words above it.
    pub title: String,
    /// Axis to the right.
    pub x: Axis,
    /// Axis upwards.
    pub y: Axis,
    /// Series to draw, in this order.
    pub series: Vec<Series>,
    /// Words below it, left of the words of x, and their colour.
    pub foot: (String, Rgb<u8>),
}

impl Series {
    /// Points that are joined.
    pub fn curve(colour: Rgb<u8>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = points.into_iter().map(|(x, y)| (x, y, 0.0));
        Self { joined: true, ..Self::marks(colour, points) }
    }

    /// Marks with error bars.
    pub fn marks(colour: Rgb<u8>, points: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        Self { name: String::new(), colour, points: points.into_iter().collect(), joined: false }
    }

    /// The same with a name in the legend.
    pub fn named(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }
}

impl Axis {
    /// A linear axis.
    pub fn even(words: &str, from: f64, to: f64) -> Self {
        Self { words: words.to_owned(), from, to, log: false }
    }

    /// A logarithmic axis.
    pub fn log(words: &str, from: f64, to: f64) -> Self {
        Self { words: words.to_owned(), from, to, log: true }
    }

    /// Where a number lies, 0 at the beginning and 1 at the end; `None` where it has no place.
    fn place(&self, value: f64) -> Option<f64> {
        let place = if self.log {
            libm::log(value / self.from) / libm::log(self.to / self.from)
        } else {
            (value - self.from) / (self.to - self.from)
        };
        place.is_finite().then_some(place)
    }

    /// Numbers that get a tick, and their words; minor ticks have none.
    fn ticks(&self) -> Vec<(f64, Option<String>)> {
        if self.log { self.log_ticks() } else { self.linear_ticks() }
    }

    fn log_ticks(&self) -> Vec<(f64, Option<String>)> {
        let exponent = |v: f64| libm::log10(v);
        let (first, last) = (exponent(self.from).floor() as i32, exponent(self.to).ceil() as i32);
        let mut ticks = Vec::new();
        for k in first..=last {
            let decade = libm::pow(10.0, f64::from(k));
            let words = if (-2..=3).contains(&k) { format!("{decade}") } else { format!("1e{k}") };
            ticks.push((decade, Some(words)));
            ticks.extend((2..10).map(|m| (decade * f64::from(m), None)));
        }
        ticks.retain(|(value, _)| self.inside(*value));
        ticks
    }

    fn linear_ticks(&self) -> Vec<(f64, Option<String>)> {
        const MAX_TICKS: f64 = 6.0;
        let rough = (self.to - self.from) / MAX_TICKS;
        let power = libm::pow(10.0, libm::log10(rough).floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
        let digits = (-libm::log10(step) - 1e-9).ceil().max(0.0) as usize;
        let (first, last) = ((self.from / step - 1e-9).ceil() as i64, (self.to / step + 1e-9).floor() as i64);
        (first..=last).map(|i| (i as f64 * step, Some(format!("{:.digits$}", i as f64 * step)))).collect()
    }

    fn inside(&self, value: f64) -> bool {
        self.place(value).is_some_and(|place| (-1e-9..=1.0 + 1e-9).contains(&place))
    }
}

impl Chart {
    /// A chart without foot.
    pub fn new(title: &str, x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self { title: title.to_owned(), x, y, series, foot: (String::new(), INK) }
    }

    /// Draws it into an area of the page.
    pub fn draw(&self, page: &mut Page, area: Area) {
        let Area { left, top, width, height } = area;
        let (x0, y1) = (f64::from(left) + LEFT, f64::from(top) + ABOVE);
        let (x1, y0) = (f64::from(left + width) - RIGHT, f64::from(top + height) - BELOW);
        let across = |t: f64| x0 + t * (x1 - x0);
        let up = |t: f64| y0 + t * (y1 - y0);
        page.words(left, top + 12, &self.title);
        page.words(left, top + 28, &self.y.words);
        page.words_in(left, top + height - 6, &self.foot.0, self.foot.1);
        let words = LETTER * self.x.words.len() as u32;
        page.words((x1 as u32).saturating_sub(words), top + height - 6, &self.x.words);
        for (value, label) in self.x.ticks() {
            let Some(t) = self.x.place(value) else { continue };
            page.line((across(t), y0), (across(t), if label.is_some() { y1 } else { y0 - 3.0 }), GRID, 1);
            page.line((across(t), y0), (across(t), y0 + if label.is_some() { 4.0 } else { 2.0 }), INK, 1);
            if let Some(label) = label {
                let half = f64::from(LETTER) * label.len() as f64 / 2.0;
                page.words((across(t) - half).max(0.0) as u32, y0 as u32 + 16, &label);
            }
        }
        for (value, label) in self.y.ticks() {
            let Some(t) = self.y.place(value) else { continue };
            page.line((x0, up(t)), (if label.is_some() { x1 } else { x0 + 3.0 }, up(t)), GRID, 1);
            page.line((x0 - if label.is_some() { 4.0 } else { 2.0 }, up(t)), (x0, up(t)), INK, 1);
            if let Some(label) = label {
                let wide = f64::from(LETTER) * label.len() as f64;
                page.words((x0 - 6.0 - wide).max(0.0) as u32, up(t) as u32 + 4, &label);
            }
        }
        page.line((x0, y0), (x1, y0), INK, 1);
        page.line((x0, y0), (x0, y1), INK, 1);
        for series in &self.series {
            self.series(page, series, &across, &up);
        }
        let named: Vec<_> = self.series.iter().filter(|series| !series.name.is_empty()).collect();
        for (i, series) in named.into_iter().enumerate() {
            let right = (x1 as u32).saturating_sub(LETTER * series.name.len() as u32 + 2);
            let line = y1 as u32 + 12 + 14 * i as u32;
            page.words_in(right, line, &series.name, series.colour);
            let y = f64::from(line) - 4.0;
            page.line((f64::from(right) - 18.0, y), (f64::from(right) - 4.0, y), series.colour, 2);
        }
    }

    fn series(&self, page: &mut Page, series: &Series, across: &dyn Fn(f64) -> f64, up: &dyn Fn(f64) -> f64) {
        // A few marks may be large.
        let half = if series.points.len() < 20 { 2.0 } else { 1.0 };
        let mut last: Option<(f64, f64)> = None;
        for &(x, y, error) in &series.points {
            let place = self.x.place(x).filter(|_| self.x.inside(x)).zip(self.y.place(y));
            if let (true, Some(from), Some(to)) = (series.joined, last, place)
                && let Some((from, to)) = clip(from, to)
            {
                page.line((across(from.0), up(from.1)), (across(to.0), up(to.1)), series.colour, 1);
            }
            last = place;
            let Some((t, v)) = place.filter(|(_, v)| (0.0..=1.0).contains(v)) else { continue };
            if !series.joined {
                let wide = 2 * half as u32 + 1;
                page.line((across(t) - half, up(v)), (across(t) + half, up(v)), series.colour, wide);
            }
            if error > 0.0 {
                let end = |y: f64, none: f64| self.y.place(y).unwrap_or(none).clamp(0.0, 1.0);
                let (low, high) = (end(y - error, 0.0), end(y + error, 1.0));
                page.line((across(t), up(low)), (across(t), up(high)), series.colour, 1);
                for v in [low, high] {
                    page.line((across(t) - 2.0, up(v)), (across(t) + 2.0, up(v)), series.colour, 1);
                }
            }
        }
    }
}

/// The part of a line between y = 0 and y = 1.
fn clip(from: (f64, f64), to: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
    let at = |y: f64| {
        let t = (y - from.1) / (to.1 - from.1);
        (from.0 + t * (to.0 - from.0), y)
    };
    let end = |p: (f64, f64)| if (0.0..=1.0).contains(&p.1) { p } else { at(p.1.clamp(0.0, 1.0)) };
    let missed = (from.1 < 0.0 && to.1 < 0.0) || (from.1 > 1.0 && to.1 > 1.0);
    (!missed).then(|| (end(from), end(to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|(_, words)| words).collect()
    }

    /// Ticks stand on round numbers within the axis, with as many digits as it takes.
    #[test]
    fn ticks_are_round() {
        assert_eq!(words(&Axis::even("", 0.0, 1.5)), ["0.0", "0.5", "1.0", "1.5"]);
        assert_eq!(words(&Axis::even("", -4.0, 4.0)), ["-4", "-2", "0", "2", "4"]);
        assert_eq!(words(&Axis::even("", 0.0, 90.0)), ["0", "20", "40", "60", "80"]);
        assert_eq!(words(&Axis::log("", 5e-5, 20.0)), ["1e-4", "1e-3", "0.01", "0.1", "1", "10"]);
        let minor = Axis::log("", 1.0, 10.0).ticks().into_iter().filter(|(_, words)| words.is_none()).count();
        assert_eq!(minor, 8);
    }

    /// A line at half height crosses the middle of the plot in its colour; what lies outside of the axes stays off.
    #[test]
    fn lines_lie_where_their_numbers_say() {
        let red = Rgb([255, 0, 0]);
        let chart = |y: f64, log: bool| {
            let axis = if log { Axis::log("y", 0.01, 100.0) } else { Axis::even("y", 0.0, 2.0) };
            let series = Series::curve(red, [(0.0, y), (1.0, y)]);
            let mut page = Page::new(300, 200);
            let chart = Chart::new("t", Axis::even("x", 0.0, 1.0), axis, vec![series]);
            chart.draw(&mut page, Area { left: 0, top: 0, width: 300, height: 200 });
            let lit = page.0.enumerate_pixels().filter(|(_, _, colour)| **colour == red);
            lit.map(|(_, y, _)| y).collect::<Vec<_>>()
        };
        let middle = ((ABOVE + 200.0 - BELOW) / 2.0).round() as u32;
        for log in [false, true] {
            let rows = chart(1.0, log);
            assert_eq!(rows.len() as f64, 300.0 - LEFT - RIGHT + 1.0);
            assert!(rows.iter().all(|row| *row == middle), "{rows:?}");
            assert!(chart(-1.0, log).is_empty() && chart(1e3, log).is_empty());
        }
    }
}
