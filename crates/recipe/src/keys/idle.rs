//! What is said of a key that has an effect beside some words of a setting alone, where another word is chosen.

/// A key that has no effect.
pub(crate) struct Idle {
    /// Path of the setting that it needs.
    pub path: &'static str,
    /// The word of it that is chosen.
    pub chosen: String,
    /// The words beside which the key would have an effect.
    pub words: Vec<&'static str>,
    /// How it is said.
    pub wording: Wording,
    /// What to do instead of what follows from the words.
    pub remedy: Option<&'static str>,
}

/// How it is said that a key has no effect.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Wording {
    /// Of a setting of a model, a method or an order.
    On,
    /// Of a setting of the same section.
    Beside,
    /// Of a parameter of the same section.
    OnPair,
    /// Of a parameter, with the path of the setting.
    While,
}

impl Idle {
    /// What is wrong with the key, and what to do.
    pub fn refusal(&self) -> (String, String) {
        let Self { path, chosen, words, wording, .. } = self;
        let key = path.rsplit_once('.').map_or(*path, |(_, key)| key);
        let any = words.join("` or `");
        let one = if let [_] = words.as_slice() { "that" } else { "one of them" };
        let (problem, remedy) = match wording {
            Wording::On => {
                let give = if let [word] = words.as_slice() { format!("`{key}: {word}`") } else { one.to_owned() };
                let remedy = format!("it is for {key} `{any}`: give {give}, or remove it");
                (format!("has no effect on {key} `{chosen}`"), remedy)
            }
            Wording::Beside => {
                let remedy = format!("it is for `{key}: {any}`: give {one}, or remove it");
                (format!("has no effect beside `{key}: {chosen}`"), remedy)
            }
            Wording::OnPair => {
                let any = words.join(&format!("` or `{key}: "));
                let remedy = format!("it is for `{key}: {any}`: give that, or remove it");
                (format!("has no effect on `{key}: {chosen}`"), remedy)
            }
            Wording::While => {
                let remedy = format!("give `{any}` there, or remove it");
                (format!("has no effect while `{path}` is `{chosen}`"), remedy)
            }
        };
        (problem, self.remedy.map_or(remedy, str::to_owned))
    }
}
