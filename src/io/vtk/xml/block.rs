//! The bytes of one VTK data array: header words, base64 or raw, compressed by zlib or not.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent).with_decode_allow_trailing_bits(true),
);

/// How a file encodes its arrays.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Encoding {
    /// Whether the least significant byte comes first.
    pub(crate) little: bool,
    /// The bytes of a header word: 4 or 8.
    pub(crate) word: usize,
    /// Whether arrays are compressed by zlib.
    pub(crate) zlib: bool,
}

/// Encoded bytes, from the start of an array on.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source<'a> {
    /// As they are.
    Raw(&'a [u8]),
    /// In base64.
    Base64(&'a [u8]),
}

impl<'a> Source<'a> {
    /// The next `count` bytes, which were encoded together.
    fn take(&mut self, count: usize) -> Result<Cow<'a, [u8]>, String> {
        let short = |has: usize| format!("{has} bytes where {count} should be");
        match self {
            Self::Raw(rest) => {
                let (now, later) = rest.split_at_checked(count).ok_or_else(|| short(rest.len()))?;
                *rest = later;
                Ok(Cow::Borrowed(now))
            }
            Self::Base64(rest) => {
                let characters = count.div_ceil(3).saturating_mul(4);
                let (now, later) = rest.split_at_checked(characters).ok_or_else(|| short(rest.len() / 4 * 3))?;
                let mut bytes = BASE64.decode(now).map_err(|e| format!("not base64: {e}"))?;
                if bytes.len() < count {
                    return Err(short(bytes.len()));
                }
                bytes.truncate(count);
                *rest = later;
                Ok(Cow::Owned(bytes))
            }
        }
    }

    /// Whether the base64 text is padded within the characters of the first `count` bytes: they were encoded alone.
    fn is_padded(&self, count: usize) -> bool {
        match self {
            Self::Raw(_) => true,
            Self::Base64(rest) => {
                let padding = rest.iter().take(count.div_ceil(3) * 4).filter(|b| **b == b'=').count();
                padding == count.div_ceil(3) * 3 - count
            }
        }
    }
}

impl Encoding {
    /// The bytes of an array, the first `limit` of them: some programs write more values than there are points.
    pub(crate) fn bytes(self, mut source: Source<'_>, limit: usize) -> Result<Cow<'_, [u8]>, String> {
        if self.zlib { self.inflate(source, limit) } else { self.plain(&mut source, limit) }
    }

    fn plain<'a>(self, source: &mut Source<'a>, limit: usize) -> Result<Cow<'a, [u8]>, String> {
        let alone = source.is_padded(self.word);
        let mut ahead = *source;
        let count = self.words(&ahead.take(self.word)?)[0];
        let count = usize::try_from(count).map_or(limit, |count| count.min(limit));
        if alone {
            return ahead.take(count);
        }
        // Header and data were encoded together.
        let mut both = source.take(self.word + count)?.into_owned();
        both.drain(..self.word);
        Ok(Cow::Owned(both))
    }

    fn inflate(self, mut source: Source<'_>, limit: usize) -> Result<Cow<'_, [u8]>, String> {
        let mut ahead = source;
        let blocks = self.words(&ahead.take(self.word)?)[0];
        if blocks == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let header = usize::try_from(blocks).ok().and_then(|n| n.checked_add(3)?.checked_mul(self.word));
        let header = source.take(header.ok_or_else(|| format!("{blocks} blocks announced"))?)?;
        let words = self.words(&header);
        let [_, size, last, packed @ ..] = &words[..] else { return Err("a header without sizes".into()) };
        let (size, last) = (*size, *last);
        let total = packed.iter().try_fold(0_usize, |sum, n| sum.checked_add(usize::try_from(*n).ok()?));
        let data = source.take(total.ok_or("compressed blocks too large")?)?;
        let mut rest = &data[..];
        let mut out = Vec::new();
        for (n, count) in packed.iter().enumerate() {
            let (block, later) = rest.split_at_checked(*count as usize).ok_or("blocks run over the data")?;
            rest = later;
            let expected = if n + 1 == packed.len() && last > 0 { last } else { size };
            let (before, room) = (out.len(), limit - out.len());
            // One byte more than announced shows a block that is too long without unpacking all of it.
            let most = expected.saturating_add(1).min(room as u64);
            (flate2::read::ZlibDecoder::new(block).take(most).read_to_end(&mut out))
                .map_err(|e| format!("zlib block {n}: {e}"))?;
            if ((out.len() - before) as u64) < most.min(expected) || (out.len() - before) as u64 > expected {
                return Err(format!("zlib block {n} does not hold the {expected} bytes announced"));
            }
            if out.len() == limit {
                break;
            }
        }
        Ok(Cow::Owned(out))
    }

    fn words(self, bytes: &[u8]) -> Vec<u64> {
        let word = |bytes: &[u8]| {
            let digit = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
            if self.little { bytes.iter().rev().fold(0, digit) } else { bytes.iter().fold(0, digit) }
        };
        bytes.chunks_exact(self.word).map(word).collect()
    }
}
