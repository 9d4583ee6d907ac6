//! Whether a mask can be one of vessels: noise, a solid body and a sponge take minutes and gigabytes, and have no centerlines.

use willis_core::{network::Fragments, support::numbered::counted};

/// Fewer voxels are quick in any case.
const FEW: usize = 20_000;
/// Vessels that fill no more of the image may be thin.
const LEAST_SHARE: f64 = 0.02;
/// The runs of vessels are longer than those of voxels at random.
const NOISE: f64 = 0.9;
/// Where more of the image is inside, its borders end the runs, and the level is too low, or the background is not 0.
const FULL: f64 = 0.9;
/// A solid body has as many lines of voxels, each as long: no vessel is 160 voxels wide.
const BODY: (usize, usize) = (16_000, 160);
/// Vessels have fewer loops in all, or more branches to a loop.
const SPONGE: (usize, f64) = (1_000, 0.3);

/// Why the voxels of a mask are none of vessels; `None` where they may be. One pass along the lines of voxels.
pub fn why_no_vessels(mask: &super::mask::Mask) -> Option<String> {
    let (mut inside, mut runs, mut long) = (0, 0_usize, 0);
    for line in mask.classes.chunks_exact(mask.shape[0].max(1)) {
        for part in line.chunk_by(|a, b| (*a == 0) == (*b == 0)).filter(|part| part[0] != 0) {
            (inside, runs) = (inside + part.len(), runs + 1);
            long += usize::from(part.len() >= BODY.1);
        }
    }
    let (share, per_voxel) = (inside as f64 / mask.classes.len() as f64, runs as f64 / inside.max(1) as f64);
    let percent = 100.0 * share;
    // Voxels at random come in runs of 1 / (1 - share).
    if inside > FEW && share > LEAST_SHARE && per_voxel > NOISE * (1.0 - share) {
        if share > FULL {
            return Some(format!("too full: {percent:.0} % of the image"));
        }
        let length = 1.0 / per_voxel;
        return Some(format!("noise: {percent:.0} % of the image in runs of {length:.1} voxels"));
    }
    (long > BODY.0).then(|| format!("a solid body: {percent:.0} % of the image, {} voxels and more across", BODY.1))
}

/// Why centerlines are none of vessels: they are those of a sponge.
pub fn why_no_centerlines(lines: &willis_core::network::Centerlines) -> Option<String> {
    let (points, links) = (lines.points.len(), || lines.links.iter().map(|link| link.map(|point| point as usize)));
    let loops = lines.links.len() + Fragments::over(points, links()).count - points;
    let degree = counted(points, links().flatten());
    // Each branch has two ends at points that no line passes through.
    let branches = degree.iter().filter(|degree| **degree != 2).sum::<usize>() / 2;
    let is_sponge = loops > SPONGE.0 && loops as f64 > SPONGE.1 * branches as f64;
    is_sponge.then(|| format!("a sponge: {branches} branches with {loops} loops"))
}
