//! A small mask made of bytes: spacing, shape, turns, then voxels. It is thinned, traced and written. What must stay: its parts and its
//! cavities and tunnels (Euler's number) by thinning, and the mask itself by its file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use willis::internals::formats::{Format, ReadOptions, write_nifti};
use willis::internals::masks::{Cavities, Foreground, Mask, RadiusFrom, distances, thin, trace};
use willis::internals::network::{RadiusRule, contract};

/// Parts of voxels that touch at least at a corner, and Euler's number of the closed cubes: corners - edges + faces - cubes.
fn topology(shape: [usize; 3], inside: &[bool]) -> (usize, i64) {
    let at = |p: [i64; 3]| (0..3).all(|k| (0..shape[k] as i64).contains(&p[k])) && inside[row(shape, p)];
    let mut seen = vec![false; inside.len()];
    let mut parts = 0;
    for start in 0..inside.len() {
        if !inside[start] || seen[start] {
            continue;
        }
        parts += 1;
        seen[start] = true;
        let mut stack = vec![place(shape, start)];
        while let Some(p) = stack.pop() {
            for by in 0..27 {
                let q = [p[0] + by % 3 - 1, p[1] + by / 3 % 3 - 1, p[2] + by / 9 - 1];
                if at(q) && !seen[row(shape, q)] {
                    seen[row(shape, q)] = true;
                    stack.push(q);
                }
            }
        }
    }
    // A cell of the grid of half steps is there where one of the cubes around it is; odd coordinates are inside of it.
    let mut euler = 0;
    for z in 0..=2 * shape[2] as i64 {
        for y in 0..=2 * shape[1] as i64 {
            for x in 0..=2 * shape[0] as i64 {
                let cell = [x, y, z];
                let open = cell.iter().filter(|c| *c % 2 == 1).count();
                let around = |k: usize| if cell[k] % 2 == 1 { vec![cell[k] / 2] } else { vec![cell[k] / 2 - 1, cell[k] / 2] };
                let (xs, ys, zs) = (around(0), around(1), around(2));
                if xs.iter().any(|x| ys.iter().any(|y| zs.iter().any(|z| at([*x, *y, *z])))) {
                    euler += if open % 2 == 0 { 1 } else { -1 };
                }
            }
        }
    }
    (parts, euler)
}

fn row(shape: [usize; 3], p: [i64; 3]) -> usize {
    (p[2] as usize * shape[1] + p[1] as usize) * shape[0] + p[0] as usize
}

fn place(shape: [usize; 3], row: usize) -> [i64; 3] {
    [row % shape[0], row / shape[0] % shape[1], row / shape[0] / shape[1]].map(|x| x as i64)
}

fuzz_target!(|bytes: &[u8]| {
    let [a, b, c, turn, spacing, voxels @ ..] = bytes else { return };
    let shape = [a, b, c].map(|x| usize::from(x % 9) + 1);
    let count: usize = shape.iter().product();
    // Eight voxels a byte; the classes follow from their places.
    let class = |at: usize| voxels.get(at / 8).is_some_and(|byte| byte >> (at % 8) & 1 == 1);
    let classes: Vec<u8> = (0..count).map(|at| if class(at) { 1 + (at % 3) as u8 } else { 0 }).collect();
    let size = [0.25, 0.5, 1.0, 1e-3, 1e3, 0.3, 7.0, 1.5];
    let mm = [0, 3, 5].map(|shift| size[usize::from(spacing >> shift & 7)]);
    let axes = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]][usize::from(turn % 6)];
    let mut affine = [[0.0; 4]; 3];
    for axis in 0..3 {
        affine[axis][axes[axis]] = mm[axis] * if turn >> (5 + axis) & 1 == 1 { -1.0 } else { 1.0 };
    }
    let mask = Mask::new(shape, classes, affine);

    let mut file = Vec::new();
    write_nifti(&mut file, &mask, false).expect("written");
    let options = ReadOptions { max_input: 1 << 20, ..ReadOptions::default() };
    match Format::Nifti.read_mask(std::path::Path::new("a.nii"), &file, &options) {
        Ok(again) => assert!(again.shape == mask.shape && again.classes == mask.classes),
        Err(_) => assert!(mask.classes.iter().all(|class| *class == 0), "a mask with voxels"),
    }

    let turned = mask.in_scanner_order();
    if let Some(vessels) = Foreground::of(&turned) {
        let thinned = thin(&vessels);
        let mut kept = vec![false; count];
        for one in &thinned {
            let voxel = vessels.voxel(*one as usize).map(|x| x as i64);
            kept[row(turned.shape, voxel)] = true;
        }
        let whole: Vec<bool> = turned.classes.iter().map(|class| *class > 0).collect();
        assert_eq!(topology(turned.shape, &kept), topology(turned.shape, &whole), "thinning changed the topology");
        assert!(kept.iter().zip(&whole).all(|(kept, whole)| !kept || *whole));
        // Where the image has no voxel outside vessels there is no distance.
        let has_outside = whole.contains(&false);
        assert!(distances(&vessels, turned.spacing()).iter().all(|d| *d > 0.0 && d.is_finite() == has_outside));
    }
    for from in [RadiusFrom::Area, RadiusFrom::Distance, RadiusFrom::Inscribed] {
        let Some(traced) = trace(&turned, from, Cavities::Keep) else { continue };
        let mut lines = traced.lines;
        assert!(lines.points.iter().all(|place| place.iter().all(|x| x.is_finite())));
        lines.weld(1e-6);
        let _ = contract(&lines, RadiusRule::Mean, Some(1e-3));
    }
});
