//! Segmentation masks and images.

pub(crate) mod metaimage;
pub(crate) mod nifti;
pub(crate) mod numpy;
mod voxels;

use flate2::read::MultiGzDecoder;

/// The first bytes of a file after gzip; the first bytes themselves where it is not compressed.
pub(crate) fn unpacked_head(bytes: &[u8], most: usize) -> Vec<u8> {
    use std::io::Read;
    if !is_gzip(bytes) {
        return bytes[..bytes.len().min(most)].to_vec();
    }
    let mut head = vec![0; most];
    let mut decoder = MultiGzDecoder::new(bytes);
    let mut filled = 0;
    // What is damaged is said by whoever reads all of it.
    while let Ok(count @ 1..) = decoder.read(&mut head[filled..]) {
        filled += count;
    }
    head.truncate(filled);
    head
}

/// Whether a file is compressed by gzip.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b")
}
