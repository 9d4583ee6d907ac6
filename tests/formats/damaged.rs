//! Damaged files of every format: each is read or refused in one line, and none makes the program panic.

use std::path::Path;

use crate::peers::{FILES, converted, read_first};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use willis::internals::formats::ReadOptions;
use willis::internals::formats::convert::Target;
use willis::internals::phantom::{cerebral, circle_of_willis};

/// Damages of each kind to each file.
const TIMES: usize = 12;

/// A file cut short, with bytes replaced, taken out or repeated, with one of its numbers replaced, and with other line ends and marks.
fn damaged(bytes: &[u8], rng: &mut ChaCha8Rng) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    let numbers: Vec<usize> = (1..bytes.len()).filter(|i| bytes[*i].is_ascii_digit() && bytes[*i - 1] == b' ').collect();
    for _ in 0..TIMES {
        let at = rng.random_range(0..bytes.len());
        let end = (at + rng.random_range(1..200)).min(bytes.len());
        all.push(bytes[..at].to_vec());
        all.push([&bytes[..at], &bytes[end..]].concat());
        all.push([&bytes[..end], &bytes[at..]].concat());
        for count in [1, 20] {
            let mut flipped = bytes.to_vec();
            (0..count).for_each(|_| flipped[rng.random_range(0..bytes.len())] = rng.random());
            all.push(flipped);
        }
        for word in ["nan", "inf", "-1", "1e999", "99999999999999999999", ""] {
            let Some(at) = (!numbers.is_empty()).then(|| numbers[rng.random_range(0..numbers.len())]) else { continue };
            let end = (at..bytes.len()).find(|i| !matches!(bytes[*i], b'0'..=b'9' | b'.')).unwrap_or(bytes.len());
            all.push([&bytes[..at], word.as_bytes(), &bytes[end..]].concat());
        }
    }
    let ends = |end: &[u8], most: usize| {
        let mut out = Vec::new();
        for (row, line) in bytes.split_inclusive(|b| *b == b'\n').enumerate() {
            match line.strip_suffix(b"\n") {
                Some(text) if row < most => out.extend([text, end].concat()),
                _ => out.extend(line),
            }
        }
        out
    };
    all.extend([ends(b"\r\n", usize::MAX), ends(b"\r", usize::MAX), ends(b"\r\n", 4), [b"\xef\xbb\xbf", bytes].concat()]);
    all.push(String::from_utf8_lossy(bytes).encode_utf16().flat_map(u16::to_le_bytes).collect());
    all.extend([Vec::new(), b"\n".to_vec()]);
    all
}

#[test]
fn damaged_files_are_read_or_refused_in_one_line() {
    let network = cerebral(&circle_of_willis(1e-2));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut read, mut refused) = (0, 0);
    for (word, name) in FILES {
        let files = converted(&network, &Target::new(Path::new(name), Some(word)).unwrap());
        let files: Vec<(String, Vec<u8>)> = files
            .into_iter()
            .map(|(path, bytes)| (path.display().to_string(), bytes))
            .filter(|(name, _)| !name.contains("loops"))
            .collect();
        for harmed in 0..files.len() {
            for bytes in damaged(&files[harmed].1, &mut rng) {
                let whole = |row: usize| if row == harmed { &bytes[..] } else { &files[row].1[..] };
                let set: Vec<(&str, &[u8])> = (0..files.len()).map(|row| (files[row].0.as_str(), whole(row))).collect();
                match read_first(&set, &ReadOptions::default()) {
                    Ok(_) => read += 1,
                    Err(line) => {
                        assert!(!line.chars().any(char::is_control) && line.contains(';') && line.len() < 2000, "{word}: {line}");
                        refused += 1;
                    }
                }
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 100 && refused > 500, "{read} read, {refused} refused");
}
