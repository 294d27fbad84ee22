//! Tables as text: entries parted by commas, semicolons or tabs, in quotes where they need them (RFC 4180).

use std::borrow::Cow;

/// A row and the line (from 1) on which it begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Record {
    pub(super) line: usize,
    pub(super) entries: Vec<String>,
}

/// The rows of `text` that are not blank. What parts the entries shows in the first row: a semicolon or a tab that is
/// in no quotes, or else commas. Entries in quotes are as they are, others without the blanks around them.
///
/// # Errors
/// The line of a quote that is never closed.
pub(super) fn records(text: &str) -> Result<Vec<Record>, usize> {
    let (separator, mut line) = match text.split_once('\n') {
        // How spreadsheets say it.
        Some((first, _)) if first.trim_end().len() == 5 && first.starts_with("sep=") => {
            (first.chars().nth(4).unwrap_or(','), 2)
        }
        _ => (separator(text), 1),
    };
    let body = if line == 2 { text.split_once('\n').map_or("", |(_, rest)| rest) } else { text };
    let mut records = Vec::new();
    let mut chars = body.chars().peekable();
    while chars.peek().is_some() {
        let mut record = Record { line, entries: Vec::new() };
        let mut blank = true;
        loop {
            while chars.next_if(|c| c.is_whitespace() && *c != '\n' && *c != separator).is_some() {}
            let mut entry = String::new();
            if chars.next_if_eq(&'"').is_some() {
                blank = false;
                let begun = line;
                loop {
                    match chars.next() {
                        None => return Err(begun),
                        Some('"') if chars.next_if_eq(&'"').is_some() => entry.push('"'),
                        Some('"') => break,
                        Some(c) => {
                            line += usize::from(c == '\n');
                            entry.push(c);
                        }
                    }
                }
            }
            let mut rest = String::new();
            while let Some(c) = chars.next_if(|c| *c != separator && *c != '\n') {
                rest.push(c);
            }
            blank &= rest.trim().is_empty();
            entry += rest.trim_end();
            record.entries.push(entry);
            if chars.next_if_eq(&separator).is_none() {
                break;
            }
        }
        chars.next();
        line += 1;
        if !blank || record.entries.len() > 1 {
            records.push(record);
        }
    }
    Ok(records)
}

fn separator(text: &str) -> char {
    let mut quoted = false;
    let outside: String = text
        .trim_start()
        .chars()
        .take_while(|c| *c != '\n')
        .filter(|c| {
            quoted ^= *c == '"';
            !quoted
        })
        .collect();
    [';', '\t'].into_iter().find(|s| outside.contains(*s)).unwrap_or(',')
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
