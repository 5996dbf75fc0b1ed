//! The fitted recipe's text, with the lines that the fit changed.

use drawing::html::format::counted;
use maud::{Markup, html};

/// Most pairs of lines that are compared.
const MOST_PAIRS: usize = 4_000_000;

/// A line of one text or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TextLine<'a> {
    Same(&'a str),
    Old(&'a str),
    New(&'a str),
}

/// The section.
pub(super) fn section(before: &str, after: &str) -> Markup {
    let lines = difference(before, after);
    let new = lines.iter().filter(|line| matches!(line, TextLine::New(_))).count();
    let old = lines.iter().filter(|line| matches!(line, TextLine::Old(_))).count();
    html! {
        details {
            summary {
                "The fitted recipe "
                small {
                    (counted(new, "line")) " new, marked +; \
                        " (counted(old, "line")) " of the recipe as it was, marked \u{2212}"
                }
            }
            pre.scroll.recipe tabindex="0" {
                @for line in &lines {
                    @match line {
                        TextLine::Same(text) => span { (text) "\n" },
                        TextLine::Old(text) => del { (text) "\n" },
                        TextLine::New(text) => ins { (text) "\n" },
                    }
                }
            }
        }
    }
}

/// Lines of both texts in order, as few of them changed as can be; where texts are too long for that, all between their
/// common beginning and end.
fn difference<'a>(before: &'a str, after: &'a str) -> Vec<TextLine<'a>> {
    let (old, new): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    let head = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let tail = old[head..].iter().rev().zip(new[head..].iter().rev()).take_while(|(a, b)| a == b).count();
    let (a, b) = (&old[head..old.len() - tail], &new[head..new.len() - tail]);
    let mut lines: Vec<TextLine> = old[..head].iter().map(|line| TextLine::Same(line)).collect();
    if a.len().saturating_mul(b.len()) > MOST_PAIRS {
        lines.extend(a.iter().map(|line| TextLine::Old(line)));
        lines.extend(b.iter().map(|line| TextLine::New(line)));
    } else {
        // common[i][j]: lines that a[i..] and b[j..] have in common.
        let wide = b.len() + 1;
        let mut common = vec![0_u32; (a.len() + 1) * wide];
        for i in (0..a.len()).rev() {
            for j in (0..b.len()).rev() {
                common[i * wide + j] = if a[i] == b[j] {
                    common[(i + 1) * wide + j + 1] + 1
                } else {
                    common[(i + 1) * wide + j].max(common[i * wide + j + 1])
                };
            }
        }
        let (mut i, mut j) = (0, 0);
        while i < a.len() || j < b.len() {
            if i < a.len() && j < b.len() && a[i] == b[j] {
                lines.push(TextLine::Same(a[i]));
                (i, j) = (i + 1, j + 1);
            } else if j == b.len() || (i < a.len() && common[(i + 1) * wide + j] >= common[i * wide + j + 1]) {
                lines.push(TextLine::Old(a[i]));
                i += 1;
            } else {
                lines.push(TextLine::New(b[j]));
                j += 1;
            }
        }
    }
    lines.extend(old[old.len() - tail..].iter().map(|line| TextLine::Same(line)));
    lines
}

#[cfg(test)]
mod tests {
    use super::TextLine::{New, Old, Same};
    use super::*;

    /// Changed lines stand where they belong, and both texts come out whole.
    #[test]
    fn lines_are_told_apart() {
        let (before, after) = ("a\nb\nc\nd\n", "head\na\nB\nc\nd\n");
        assert_eq!(difference(before, after), [New("head"), Same("a"), Old("b"), New("B"), Same("c"), Same("d")]);
        assert_eq!(difference("", "x"), [New("x")]);
        assert_eq!(difference("x\ny", "x\ny\n"), [Same("x"), Same("y")]);
        let long = |n: usize, word: &str| (0..n).map(|i| format!("{word}{i}\n")).collect::<String>();
        for (before, after) in [(before.to_owned(), after.to_owned()), (long(2500, "a"), long(2500, "b"))] {
            let lines = difference(&before, &after);
            let old: Vec<&str> =
                lines.iter().filter_map(|l| if let Same(t) | Old(t) = l { Some(*t) } else { None }).collect();
            let new: Vec<&str> =
                lines.iter().filter_map(|l| if let Same(t) | New(t) = l { Some(*t) } else { None }).collect();
            assert!(old == before.lines().collect::<Vec<_>>() && new == after.lines().collect::<Vec<_>>());
        }
    }
}
