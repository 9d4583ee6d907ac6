//! A stream of bytes that are made piece by piece, so that no more than one piece is in memory.

use std::io::{self, Read};

/// Voxels of a piece.
pub(super) const PIECE: usize = 1 << 12;

/// The stream. `next` puts the following piece into an empty buffer, and nothing at the end.
pub(super) struct Pieces<F> {
    next: F,
    piece: Vec<u8>,
    read: usize,
}

impl<F: FnMut(&mut Vec<u8>) -> io::Result<()>> Pieces<F> {
    pub(super) fn new(next: F) -> Self {
        Self { next, piece: Vec::new(), read: 0 }
    }
}

impl<F: FnMut(&mut Vec<u8>) -> io::Result<()>> Read for Pieces<F> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.read == self.piece.len() {
            self.piece.clear();
            self.read = 0;
            (self.next)(&mut self.piece)?;
        }
        let count = out.len().min(self.piece.len() - self.read);
        out[..count].copy_from_slice(&self.piece[self.read..self.read + count]);
        self.read += count;
        Ok(count)
    }
}
