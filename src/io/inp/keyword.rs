//! Keyword lines.

/// The keywords that are read and the parameters that Abaqus gives them; those in the second list say nothing
/// about nodes, elements or sets.
const KNOWN: [(&str, &[&str], &[&str]); 8] = [
    ("NODE", &["NSET", "SYSTEM", "INPUT"], &[]),
    ("ELEMENT", &["TYPE", "ELSET", "INPUT"], &["OFFSET", "SOLIDELEMENTNUMBERING"]),
    ("NSET", &["NSET", "ELSET", "GENERATE", "INSTANCE", "INPUT"], &["INTERNAL", "UNSORTED"]),
    ("ELSET", &["ELSET", "GENERATE", "INSTANCE", "INPUT"], &["INTERNAL", "UNSORTED"]),
    (
        "SURFACE",
        &["NAME", "TYPE", "COMBINE", "INSTANCE"],
        &[
            "INTERNAL",
            "CROP",
            "DEFINITION",
            "FILLETRADIUS",
            "MAXRATIO",
            "NOTHICK",
            "NOOFFSET",
            "REGIONTYPE",
            "TRIM",
            "LAMINATE",
        ],
    ),
    ("PART", &["NAME"], &["INTERNAL"]),
    ("INSTANCE", &["NAME", "PART"], &["INTERNAL"]),
    ("INCLUDE", &["INPUT"], &[]),
];

/// A keyword with its parameters.
pub(super) struct Keyword {
    /// In capitals, without blanks: `ENDPART`.
    pub(super) name: String,
    /// Names in capitals without blanks, values without their quotes.
    parameters: Vec<(String, String)>,
}

impl Keyword {
    /// The keyword of `line`, which is without its star.
    pub(super) fn parse(line: &str) -> Self {
        let mut words = fields(line).into_iter();
        let name = capitals(words.next().unwrap_or_default());
        let parameters = words.filter(|word| !word.is_empty()).map(|word| match word.split_once('=') {
            Some((key, value)) => (capitals(key), unquoted(value).to_owned()),
            None => (capitals(word), String::new()),
        });
        Self { name, parameters: parameters.collect() }
    }

    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// A parameter that this keyword is not known to have, and those that it has.
    pub(super) fn unknown(&self) -> Option<(&str, String)> {
        let (_, read, ignored) = KNOWN.iter().find(|(name, ..)| *name == self.name)?;
        let known = |key: &str| read.contains(&key) || ignored.contains(&key);
        let (key, _) = self.parameters.iter().find(|(key, _)| !known(key))?;
        Some((key, read.join(", ")))
    }
}

/// The fields of a line: commas part them, but not within quotes.
pub(super) fn fields(line: &str) -> Vec<&str> {
    let mut quoted = false;
    let part = |c: char| {
        quoted ^= c == '"';
        c == ',' && !quoted
    };
    line.split(part).map(str::trim).collect()
}

/// A name without its quotes.
pub(super) fn unquoted(name: &str) -> &str {
    let name = name.trim();
    name.strip_prefix('"').and_then(|n| n.strip_suffix('"')).unwrap_or(name)
}

fn capitals(word: &str) -> String {
    word.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_case_and_quotes() {
        let keyword = Keyword::parse("End  part , name = \"a, b\",generate");
        assert_eq!((keyword.name.as_str(), keyword.get("NAME")), ("ENDPART", Some("a, b")));
        assert!(keyword.has("GENERATE") && keyword.unknown().is_none());
        let (name, known) = ("FOO", "NSET, ELSET, GENERATE, INSTANCE, INPUT".to_owned());
        assert_eq!(Keyword::parse("Nset, nset=a, internal, foo=1").unknown(), Some((name, known)));
    }
}
