//! Reads input files, packed by gzip or not: how large one may be, on the disk and unpacked, and its SHA-256.

use std::io::{self, BufRead, BufReader, Read, Sink, Write};
use std::path::{Component, Path, PathBuf};
use std::{cell::Cell, fs::File};

use flate2::read::MultiGzDecoder;
use sha2::{Digest, Sha256};

use super::{ensure, open_regular};
use willis_core::error::{Error, Fault, Result};

/// How many first bytes of a file are looked at to find its format.
pub(crate) const HEAD: u64 = 1 << 16;

/// The largest input file without another limit: 2 GiB.
pub const MAX_INPUT: u64 = 2 << 30;
/// A file may unpack to at most this many times its size, and always to [`SMALL`]. Coordinates and radii do not compress to a
/// hundredth; a file that does was made to fill the memory.
const MOST_INFLATION: u64 = 100;
const SMALL: u64 = 64 << 20;
const OPTION: &str = "`max_input` allows more";
/// Bytes.
const MIB: f64 = 1_048_576.0;
const GIB: f64 = 1_073_741_824.0;

/// Reads a number of bytes from a text such as `500MB`, `2GiB` or `100000`.
///
/// # Errors
///
/// The accepted form.
pub fn byte_count(text: &str) -> Result<u64, &'static str> {
    const ACCEPTED: &str = "expected a positive number of bytes, such as 500MB, 2GiB or 100000";
    const UNITS: [(&str, f64); 8] =
        [("", 1.0), ("B", 1.0), ("kB", 1e3), ("KiB", 1024.0), ("MB", 1e6), ("MiB", MIB), ("GB", 1e9), ("GiB", GIB)];
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = (&text[..end], text[end..].trim());
    let (_, factor) = UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit)).ok_or(ACCEPTED)?;
    let bytes = number.parse::<f64>().map_err(|_| ACCEPTED)? * factor;
    if (1.0..=9e15).contains(&bytes) { Ok(bytes as u64) } else { Err(ACCEPTED) }
}

/// A number of bytes for people.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_048_576 => format!("{bytes} bytes"),
        1_048_576..1_073_741_824 => format!("{:.1} MiB", bytes as f64 / MIB),
        _ => format!("{:.1} GiB", bytes as f64 / GIB),
    }
}

fn too_large(found: &str, most: u64, more: &str) -> Fault {
    Fault::file(found, format!("expected at most {}{more}", size(most)))
}

/// Opens a file that was named, a pipe too.
fn open_named(path: &Path) -> Result<File> {
    File::open(path).map_err(|source| Error::Read { path: path.to_owned(), source })
}

/// The length of an open file, which is at most `most`.
fn length_within(file: &File, path: &Path, most: u64, more: &str) -> Result<u64> {
    let length = file.metadata().map_err(|source| Error::Read { path: path.to_owned(), source })?.len();
    if length > most { Err(too_large(&size(length), most, more).in_file(path)) } else { Ok(length) }
}

/// All bytes of an open file that has at most `most`; `more` tells how to raise the limit, for the error.
fn all_of(file: File, path: &Path, most: u64, more: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(length_within(&file, path, most, more)? as usize);
    let read = file.take(most.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|source| Error::Read { path: path.to_owned(), source })?;
    ensure(bytes.len() as u64 <= most, || too_large(&format!("more than {}", size(most)), most, more).in_file(path))?;
    Ok(bytes)
}

/// All bytes of a file that nobody named, without the gzip around them; at most `most`.
///
/// # Errors
///
/// As [`open_regular`]; it is damaged, or has more bytes.
pub(crate) fn content_beside(path: &Path, most: u64) -> Result<Vec<u8>> {
    unpacked_file(bytes_beside(path, most)?, path, most)
}

/// All bytes of a file that nobody named; at most `most`.
///
/// # Errors
///
/// As [`open_regular`], or it is larger.
pub(crate) fn bytes_beside(path: &Path, most: u64) -> Result<Vec<u8>> {
    all_of(open_regular(path)?, path, most, &format!("; {OPTION}"))
}

/// As [`bytes_of`], of a file that nobody named.
///
/// # Errors
///
/// As [`open_regular`]; it is damaged, or has more than `MAX_INPUT` bytes.
pub fn regular_bytes_of(path: &Path) -> Result<Vec<u8>> {
    unpacked_file(all_of(open_regular(path)?, path, MAX_INPUT, "")?, path, MAX_INPUT)
}

/// A file that counts and hashes what is read of it, up to a limit.
pub(crate) struct LimitedFile {
    /// The file, with the sum of what was read.
    pub(crate) file: Checksummed<File>,
    most: u64,
    read: u64,
}

impl LimitedFile {
    /// Opens a file of at most `most` bytes.
    pub(crate) fn open(path: &Path, most: u64) -> Result<Self> {
        let file = open_named(path)?;
        length_within(&file, path, most, &format!("; {OPTION}"))?;
        Ok(Self { file: Checksummed::new(file), most, read: 0 })
    }
}

impl Read for LimitedFile {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(out)?;
        self.read += count as u64;
        // Only a plain file states its length in advance.
        if self.read > self.most {
            let found = format!("more than {}; {OPTION}", size(self.most));
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, found));
        }
        Ok(count)
    }
}

/// All bytes of a file that has at most `most`.
///
/// # Errors
///
/// The file cannot be read, or is larger.
pub(crate) fn bytes_within(path: &Path, most: u64) -> Result<Vec<u8>> {
    all_of(open_named(path)?, path, most, &format!("; {OPTION}"))
}

/// All bytes of a file, without the gzip around them.
///
/// # Errors
///
/// The file cannot be read, is damaged, or has more than `MAX_INPUT` bytes; the error names it.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    unpacked_file(all_of(open_named(path)?, path, MAX_INPUT, "")?, path, MAX_INPUT)
}

/// What a file holds as a stream, without the gzip around it, for those who need its beginning alone; a pipe is not read again.
///
/// # Errors
///
/// The file cannot be read.
pub(crate) fn stream_of(path: &Path) -> io::Result<Box<dyn BufRead>> {
    let mut file = BufReader::new(open_regular(path).map_err(io::Error::other)?);
    if is_gzip(file.fill_buf()?) { Ok(Box::new(BufReader::new(MultiGzDecoder::new(file)))) } else { Ok(Box::new(file)) }
}

/// Whether a file is packed by gzip.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b")
}

/// The bytes of the file `path` without the gzip around them, of which `most` are allowed.
///
/// # Errors
///
/// A damaged file, and one that unpacks to too much.
pub(crate) fn unpacked_file(bytes: Vec<u8>, path: &Path, most: u64) -> Result<Vec<u8>> {
    if is_gzip(&bytes) { unpacked(&bytes, most).map_err(|fault| fault.in_file(path)) } else { Ok(bytes) }
}

fn unpacked(bytes: &[u8], most: u64) -> Result<Vec<u8>, Fault> {
    let limit = UnpackLimit::of(bytes.len(), most);
    let mut content = Vec::new();
    let read = MultiGzDecoder::new(bytes).take(limit.left() as u64 + 1).read_to_end(&mut content);
    read.map_err(|error| Fault::file(format!("damaged gzip: {error}"), "expected a whole file"))?;
    limit.take(content.len()).map_err(|(found, accepted)| Fault::file(found, accepted))?;
    Ok(content)
}

/// The first bytes of a file after gzip, at most `most`; the first bytes themselves where it is not packed.
pub(crate) fn unpacked_head(bytes: &[u8], most: usize) -> Vec<u8> {
    if !is_gzip(bytes) {
        return bytes[..bytes.len().min(most)].to_vec();
    }
    let mut head = Vec::new();
    // What is damaged is said by whoever reads all of it.
    let _ = MultiGzDecoder::new(bytes).take(most as u64).read_to_end(&mut head);
    head
}

/// The name that a packed file has without gzip: `a.swc` for `a.swc.gz`.
pub(crate) fn unpacked_name(path: &Path) -> PathBuf {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz")) {
        path.with_extension("")
    } else {
        path.to_owned()
    }
}

/// The file called `name` in the folder of `path`; nothing for a name that leads out of it.
pub(crate) fn beside(path: &Path, name: &str) -> Option<PathBuf> {
    let mut parts = Path::new(name.strip_prefix("./").unwrap_or(name)).components();
    if let (Some(Component::Normal(name)), None) = (parts.next(), parts.next()) { Some(path.with_file_name(name)) } else { None }
}

/// A limit on how much the compressed parts of a file may unpack to, all together.
#[derive(Debug)]
pub struct UnpackLimit {
    most: u64,
    left: Cell<u64>,
    accepted: &'static str,
}

impl UnpackLimit {
    /// The limit for a file of this size, where `most` bytes are allowed.
    pub fn of(file: usize, most: u64) -> Self {
        let usual = SMALL.max((file as u64).saturating_mul(MOST_INFLATION));
        let accepted = if most <= usual { OPTION } else { "expected centerlines, which do not compress to a hundredth" };
        let most = most.min(usual);
        Self { most, left: Cell::new(most), accepted }
    }

    /// How many more bytes may be unpacked.
    pub fn left(&self) -> usize {
        usize::try_from(self.left.get()).unwrap_or(usize::MAX)
    }

    /// Counts bytes against the limit.
    ///
    /// # Errors
    ///
    /// Beyond it, what was found and what is accepted.
    pub fn take(&self, bytes: usize) -> Result<(), (String, &'static str)> {
        let left = self.left.get().checked_sub(bytes as u64);
        self.left.set(left.ok_or_else(|| (format!("more than {} unpacked", size(self.most)), self.accepted))?);
        Ok(())
    }
}

/// The SHA-256 of some bytes in hexadecimal digits.
pub fn checksum(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// The [`checksum`] of what `fill` writes, without holding it in memory.
///
/// # Errors
///
/// Those of `fill`.
pub fn checksum_of(fill: impl FnOnce(&mut Checksummed<Sink>) -> io::Result<()>) -> io::Result<String> {
    let mut summed = Checksummed::new(io::sink());
    fill(&mut summed)?;
    Ok(summed.finish())
}

/// The [`checksum`] of a file of any size; not of a pipe, which could be read only once.
///
/// # Errors
///
/// As [`open_regular`]; the file cannot be read.
pub fn checksum_of_file(path: &Path) -> Result<String> {
    let mut file = open_regular(path)?;
    let read = checksum_of(|out| io::copy(&mut file, out).map(drop));
    read.map_err(|source| Error::Read { path: path.to_owned(), source })
}

fn hexadecimal(bytes: &[u8]) -> String {
    let digits = |byte: &u8| [byte >> 4, byte & 15].map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)]));
    bytes.iter().flat_map(digits).collect()
}

/// Passes reads and writes on to a file and computes their [`checksum`].
pub struct Checksummed<F> {
    file: F,
    sum: Sha256,
}

impl<F> Checksummed<F> {
    /// Reads from `file`, or writes to it.
    pub fn new(file: F) -> Self {
        Self { file, sum: Sha256::new() }
    }

    /// The checksum of all that was read and written.
    pub fn finish(self) -> String {
        hexadecimal(&self.sum.finalize())
    }
}

impl<W: Write> Write for Checksummed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl<R: Read> Read for Checksummed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(bytes)?;
        self.sum.update(&bytes[..read]);
        Ok(read)
    }
}

/// The bytes after a byte order mark.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Refuses a text of two bytes a character, which its mark tells.
pub(crate) fn refuse_utf16(bytes: &[u8]) -> Result<(), Fault> {
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    if is_utf16 { Err(Fault::file("the text is UTF-16", "expected UTF-8; save the file as UTF-8")) } else { Ok(()) }
}
