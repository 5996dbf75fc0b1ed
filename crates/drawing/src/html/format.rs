//! Formats of numbers, counts, shares, sizes, times and names.

use std::path::Path;

/// Sign of negative numbers; a hyphen alone stands for no number.
const MINUS: &str = "\u{2212}";

/// A number with about four digits that count; a dash for none.
pub fn number(value: f64) -> String {
    digits(value, 4)
}

/// The same with three digits.
pub fn short(value: f64) -> String {
    digits(value, 3)
}

fn digits(value: f64, count: i32) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    let sign = if value < 0.0 { MINUS } else { "" };
    if !(1e-4..1e6).contains(&size) {
        return format!("{sign}{size:.*e}", (count - 1).max(0) as usize);
    }
    let digits = (count - 1 - libm::floor(libm::log10(size)) as i32).clamp(0, 8) as usize;
    let text = format!("{size:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{sign}{text}")
}

/// From the first to the last of three quantiles.
pub fn ends([low, _, high]: [f64; 3]) -> String {
    format!("{} to {}", short(low), short(high))
}

/// A unit as it stands behind a number: none for pure numbers.
pub fn behind(unit: &str) -> String {
    if unit == "1" || unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// A number with its unit; pure numbers have none.
pub fn with_unit(value: f64, unit: &str) -> String {
    number(value) + &behind(unit)
}

/// A distance with its sign; a dash for none.
pub fn signed(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_finite() && value.abs() < 1000.0 => format!("{value:+.1}").replace('-', MINUS),
        Some(value) if value > 0.0 => "> +1000".into(),
        Some(value) if value < 0.0 => format!("< {MINUS}1000"),
        _ => "-".into(),
    }
}

/// A count with its noun.
pub fn counted(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

/// Words as a list: `a, b and c`.
pub fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// A count with thin spaces between thousands.
pub fn count(n: u64) -> String {
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
pub fn percent(share: f64) -> String {
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
pub fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+,:@%=".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// A size [bytes].
pub fn bytes(n: f64) -> String {
    let units = [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    let unit = units.iter().find(|(_, size)| n >= *size);
    unit.map_or_else(|| format!("{n:.0} bytes"), |(unit, size)| format!("{:.1} {unit}", n / size))
}

/// A time [s].
pub fn time(s: f64) -> String {
    match s {
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        _ => format!("{:.1} days", s / 86400.0),
    }
}

/// A name of a class for people.
pub fn name(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers keep the digits that count, and none of those that do not; what is no number is a hyphen.
    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0", "0"),
            (1234.56, "1235", "1235"),
            (0.123_45, "0.1235", "0.123"),
            (40.0, "40", "40"),
            (-0.0625, "\u{2212}0.0625", "\u{2212}0.0625"),
            (-1.0e-5, "\u{2212}1.000e-5", "\u{2212}1.00e-5"),
            (f64::NAN, "-", "-"),
            (f64::NEG_INFINITY, "-", "-"),
        ];
        for (value, four, three) in cases {
            assert_eq!((number(value).as_str(), short(value).as_str()), (four, three));
        }
        assert_eq!(
            [Some(0.25), Some(-3.21), Some(1e7), Some(-1e7), None].map(signed),
            ["+0.2", "\u{2212}3.2", "> +1000", "< \u{2212}1000", "-"]
        );
        assert_eq!(list(&["a", "b", "c"].map(String::from)), "a, b and c");
    }

    /// Counts and shares are read at a glance.
    #[test]
    fn counts_and_shares_are_short() {
        assert_eq!(
            (count(1_234_567), with_unit(0.25, "mm"), with_unit(3.0, "1")),
            ("1\u{202f}234\u{202f}567".into(), "0.25 mm".into(), "3".into())
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
