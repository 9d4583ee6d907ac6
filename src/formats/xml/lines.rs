//! Counts the line ends of a text while it is read.

use std::io::{self, BufRead, Read};

/// A text, and how many of its line ends have passed.
pub(super) struct Lines<R> {
    inner: R,
    /// Line ends that have passed.
    pub(super) passed: usize,
    /// Those since the last byte that is no blank.
    pub(super) trailing: usize,
}

impl<R> Lines<R> {
    /// At the start of a text.
    pub(super) fn new(inner: R) -> Self {
        Self { inner, passed: 0, trailing: 0 }
    }
}

impl<R: BufRead> Read for Lines<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.inner.read(out)
    }
}

impl<R: BufRead> BufRead for Lines<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        let passed = self.inner.fill_buf().unwrap_or_default();
        let passed = &passed[..amount.min(passed.len())];
        let ends = |part: &[u8]| part.iter().fold(0, |sum, b| sum + usize::from(*b == b'\n'));
        let all = ends(passed);
        self.passed += all;
        match passed.iter().rposition(|b| !b.is_ascii_whitespace()) {
            Some(last) => self.trailing = ends(&passed[last..]),
            None => self.trailing += all,
        }
        self.inner.consume(amount);
    }
}
