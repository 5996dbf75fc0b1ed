//! Formatting of numbers, sizes, times and paths.

use std::path::Path;

/// A number with about four digits that count.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size >= 1000.0 { 0 } else { (3 - libm::floor(libm::log10(size)) as i32).clamp(0, 6) as usize };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// A number with its unit; pure numbers have none.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    match unit {
        "1" | "" => number(value),
        unit => format!("{} {unit}", number(value)),
    }
}

/// A count with thin spaces between thousands.
pub(super) fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A share as per cent; what is no more than nearly all never reads as 100 %.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent.abs() {
        p if !p.is_finite() => "-".into(),
        0.0 => "0 %".into(),
        p if p < 0.01 => "< 0.01 %".into(),
        p if p < 1.0 => format!("{percent:.2} %"),
        p if (99.0..100.0).contains(&p) => {
            let short = (1..=4).map(|digits| format!("{percent:.digits$}")).find(|text| !text.contains("100"));
            short.map_or("> 99.9999 %".into(), |text| format!("{text} %"))
        }
        _ => format!("{percent:.1} %"),
    }
}

/// A path as a word of a command in a shell.
pub(super) fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+,:@%=".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// A size [bytes].
pub(super) fn bytes(n: f64) -> String {
    let units = [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    let unit = units.iter().find(|(_, size)| n >= *size);
    unit.map_or_else(|| format!("{n:.0} bytes"), |(unit, size)| format!("{:.1} {unit}", n / size))
}

/// A time [s].
pub(super) fn time(s: f64) -> String {
    match s {
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        _ => format!("{:.1} days", s / 86400.0),
    }
}

/// A name of a class for people.
pub(super) fn name(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers keep the digits that count, and none of those that do not.
    #[test]
    fn numbers_are_short() {
        let cases = [(0.0, "0"), (1234.56, "1235"), (0.12345, "0.1235"), (40.0, "40"), (-0.0625, "-0.0625")];
        cases.iter().for_each(|(value, text)| assert_eq!(number(*value), *text));
        assert_eq!(
            (number(f64::NAN), number(1.0e-5), count(1_234_567)),
            ("-".into(), "1.00e-5".into(), "1\u{202f}234\u{202f}567".into())
        );
        assert_eq!((percent(0.0), percent(0.00001), percent(0.25)), ("0 %".into(), "< 0.01 %".into(), "25.0 %".into()));
    }

    /// Only all of it is 100 %.
    #[test]
    fn nearly_all_is_not_all() {
        let cases = [(1.0, "100.0 %"), (0.9949, "99.5 %"), (0.9997, "99.97 %"), (0.99996, "99.996 %")];
        cases.iter().for_each(|(share, text)| assert_eq!(percent(*share), *text));
        assert_eq!(percent(1.0 - 1e-12), "> 99.9999 %");
    }

    /// A shell takes the word as one, whatever is in the path.
    #[test]
    fn paths_are_quoted() {
        let cases = [("out/planks", "out/planks"), ("my planks", "'my planks'"), ("it's; $x", "'it'\\''s; $x'")];
        cases.iter().for_each(|(path, text)| assert_eq!(shell_word(Path::new(path)), *text));
    }
}
