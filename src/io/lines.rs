//! From bytes to lines.

/// Where the lines of a text begin, so that its places are found without reading it again.
pub(super) struct Lines(Vec<usize>);

impl Lines {
    pub(super) fn new(text: &str) -> Self {
        Self(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(k, _)| k).collect())
    }

    /// The line (from 1) of byte `byte`.
    pub(super) fn of(&self, byte: usize) -> usize {
        1 + self.0.partition_point(|end| *end < byte)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_with_its_break() {
        let lines = Lines::new("ab\n\nc");
        assert_eq!([0, 2, 3, 4, 9].map(|byte| lines.of(byte)), [1, 1, 2, 3, 3]);
    }
}
