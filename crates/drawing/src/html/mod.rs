//! Pages of HTML for people: the frame of a page, the style of all, formats of numbers, and pictures within a page. A
//! page is one file that loads nothing; all text is escaped where it is put in.

pub mod format;
mod picture;

pub use picture::{ColourMap, MAP_LEVELS, colour_scale, data_url, hex, indexed_png, map_palette};

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Style of every page; names of classes that only one page has are styled beside that page.
const STYLE: &str = include_str!("page.css");
/// What a browser may load: what is in the page.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// A section: its identifier, its name and its content.
pub type PageSection = (&'static str, &'static str, Markup);

/// Frame of a page.
#[derive(Debug, Clone, Copy)]
pub struct HtmlPage<'a> {
    /// Title.
    pub title: &'a str,
    /// Style beside that of every page, in parts.
    pub style: &'a [&'a str],
    /// Script of the page, where it has one.
    pub script: Option<&'a str>,
}

impl HtmlPage<'_> {
    /// The page around its body.
    pub fn around(&self, body: Markup) -> Markup {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy"
                        content={ (POLICY) @if self.script.is_some() { "; script-src 'unsafe-inline'" } };
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    link rel="icon" href="data:,";
                    style { (PreEscaped(STYLE)) @for part in self.style { (PreEscaped(part)) } }
                }
                body {
                    (body)
                    @if let Some(script) = self.script { script { (PreEscaped(script)) } }
                }
            }
        }
    }
}

/// A header, links to sections, what comes before these, the sections, and where the page comes from.
pub fn sections(header: Markup, before: Markup, sections: &[PageSection], origin: &str) -> Markup {
    html! {
        (header)
        nav aria-label="Sections" { @for (id, name, _) in sections { a href={ "#" (id) } { (name) } } }
        main {
            (before)
            @for (id, name, content) in sections {
                section id=(id) aria-labelledby={ (id) "-title" } {
                    h2 id={ (id) "-title" } { (name) }
                    (content)
                }
            }
        }
        footer {
            p { "Made by gen " (env!("CARGO_PKG_VERSION")) (origin) ". Nothing on this page comes from a network." }
        }
    }
}
