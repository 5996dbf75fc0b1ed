//! The forms of distributions as people meet them: key, example, law and source.

/// One form.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    /// Its key.
    pub key: &'static str,
    /// How it is written.
    pub example: &'static str,
    /// What it draws.
    pub law: &'static str,
    /// Where it comes from.
    pub source: &'static str,
}

/// Every form; a plain number is the seventh.
pub(super) const FORMS: [Form; 6] = [
    Form {
        key: "uniform",
        example: "{uniform: [a, b]}",
        law: "p(x) = 1 / (b - a) on [a, b]; counts: every whole number of [a, b] with equal chance",
        source: "",
    },
    Form {
        key: "log_uniform",
        example: "{log_uniform: [a, b]}",
        law: "p(x) = 1 / (x ln(b / a)) on [a, b], 0 < a",
        source: "Hamming 1970",
    },
    Form {
        key: "normal",
        example: "{normal: {mean: m, sd: s}}",
        law: "p(x) = exp(-(x - m)^2 / 2 s^2) / (s sqrt(2 pi)), cut at 8 s",
        source: "Marsaglia and Tsang 2000",
    },
    Form {
        key: "lognormal",
        example: "{lognormal: {median: m, log_sd: s}}",
        law: "ln x is normal with mean ln m and standard deviation s, cut at 8 s",
        source: "Limpert, Stahel and Abbt 2001",
    },
    Form {
        key: "choice",
        example: "{choice: {values: [v, ...], weights: [w, ...]}}",
        law: "v_i with chance w_i / sum w; without weights all alike",
        source: "",
    },
    Form {
        key: "truncated",
        example: "{truncated: {of: {...}, min: a, max: b}}",
        law: "another form, drawn again until it lies in [a, b]; a missing end is the parameter's own",
        source: "",
    },
];

/// The keys of [`FORMS`].
pub(super) fn keys() -> [&'static str; FORMS.len()] {
    FORMS.map(|form| form.key)
}
