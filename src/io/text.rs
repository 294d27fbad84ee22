//! Bytes to text to numbers, with errors that say where.

use std::borrow::Cow;
use std::path::Path;

use super::mesh_file_error::{MAX_ID, MeshFileError, MeshFileErrorKind};
use super::{Location, input};

type Result<T> = std::result::Result<T, MeshFileError>;

/// The bytes of `file`, of which there is at least one.
pub(super) fn read_bytes(file: &Path) -> Result<Vec<u8>> {
    let bytes = input::read(file, input::MESH_BYTES).map_err(|e| {
        MeshFileError::new(Location::file(file), MeshFileErrorKind::Io { reason: e.to_string() })
    })?;
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(MeshFileError::new(Location::file(file), MeshFileErrorKind::Empty));
    }
    Ok(bytes)
}

/// `bytes` without a byte-order mark.
pub(super) fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// `bytes` as text; letters of old 8-bit encodings, as found in comments, become replacement marks.
pub(super) fn text<'a>(file: &Path, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    let bytes = without_bom(bytes);
    let control = |b: &u8| *b < 0x20 && !b.is_ascii_whitespace() && *b != 0x1A;
    match bytes.iter().position(control) {
        Some(at) => Err(MeshFileError::new(
            Location::file(file).at_byte(at),
            MeshFileErrorKind::BinaryAsText { value: bytes[at] },
        )),
        None => Ok(String::from_utf8_lossy(bytes)),
    }
}

/// Most characters of a file that a message shows.
const SHOWN: usize = 40;
/// Most names that a message lists.
const LISTED: usize = 20;

/// `word` as a message shows it: its beginning, without control characters.
pub(super) fn shown(word: &str) -> String {
    beginning(word, SHOWN)
}

fn beginning(word: &str, most: usize) -> String {
    let mut beginning: String =
        word.chars().map(|c| if c.is_control() { '?' } else { c }).take(most).collect();
    if word.chars().nth(most).is_some() {
        beginning += "...";
    }
    beginning
}

/// `names` as a message lists them: the first few, and how many more there are.
pub(super) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut names = names.map(|name| beginning(name, 3 * SHOWN));
    let mut listed = names.by_ref().take(LISTED).collect::<Vec<_>>().join(", ");
    match names.count() {
        0 if listed.is_empty() => listed += "none",
        0 => {}
        more => listed += &format!(" and {more} more"),
    }
    listed
}

/// The finite number that `token` means.
pub(super) fn number(token: &str, at: impl FnOnce() -> Location) -> Result<f64> {
    let parse = |t: &str| t.parse::<f64>().ok().or_else(|| t.replace(['d', 'D'], "e").parse().ok());
    let value = || shown(token);
    let kind = match parse(token) {
        Some(number) if number.is_finite() => return Ok(number),
        Some(_) => MeshFileErrorKind::NotFinite { value: value() },
        None => {
            let fixed = token.replacen(',', ".", 1);
            if fixed != token && parse(&fixed).is_some() {
                MeshFileErrorKind::DecimalComma { value: value(), fixed }
            } else {
                MeshFileErrorKind::NotANumber { value: value(), expected: "a decimal number" }
            }
        }
    };
    Err(MeshFileError::new(at(), kind))
}

/// The whole number that `token` means.
pub(super) fn integer(token: &str, at: impl FnOnce() -> Location) -> Result<i128> {
    token.parse().map_err(|_| {
        let kind = MeshFileErrorKind::NotANumber { value: shown(token), expected: "a whole number" };
        MeshFileError::new(at(), kind)
    })
}

/// The number of a `what` (node, element, ...) that `value` is.
pub(super) fn id(value: i128, what: &'static str, at: impl FnOnce() -> Location) -> Result<u64> {
    match u64::try_from(value) {
        Ok(id) if id <= MAX_ID => Ok(id),
        _ => Err(MeshFileError::new(at(), MeshFileErrorKind::BadId { what, value: value.to_string() })),
    }
}

/// The count of `what` that `value` declares, refused when the `bytes` left could not hold it.
pub(super) fn count(
    value: i128,
    what: &str,
    bytes: usize,
    bytes_each: usize,
    at: impl FnOnce() -> Location,
) -> Result<usize> {
    let most = bytes / bytes_each.max(1) + 1;
    match usize::try_from(value) {
        Ok(count) if count <= most => Ok(count),
        Err(_) if value < 0 => {
            let expected = "a count of 0 or more";
            let kind = MeshFileErrorKind::NotANumber { value: value.to_string(), expected };
            Err(MeshFileError::new(at(), kind))
        }
        _ => {
            let declared = u64::try_from(value).unwrap_or(u64::MAX);
            let kind =
                MeshFileErrorKind::DeclaredTooMany { what: what.to_owned(), declared, most: most as u64 };
            Err(MeshFileError::new(at(), kind))
        }
    }
}
