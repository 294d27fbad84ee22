//! Tables as text: entries parted by commas, semicolons or tabs, in quotes where they need them (RFC 4180).

use std::borrow::Cow;
use std::iter::Peekable;
use std::str::Chars;

/// A row and the line (from 1) on which it begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Record {
    pub(super) line: usize,
    pub(super) entries: Vec<String>,
}

/// The rows of `text` that are not blank, all of them; see [`rows`].
///
/// # Errors
/// The line of a quote that is never closed.
pub(super) fn records(text: &str) -> Result<Vec<Record>, usize> {
    rows(text).collect()
}

/// The rows of `text` that are not blank, one after the other. What parts the entries shows in the first row that has
/// any: a semicolon or a tab that is in no quotes, or else commas. Entries in quotes are as they are, others without the
/// blanks around them. A quote that is never closed gives its line, and ends the rows.
pub(super) fn rows(text: &str) -> Rows<'_> {
    match text.split_once('\n') {
        // How spreadsheets say it.
        Some((first, rest)) if first.trim_end().len() == 5 && first.starts_with("sep=") => {
            let separator = first.chars().nth(4).unwrap_or(',');
            Rows { chars: rest.chars().peekable(), line: 2, separator }
        }
        _ => Rows { chars: text.chars().peekable(), line: 1, separator: separator(text) },
    }
}

/// What [`rows`] gives.
pub(super) struct Rows<'a> {
    chars: Peekable<Chars<'a>>,
    line: usize,
    separator: char,
}

impl Iterator for Rows<'_> {
    type Item = Result<Record, usize>;

    fn next(&mut self) -> Option<Self::Item> {
        let Self { chars, line, separator } = self;
        while chars.peek().is_some() {
            let mut record = Record { line: *line, entries: Vec::new() };
            let mut blank = true;
            loop {
                while chars.next_if(|c| c.is_whitespace() && *c != '\n' && c != separator).is_some() {}
                let mut entry = String::new();
                if chars.next_if_eq(&'"').is_some() {
                    blank = false;
                    let begun = *line;
                    loop {
                        match chars.next() {
                            None => return Some(Err(begun)),
                            Some('"') if chars.next_if_eq(&'"').is_some() => entry.push('"'),
                            Some('"') => break,
                            Some(c) => {
                                *line += usize::from(c == '\n');
                                entry.push(c);
                            }
                        }
                    }
                }
                let mut rest = String::new();
                while let Some(c) = chars.next_if(|c| c != separator && *c != '\n') {
                    rest.push(c);
                }
                blank &= rest.trim().is_empty();
                entry += rest.trim_end();
                record.entries.push(entry);
                if chars.next_if_eq(separator).is_none() {
                    break;
                }
            }
            chars.next();
            *line += 1;
            if !blank || record.entries.len() > 1 {
                return Some(Ok(record));
            }
        }
        None
    }
}

fn separator(text: &str) -> char {
    let mut quoted = false;
    let mut outside = text.chars().filter(|c| {
        quoted ^= *c == '"';
        !quoted
    });
    loop {
        let mut found = [false; 3];
        let mut ended = true;
        for c in outside.by_ref() {
            if c == '\n' {
                ended = false;
                break;
            }
            for (found, s) in found.iter_mut().zip([';', '\t', ',']) {
                *found |= c == s;
            }
        }
        match found {
            [true, ..] => return ';',
            [_, true, _] => return '\t',
            [.., true] => return ',',
            _ if ended => return ',',
            _ => {}
        }
    }
}

/// `text` as an entry of a row parted by commas.
pub(super) fn entry(text: &str) -> Cow<'_, str> {
    if text.contains([',', ';', '\t', '"', '\n', '\r']) || text.trim() != text {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// The number that `entry` is, with a decimal point or, as where entries are parted by semicolons, a decimal comma.
pub(super) fn number(entry: &str) -> Option<f64> {
    let with_point = || match entry.matches(',').count() {
        1 if !entry.contains('.') => entry.replace(',', ".").parse().ok(),
        _ => None,
    };
    entry.parse().ok().or_else(with_point)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<(usize, Vec<String>)> {
        records(text).unwrap_or_default().into_iter().map(|r| (r.line, r.entries)).collect()
    }

    #[test]
    fn commas_semicolons_tabs_and_quotes() {
        for text in ["a,b\n1, 2 \r\n\n", "a;b\n1;2", "a\tb\n1\t2\n", "\"a\",\"b\"\n\"1\",2\n"] {
            let expected = vec![(1, vec!["a".into(), "b".into()]), (2, vec!["1".into(), "2".into()])];
            assert_eq!(rows(text), expected, "{text}");
        }
        assert_eq!(rows("sep=;\na;b\n")[0], (2, vec!["a".into(), "b".into()]));
        assert_eq!(
            rows("a;b\n\"x;\"\"y\"\"\nz\";\n1;2\n")[1..],
            [(2, vec!["x;\"y\"\nz".into(), String::new()]), (4, vec!["1".into(), "2".into()])]
        );
        assert_eq!(rows("zy\"g,b\n")[0].1, ["zy\"g", "b"]);
        assert_eq!(records("a,b\n1,\"2\n"), Err(2));
    }

    #[test]
    fn every_name_comes_back() {
        let names = ["plain", "a,b", "a;b", "\"", "a\"b", "a\nb", "a\r\nb", " a ", "a\\b", "\t", ""];
        let row: Vec<Cow<'_, str>> = names.iter().map(|name| entry(name)).collect();
        let text = format!("head,{}\n", vec!["x"; names.len() - 1].join(",")) + &row.join(",") + "\n";
        assert_eq!(rows(&text)[1].1, names);
    }

    #[test]
    fn decimal_commas() {
        let read = ["1.5", "1,5", "-2,5e3", "1,000,000", "1,000.5", "", "x"].map(number);
        assert_eq!(read, [Some(1.5), Some(1.5), Some(-2500.), None, None, None, None]);
    }
}
