//! From a node to a distribution: forms, arguments, and whether what it draws lies in the parameter's range.

use procedural::Parameter;

use super::dist::{Distribution, LEAST_CHANCE};
use super::forms;
use super::table::unit;
use crate::yaml::fault::nearest;
use crate::yaml::node::{Node, Value};
use crate::yaml::walk::{Range, Section, Walk, clipped, shown};

/// Largest magnitude of an argument that the parameter's own range does not bound.
const LARGEST: f64 = 1e9;
/// Most values of a choice.
const MOST_VALUES: usize = 1000;

/// The numbers that a parameter may take.
pub(super) fn range(parameter: &Parameter) -> Range {
    Range { min: parameter.min, max: parameter.max, whole: parameter.integer, unit: unit(parameter.name) }
}

/// Reads the number or distribution at `node`; faults are noted and give `None`.
pub(super) fn read(walk: &mut Walk, node: &Node, path: &str, parameter: &Parameter) -> Option<Distribution> {
    let range = range(parameter);
    let distribution = Reader { walk: &mut *walk, range }.distribution(node, path, false)?;
    let chance = distribution.chance_inside(parameter);
    if chance < LEAST_CHANCE {
        let problem = format!("only {:.2} % of its draws lie where they may", 100.0 * chance);
        walk.fault(node.place, path, problem, format!("at least 1 % must; `{path}` is {range}"));
        return None;
    }
    Some(distribution)
}

/// Reads the arguments of one distribution within `range`.
struct Reader<'w, 't> {
    walk: &'w mut Walk<'t>,
    range: Range,
}

impl Reader<'_, '_> {
    fn distribution(&mut self, node: &Node, path: &str, nested: bool) -> Option<Distribution> {
        let all_forms = || format!("give {} or one of {{{}: ...}}", self.range, forms::keys().join(": ...}, {"));
        match &node.value {
            Value::Map(entries) => match entries.as_slice() {
                [(key, arguments)] => {
                    let path = format!("{path}.{}", clipped(&key.name));
                    match key.name.as_str() {
                        "uniform" => self.pair(arguments, &path).map(|(min, max)| Distribution::Uniform { min, max }),
                        "log_uniform" => self.log_uniform(arguments, &path),
                        "normal" => self.normal(arguments, &path),
                        "lognormal" => self.lognormal(arguments, &path),
                        "choice" => self.choice(arguments, &path),
                        "truncated" if !nested => self.truncated(arguments, &path),
                        "truncated" => {
                            let remedy = "truncate once, between the larger `min` and the smaller `max`";
                            self.walk.fault(key.place, &path, "truncates a truncated distribution", remedy);
                            None
                        }
                        unknown => {
                            let meant = nearest(unknown, forms::keys()).map(|form| format!("did you mean `{form}`? "));
                            let remedy = format!("{}{}", meant.unwrap_or_default(), all_forms());
                            self.walk.fault(key.place, &path, "is no distribution", remedy);
                            None
                        }
                    }
                }
                _ => {
                    let problem = format!("is a map of {} keys, and a distribution has one", entries.len());
                    let remedy = all_forms();
                    self.walk.fault(node.place, path, problem, remedy);
                    None
                }
            },
            Value::Number(_) | Value::Text(_) => self.walk.number_in(node, path, self.range).map(Distribution::Fixed),
            other => {
                let (problem, remedy) = (format!("is {}", other.kind()), all_forms());
                self.walk.fault(node.place, path, problem, remedy);
                None
            }
        }
    }

    /// `[min, max]`.
    fn pair(&mut self, node: &Node, path: &str) -> Option<(f64, f64)> {
        let remedy = format!("give [smallest, largest], each {}", self.range);
        let Value::List(ends) = &node.value else {
            self.walk.fault(node.place, path, format!("is {}", node.value.kind()), remedy);
            return None;
        };
        let [min, max] = ends.as_slice() else {
            self.walk.fault(node.place, path, format!("is a list of {}", ends.len()), remedy);
            return None;
        };
        let least = self.walk.number_in(min, path, self.range);
        let most = self.walk.number_in(max, path, self.range);
        self.ordered(node, path, least?, most?)
    }

    fn ordered(&mut self, node: &Node, path: &str, min: f64, max: f64) -> Option<(f64, f64)> {
        if min <= max {
            return Some((min, max));
        }
        let problem = format!("smallest {} is over largest {}", shown(min), shown(max));
        self.walk.fault(node.place, path, problem, "swap them");
        None
    }

    fn log_uniform(&mut self, node: &Node, path: &str) -> Option<Distribution> {
        let (min, max) = self.pair(node, path)?;
        if min > 0.0 {
            return Some(Distribution::LogUniform { min, max });
        }
        self.walk.fault(node.place, path, format!("begins at {}", shown(min)), "begin above 0, or take `uniform`");
        None
    }

    fn normal(&mut self, node: &Node, path: &str) -> Option<Distribution> {
        let mut section = self.walk.section(node, path);
        let mean = self.argument(&mut section, node, "mean", -LARGEST);
        let sd = self.argument(&mut section, node, "sd", 0.0);
        self.close(section, &["mean", "sd"]);
        Some(Distribution::Normal { mean: mean?, sd: sd? })
    }

    fn lognormal(&mut self, node: &Node, path: &str) -> Option<Distribution> {
        let mut section = self.walk.section(node, path);
        let median = self.argument(&mut section, node, "median", 1.0 / LARGEST);
        let log_sd = self.argument(&mut section, node, "log_sd", 0.0);
        self.close(section, &["median", "log_sd"]);
        let (median, log_sd) = (median?, log_sd?);
        /// A factor of e^20 = 5e8 is beyond every parameter's range.
        const WIDEST: f64 = 20.0;
        if log_sd > WIDEST {
            let problem = format!("{} is out of range", shown(log_sd));
            let remedy = format!("`log_sd` is in natural logarithms, at most {WIDEST}");
            self.walk.fault(node.place, &format!("{path}.log_sd"), problem, remedy);
            return None;
        }
        Some(Distribution::Lognormal { median, log_sd })
    }

    fn choice(&mut self, node: &Node, path: &str) -> Option<Distribution> {
        let range = self.range;
        let mut section = self.walk.section(node, path);
        let values = self.list(&mut section, "values", range);
        if values.is_none() {
            self.walk.fault(node.place, path, "has no `values`", format!("give a list, each {range}"));
        }
        let weights = self.list(&mut section, "weights", Range { min: 0.0, max: LARGEST, whole: false, unit: "" });
        self.close(section, &["values", "weights"]);
        let values = values??;
        let weights = weights.unwrap_or_else(|| Some(vec![1.0; values.len()]))?;
        let problem = if values.is_empty() || values.len() > MOST_VALUES {
            format!("has {} values", values.len())
        } else if weights.len() != values.len() {
            format!("has {} values and {} weights", values.len(), weights.len())
        } else if weights.iter().sum::<f64>() <= 0.0 {
            "has weights that sum to 0".to_owned()
        } else {
            return Some(Distribution::Choice { values, weights });
        };
        let remedy = format!("give 1 to {MOST_VALUES} values, and as many weights, not all 0, or none");
        self.walk.fault(node.place, path, problem, remedy);
        None
    }

    fn truncated(&mut self, node: &Node, path: &str) -> Option<Distribution> {
        let range = self.range;
        let mut section = self.walk.section(node, path);
        let bound = |reader: &mut Self, section: &mut Section, name: &str, otherwise: f64| match section
            .take(reader.walk, name)
        {
            Some(bound) => reader.walk.number_in(bound, &section.path_of(name), range),
            None => Some(otherwise),
        };
        let min = bound(self, &mut section, "min", range.min);
        let max = bound(self, &mut section, "max", range.max);
        let inner = section.take(self.walk, "of");
        self.close(section, &["of", "min", "max"]);
        let Some(inner) = inner else {
            self.walk.fault(node.place, path, "has no `of`", "give the distribution to truncate");
            return None;
        };
        let wide = Range { min: -LARGEST, max: LARGEST, ..range };
        let of = Reader { walk: &mut *self.walk, range: wide }.distribution(inner, &format!("{path}.of"), true);
        let (min, max) = self.ordered(node, path, min?, max?)?;
        Some(Distribution::Truncated { of: Box::new(of?), min, max })
    }

    /// The number `name` of `section` from `min` up.
    fn argument(&mut self, section: &mut Section, node: &Node, name: &str, min: f64) -> Option<f64> {
        let path = section.path_of(name);
        let range = Range { min, max: LARGEST, whole: false, unit: self.range.unit };
        match section.take(self.walk, name) {
            Some(argument) => self.walk.number_in(argument, &path, range),
            None => {
                self.walk.fault(node.place, &path, "is missing", format!("give {range}"));
                None
            }
        }
    }

    /// The list `name` of `section`: `None` where there is none, `Some(None)` where it is at fault.
    fn list(&mut self, section: &mut Section, name: &str, range: Range) -> Option<Option<Vec<f64>>> {
        let path = section.path_of(name);
        let node = section.take(self.walk, name)?;
        let Value::List(entries) = &node.value else {
            self.walk.fault(
                node.place,
                &path,
                format!("is {}", node.value.kind()),
                format!("give a list, each {range}"),
            );
            return Some(None);
        };
        let numbers: Vec<_> = entries.iter().map(|entry| self.walk.number_in(entry, &path, range)).collect();
        Some(numbers.into_iter().collect())
    }

    fn close(&mut self, section: Section, known: &[&str]) {
        section.close(self.walk, known, &|_| None);
    }
}
