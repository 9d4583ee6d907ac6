//! Reads numbers of any type, width and byte order from the bytes of binary files.

/// A type of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberType {
    /// Floating point of 4 or 8 bytes.
    Real,
    /// Whole numbers with a sign.
    Signed,
    /// Whole numbers without a sign.
    Unsigned,
}

impl NumberType {
    /// The number that some bytes hold, the most significant byte first if `big`.
    pub(crate) fn value(self, bytes: &[u8], big: bool) -> f64 {
        let word = word(bytes, big);
        match self {
            Self::Real if bytes.len() == 4 => f64::from(f32::from_bits(word as u32)),
            Self::Real => f64::from_bits(word),
            Self::Signed => signed(word, bytes.len()) as f64,
            Self::Unsigned => word as f64,
        }
    }
}

/// The whole number without a sign that some bytes hold, the most significant byte first if `big`.
pub(crate) fn word(bytes: &[u8], big: bool) -> u64 {
    let join = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
    if big { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
}

/// The first place of some bytes in others.
pub(crate) fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
}

/// The whole number with a sign that a word of this many bytes holds.
pub(crate) fn signed(word: u64, bytes: usize) -> i64 {
    // Shifting up and down again carries the sign of a shorter number.
    let unused = 64 - 8 * bytes as u32;
    ((word << unused) as i64) >> unused
}
