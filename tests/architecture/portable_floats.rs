//! Purpose: nothing that decides a sample asks the system's mathematical library, whose last bits depend on the CPU.
//!
//! Addition, multiplication, division, square roots and rounding are exact everywhere; for the rest there are the crate
//! libm, `base::atan2`, `base::normal` and `lanes`.

use super::sources;

/// Functions of `f32` and `f64` that std hands on to the system, or may fuse; and those of glam that use them.
const SYSTEM: [&str; 35] = [
    "sin",
    "cos",
    "tan",
    "sin_cos",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "exp",
    "exp2",
    "exp_m1",
    "ln",
    "ln_1p",
    "log",
    "log2",
    "log10",
    "powf",
    "hypot",
    "cbrt",
    "mul_add",
    "gamma",
    "ln_gamma",
    "angle_between",
    "angle_to",
    "to_angle",
    "from_angle",
    "from_axis_angle",
    "rotate_towards",
    "slerp",
];
/// Names that stand for such functions elsewhere: an FFT that picks its instructions, and a ziggurat that asks exp and
/// ln.
const NAMES: [&str; 3] = ["FftPlanner:", "FftPlanner;", "rand_distr"];
/// What only draws, reports or checks a finished sample.
const AFTERWARDS: [&str; 4] =
    ["src/preview.rs", "src/cli", "crates/dataset/src/validate", "crates/evidence/reference/src/path/measure"];
/// What asks the system for `hypot` all the same: another function would change last bits of samples.
const ASKING: [&str; 2] = ["crates/recipe/src/keys/alternatives.rs", "crates/recipe/src/picture.rs"];

/// The calls of `text` outside of comments and of the tests at its end: line number and line.
fn faults(text: &str) -> Vec<(usize, &str)> {
    let own = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or(text);
    let calls = |line: &str| {
        let code = line.split("//").next().unwrap_or(line);
        let asks = |name: &&str| {
            ["f32::", "f64::", ".", "Vec2::", "Quat::"].iter().any(|owner| {
                let call = format!("{owner}{name}");
                code.match_indices(&call).any(|(at, _)| {
                    let next = code[at + call.len()..].chars().next();
                    let path = *owner != ".";
                    next == Some('(') || path && next.is_none_or(|c| !c.is_alphanumeric() && c != '_')
                })
            })
        };
        SYSTEM.iter().any(asks) || NAMES.iter().any(|name| code.contains(name))
    };
    own.lines().enumerate().filter(|(_, line)| calls(line)).map(|(i, line)| (i + 1, line.trim())).collect()
}

#[test]
fn no_sample_depends_on_the_systems_mathematics() {
    let mut report = String::new();
    let mut asking = Vec::new();
    for (name, text) in ["src", "crates", "procedural/src"].into_iter().flat_map(sources) {
        let is_other = AFTERWARDS.iter().any(|after| name.starts_with(after));
        if is_other || name.ends_with("/tests.rs") || name.contains("/tests/") {
            continue;
        }
        let faults = faults(&text);
        if ASKING.contains(&name.as_str()) {
            asking.extend((!faults.is_empty()).then_some(name));
            continue;
        }
        faults.iter().for_each(|(line, code)| report += &format!("{name}:{line}: {code}\n"));
    }
    assert!(report.is_empty(), "use the crate libm instead:\n{report}");
    assert_eq!(asking.len(), ASKING.len(), "only {asking:?} ask it: take the others out of the list");
}

#[test]
fn the_search_finds_what_it_should() {
    for bad in
        ["let a = x.sin();", "a.atan2(b)", "v.map(f32::cos)", "f64::powf(a, b)", "x.ln ().exp()", "FftPlanner::new()"]
    {
        assert_eq!(faults(bad).len(), 1, "{bad}");
    }
    for good in
        ["libm::sin(x)", "x.sqrt() // x.sin()", "exp(x)", "x.sincere()", "let cos = a.cos;", "FftPlannerScalar::new()"]
    {
        assert_eq!(faults(good).len(), 0, "{good}");
    }
    assert_eq!(faults("a\n#[cfg(test)]\nmod tests {\nx.sin()").len(), 0);
}
