//! Formatting of numbers and counts.

/// Sign of negative numbers; a hyphen alone stands for no number.
const MINUS: &str = "\u{2212}";

/// A number with about four digits that count; a dash for none.
pub(super) fn number(value: f64) -> String {
    digits(value, 4)
}

/// The same with three digits.
pub(super) fn short(value: f64) -> String {
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
pub(super) fn ends([low, _, high]: [f64; 3]) -> String {
    format!("{} to {}", short(low), short(high))
}

/// A unit as it stands behind a number: none for pure numbers.
pub(super) fn behind(unit: &str) -> String {
    if unit == "1" || unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// A distance with its sign; a dash for none.
pub(super) fn signed(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_finite() && value.abs() < 1000.0 => format!("{value:+.1}").replace('-', MINUS),
        Some(value) if value > 0.0 => "> +1000".into(),
        Some(value) if value < 0.0 => format!("< {MINUS}1000"),
        _ => "-".into(),
    }
}

/// A count with its noun.
pub(super) fn counted(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

/// Words as a list: `a, b and c`.
pub(super) fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
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
}
