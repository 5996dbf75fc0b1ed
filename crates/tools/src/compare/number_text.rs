//! Lines of numbers as text: separators, fields, what stands for a missing number.

/// What is wrong, and what to do.
pub(super) type Refusal = (String, &'static str);

/// How fields of a line are divided.
#[derive(Debug, Clone, Copy)]
pub(super) enum Separator {
    Sign(char),
    Blanks,
}

impl Separator {
    pub(super) fn of(line: &str) -> Self {
        ['\t', ';', ','].into_iter().find(|sign| line.contains(*sign)).map_or(Self::Blanks, Self::Sign)
    }

    pub(super) fn fields(self, line: &str) -> impl Iterator<Item = &str> {
        let (signs, blanks) = match self {
            Self::Sign(sign) => (Some(line.split(sign)), None),
            Self::Blanks => (None, Some(line.split_whitespace())),
        };
        let fields = signs.into_iter().flatten().chain(blanks.into_iter().flatten());
        fields.map(|field| field.trim().trim_matches('"').trim())
    }
}

/// A field as a fault shows it.
pub(super) fn shown(field: &str) -> String {
    field.chars().take(24).collect::<String>().escape_debug().to_string()
}

/// A number; NaN where it is missing, `None` where the field is something else.
pub(super) fn number(field: &str) -> Option<f64> {
    if field.is_empty() || ["nan", "na", "null"].iter().any(|word| field.eq_ignore_ascii_case(word)) {
        return Some(f64::NAN);
    }
    field.parse().ok()
}
