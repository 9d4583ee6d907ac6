//! Thinning, distances, radii and the graph of a mask: against invariants of topology, brute force, tubes of known radius, and, where
//! they are there, scikit-image, edt and expert tracings.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

use crate::draw::Draw;
use crate::peers::{python, shared};
use petgraph::unionfind::UnionFind;
use willis::internals::formats::{Content, ReadOptions, read, read_mask};
use willis::internals::masks::{Affine, Cavities, Foreground, Mask, RadiusFrom, RunLengths, Traced, distances, thin, trace};
use willis::internals::network::Frame;
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::millimetres;
use willis::internals::support::geometry::{Point, distance, dot, norm_squared, sub};

/// A mask of cubic voxels of 1 mm, the first axis fastest.
pub fn mask(shape: [usize; 3], is_vessel: impl Fn([usize; 3]) -> bool) -> Mask {
    spaced(shape, [1.0; 3], is_vessel)
}

pub fn spaced(shape: [usize; 3], spacing: [f64; 3], is_vessel: impl Fn([usize; 3]) -> bool) -> Mask {
    let [x, y, z] = shape;
    let at = |row: usize| [row % x, row / x % y, row / (x * y)];
    let classes = (0..x * y * z).map(|row| u8::from(is_vessel(at(row)))).collect();
    let [a, b, c] = spacing;
    Mask::new(shape, classes, [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, 0.0], [0.0, 0.0, c, 0.0]])
}

/// Random voxels, smoothed by a vote of neighbours so that there are lumps, tunnels and cavities of all sizes.
pub fn lumps(seed: u64) -> Mask {
    let mut draw = Draw::new(seed);
    let shape = [4 + draw.below(9), 4 + draw.below(9), 4 + draw.below(9)];
    let share = draw.within(0.1, 0.6);
    let mut is: Vec<bool> = (0..shape.iter().product()).map(|_| draw.within(0.0, 1.0) < share).collect();
    let at = |is: &[bool], p: [i64; 3]| {
        let inside = (0..3).all(|axis| p[axis] >= 0 && p[axis] < shape[axis] as i64);
        inside && is[(p[0] + shape[0] as i64 * (p[1] + shape[1] as i64 * p[2])) as usize]
    };
    if draw.below(2) == 0 {
        let before = is.clone();
        for (row, voxel) in is.iter_mut().enumerate() {
            let p = [row % shape[0], row / shape[0] % shape[1], row / (shape[0] * shape[1])].map(|x| x as i64);
            let votes = (0..27).filter(|n| at(&before, [p[0] + n % 3 - 1, p[1] + n / 3 % 3 - 1, p[2] + n / 9 - 1])).count();
            *voxel = votes as f64 > 27.0 * share;
        }
    }
    mask(shape, |[x, y, z]| is[x + shape[0] * (y + shape[1] * z)])
}

/// The number of 26-connected components, and Euler's number of the union of the closed voxels: vertices - edges + faces - cubes.
fn topology(shape: [usize; 3], voxels: &[[usize; 3]]) -> (usize, i64) {
    let there: BTreeSet<[usize; 3]> = voxels.iter().copied().collect();
    // Cells by twice their centre: an odd coordinate lies inside a voxel, an even one on a face.
    let mut cells = BTreeSet::new();
    for voxel in &there {
        for n in 0..27 {
            cells.insert([0, 1, 2].map(|axis: usize| 2 * voxel[axis] + n / 3_usize.pow(axis as u32) % 3));
        }
    }
    let sign = |cell: &[usize; 3]| if cell.iter().filter(|x| **x % 2 == 1).count() % 2 == 0 { 1 } else { -1 };
    let euler = cells.iter().map(sign).sum();
    let (mut left, mut components) = (there, 0);
    while let Some(first) = left.pop_first() {
        components += 1;
        let mut open = vec![first];
        while let Some(at) = open.pop() {
            for n in 0..27 {
                let near = [0, 1, 2].map(|axis: usize| (at[axis] + n / 3_usize.pow(axis as u32) % 3).wrapping_sub(1));
                if (0..3).all(|axis| near[axis] < shape[axis]) && left.remove(&near) {
                    open.push(near);
                }
            }
        }
    }
    (components, euler)
}

fn voxels(of: &Foreground, rows: impl Iterator<Item = usize>) -> Vec<[usize; 3]> {
    rows.map(|row| of.voxel(row)).collect()
}

fn skeleton(mask: &Mask) -> (Foreground, Vec<[usize; 3]>) {
    let vessels = Foreground::of(mask).expect("vessels");
    let thinned = voxels(&vessels, thin(&vessels).into_iter().map(|row| row as usize));
    (vessels, thinned)
}

/// Components and independent cycles of the lines.
pub fn graph(lines: &Centerlines) -> (usize, i64) {
    let mut joined = UnionFind::<u32>::new(lines.points.len());
    let united = lines.links.iter().filter(|[a, b]| joined.union(*a, *b)).count();
    let components = lines.points.len() - united;
    (components, lines.links.len() as i64 - lines.points.len() as i64 + components as i64)
}

#[test]
fn thinning_keeps_components_tunnels_and_cavities() {
    for seed in 0..200 {
        let mask = lumps(seed);
        let Some(vessels) = Foreground::of(&mask) else { continue };
        let (all, thinned) = (voxels(&vessels, 0..vessels.count()), skeleton(&mask).1);
        assert_eq!(topology(mask.shape, &all), topology(mask.shape, &thinned), "seed {seed}");
        // Nothing more can go: every voxel left is an end, alone, or needed.
        let again = self::mask(mask.shape, |at| thinned.contains(&at));
        assert_eq!(skeleton(&again).1, thinned, "seed {seed}");
    }
}

#[test]
fn the_graph_has_the_loops_of_the_mask() {
    let mut loops = 0;
    for seed in 0..200 {
        let mask = lumps(seed);
        let Some(traced) = trace(&mask, RadiusFrom::Area, Cavities::Keep) else { continue };
        let (vessels, thinned) = skeleton(&mask);
        let (components, euler) = topology(mask.shape, &thinned);
        // Of a cavity a shell is left, which no lines can stand for; in a mask without cavities tunnels = components - Euler's number.
        if has_cavity(&mask) {
            continue;
        }
        let tunnels = components as i64 - euler;
        assert_eq!(graph(&traced.lines), (components - traced.specks, tunnels), "seed {seed} of {} voxels", vessels.count());
        loops += tunnels;
    }
    assert!(loops > 100, "{loops}");
}

/// A rod of three voxels has a line of two, and is two wide: it is not shorter than wide, and no speck. Rounding says otherwise by where and how the
/// mask lies; and whether twigs askew to a bar three wide are spurs.
#[test]
fn rounding_makes_no_specks_and_spurs() {
    let is_rod = |at: [usize; 3]| {
        let [block, within] = [at.map(|x| x / 5), at.map(|x| x % 5)];
        let axis = (block[0] + block[1] + block[2]) % 3;
        at[2] < 20 && (0..3).all(|k| within[k] == 1 || k == axis && (1..4).contains(&within[k]))
    };
    let is_comb = |[x, y, z]: [usize; 3]| match z {
        27 if (11..=13).contains(&y) => (x + 13 - y) % 8 == 7,
        _ => (26..=28).contains(&z) && (9..=11).contains(&y),
    };
    let (sin, cos) = 0.3_f64.sin_cos();
    let found = |size: f64, [sin, cos]: [f64; 2], origin: [f64; 3]| {
        let mut mask = spaced([40, 40, 34], [size; 3], |at| is_rod(at) || is_comb(at));
        mask.affine = mask.affine.map(|[x, y, z, _]| [x * cos + y * sin, y * cos - x * sin, z, 0.0]);
        (0..3).for_each(|axis| mask.affine[axis][3] = origin[axis]);
        let traced = trace(&mask, RadiusFrom::Area, Cavities::Fill).expect("vessels");
        (traced.specks, traced.spurs, graph(&traced.lines).0)
    };
    let whole = found(1.0, [0.0, 1.0], [0.0; 3]);
    assert_eq!((whole.0, whole.2), (0, 8 * 8 * 4 + 1));
    for turn in [[0.0, 1.0], [sin, cos]] {
        for origin in [[0.0; 3], [17.3, -45.1, 99.7], [-178.123, -201.456, 33.3]] {
            assert_eq!(found(0.513_393, turn, origin), whole, "at {origin:?}");
        }
    }
}

/// Whether some background is shut in by vessels: faces lead from the outside to all that is not.
pub fn has_cavity(mask: &Mask) -> bool {
    let shape = mask.shape.map(|n| n + 2);
    let row = |p: [usize; 3]| p[0] + shape[0] * (p[1] + shape[1] * p[2]);
    let mut closed = vec![false; shape.iter().product()];
    for (n, class) in mask.classes.iter().enumerate() {
        let [x, y, _] = mask.shape;
        closed[row([n % x + 1, n / x % y + 1, n / (x * y) + 1])] = *class > 0;
    }
    let mut open = vec![[0_usize; 3]];
    closed[0] = true;
    while let Some(at) = open.pop() {
        for (axis, by) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1_isize)] {
            let mut next = at;
            next[axis] = next[axis].wrapping_add_signed(by);
            if next[axis] < shape[axis] && !std::mem::replace(&mut closed[row(next)], true) {
                open.push(next);
            }
        }
    }
    closed.contains(&false)
}

#[test]
fn a_bar_becomes_its_axis_a_ring_a_ring_and_a_cross_four_arms() {
    let bar = mask([31, 9, 9], |[x, y, z]| (3..28).contains(&x) && (2..7).contains(&y) && (2..7).contains(&z));
    let axis = skeleton(&bar).1;
    assert!(axis.iter().all(|[_, y, z]| *y == 4 && *z == 4), "{axis:?}");
    let traced = trace(&bar, RadiusFrom::Area, Cavities::Keep).expect("lines");
    let xs: Vec<f64> = traced.lines.points.iter().map(|p| p[0] * 1e3).collect();
    let (low, high) = (xs.iter().copied().fold(f64::MAX, f64::min), xs.iter().copied().fold(f64::MIN, f64::max));
    // Thinning takes the ends too, but no more than half of the bar's width from its faces, which lie at 2.5 and 27.5; the lines end half
    // a voxel inside.
    assert!((3.0..=5.5).contains(&low) && (24.5..=27.0).contains(&high), "{low} {high}");
    let area = (25.0 / PI).sqrt();
    assert!(traced.lines.radii.iter().all(|r| (r * 1e3 / area - 1.0).abs() < 0.06), "{:?}", traced.lines.radii);
    let ring = mask([41, 41, 9], |p| {
        let [x, y, z] = p.map(|x| x as f64);
        let around = ((x - 20.0).hypot(y - 20.0) - 14.0).hypot(z - 4.0);
        around <= 3.0
    });
    let traced = trace(&ring, RadiusFrom::Area, Cavities::Keep).expect("lines");
    assert_eq!(graph(&traced.lines), (1, 1));
    assert!(traced.lines.points.iter().all(|p| ((p[0] * 1e3 - 20.0).hypot(p[1] * 1e3 - 20.0) - 14.0).abs() < 0.8));
    let cross = mask([41, 41, 7], |[x, y, z]| (2..5).contains(&z) && ((19..22).contains(&x) || (19..22).contains(&y)));
    let traced = trace(&cross, RadiusFrom::Area, Cavities::Keep).expect("lines");
    let mut degrees = vec![0; traced.lines.points.len()];
    traced.lines.links.iter().flatten().for_each(|end| degrees[*end as usize] += 1);
    let count = |n: usize| degrees.iter().filter(|degree| **degree == n).count();
    assert_eq!((count(1), count(4), count(3)), (4, 1, 0), "one junction, four ends");
}

#[test]
fn distances_are_those_to_the_nearest_voxel_outside() {
    for seed in 0..40 {
        let mut draw = Draw::new(seed);
        let spacing = [draw.within(0.2, 2.0), draw.within(0.2, 2.0), draw.within(0.2, 2.0)];
        let mask = lumps(seed);
        let Some(vessels) = Foreground::of(&mask) else { continue };
        let [x, y, _] = mask.shape;
        let all = || mask.classes.iter().enumerate().map(|(row, class)| ([row % x, row / x % y, row / (x * y)], *class));
        for (row, found) in distances(&vessels, spacing).into_iter().enumerate() {
            let here = vessels.voxel(row);
            let away = |at: [usize; 3]| (0..3).map(|k| (spacing[k] * at[k].abs_diff(here[k]) as f64).powi(2)).sum::<f64>().sqrt();
            let truth = all().filter(|(_, class)| *class == 0).map(|(at, _)| away(at)).fold(f64::INFINITY, f64::min);
            assert!((found - truth).abs() < 1e-12 || found == truth, "seed {seed}: {found} {truth}");
        }
    }
}

/// A straight tube of voxels whose centres lie within a radius of its axis; the middle of its axis and its direction.
fn tube(draw: &mut Draw, spacing: [f64; 3], radius: f64, length: f64) -> (Mask, Point, Point) {
    let toward: Point = std::array::from_fn(|_| draw.within(-1.0, 1.0));
    let size = norm_squared(toward).sqrt();
    let along = toward.map(|x| x / size);
    let half: Point = std::array::from_fn(|axis| along[axis].abs() * length / 2.0 + radius + 3.0 * spacing[axis]);
    let shape = std::array::from_fn(|axis| (2.0 * half[axis] / spacing[axis]) as usize + 1);
    let middle: Point = std::array::from_fn(|axis| half[axis] + draw.within(-0.5, 0.5) * spacing[axis]);
    let is = |p: [usize; 3]| {
        let by = sub(std::array::from_fn(|axis| p[axis] as f64 * spacing[axis]), middle);
        let on = dot(by, along);
        on.abs() <= length / 2.0 && norm_squared(by) - on * on <= radius * radius
    };
    (spaced(shape, spacing, is), middle, along)
}

pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn the_radius_of_a_tube_is_found_at_all_angles_and_shapes_of_voxels() {
    let mut draw = Draw::new(7);
    for spacing in [[1.0; 3], [1.0, 1.0, 1.6], [0.5, 0.5, 0.8]] {
        let voxel = spacing.iter().product::<f64>().cbrt();
        for (wide, within) in [(0.6, 0.08), (1.0, 0.03), (1.5, 0.03), (2.0, 0.03), (4.0, 0.03)] {
            let radius = wide * voxel;
            let found = (0..15).map(|_| {
                let (mask, middle, along) = tube(&mut draw, spacing, radius, 40.0 * voxel);
                let lines = trace(&mask, RadiusFrom::Area, Cavities::Keep).expect("lines").lines;
                let central = lines
                    .points
                    .iter()
                    .zip(&lines.radii)
                    .filter(|(p, _)| dot(sub(p.map(|x| x * 1e3), middle), along).abs() < 10.0 * voxel);
                median(central.map(|(_, r)| r * 1e3 / radius).collect())
            });
            let ratio = median(found.collect());
            assert!((ratio - 1.0).abs() <= within, "{spacing:?}, {wide} voxels wide: {ratio}");
        }
    }
}

/// The lines by place: points and radii, mm, sorted and rounded, of links.
pub fn places(traced: &Traced) -> Vec<[[i64; 4]; 2]> {
    let lines = &traced.lines;
    let at = |row: u32| {
        let ([x, y, z], r) = (lines.points[row as usize], lines.radii[row as usize]);
        [x, y, z, r].map(|metres| (metres * 1e9).round() as i64)
    };
    let mut links: Vec<_> = lines.links.iter().map(|[a, b]| [at(*a).min(at(*b)), at(*a).max(at(*b))]).collect();
    links.sort_unstable();
    links
}

/// The same image with its axes in another order and direction, its frame changed with them.
fn reordered(mask: &Mask, order: [usize; 3], flipped: [bool; 3]) -> Mask {
    let shape = order.map(|axis| mask.shape[axis]);
    let mut classes = Vec::new();
    for row in 0..shape.iter().product() {
        let p = [row % shape[0], row / shape[0] % shape[1], row / (shape[0] * shape[1])];
        let mut old = [0; 3];
        for axis in 0..3 {
            old[order[axis]] = if flipped[axis] { shape[axis] - 1 - p[axis] } else { p[axis] };
        }
        classes.push(mask.classes[old[0] + mask.shape[0] * (old[1] + mask.shape[1] * old[2])]);
    }
    let affine = mask.affine.map(|row| {
        let mut new = [0.0, 0.0, 0.0, row[3]];
        for axis in 0..3 {
            let step = row[order[axis]];
            new[axis] = if flipped[axis] { -step } else { step };
            new[3] += if flipped[axis] { step * (shape[axis] - 1) as f64 } else { 0.0 };
        }
        new
    });
    Mask::new(shape, classes, affine)
}

#[test]
fn neither_the_order_of_axes_nor_a_crop_changes_the_lines() {
    let mut draw = Draw::new(3);
    let (whole, ..) = tube(&mut draw, [0.5, 0.5, 0.75], 1.7, 25.0);
    let truth = places(&trace(&whole.clone().in_scanner_order(), RadiusFrom::Area, Cavities::Keep).expect("lines"));
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 2, 1]] {
        for flipped in [[false; 3], [true, false, false], [true, true, false], [true; 3]] {
            let other = reordered(&whole, order, flipped).in_scanner_order();
            assert_eq!(other.shape, whole.clone().in_scanner_order().shape);
            assert!(truth == places(&trace(&other, RadiusFrom::Area, Cavities::Keep).expect("lines")), "{order:?} {flipped:?}");
        }
    }
    let [x, y, z] = whole.shape;
    let margin = [7_u8, 4, 5];
    let mut wide = spaced([x + 14, y + 8, z + 10], [0.5, 0.5, 0.75], |p| {
        let p: Option<Vec<usize>> = (0..3).map(|axis| p[axis].checked_sub(usize::from(margin[axis]))).collect();
        p.is_some_and(|p| p[0] < x && p[1] < y && p[2] < z && whole.classes[p[0] + x * (p[1] + y * p[2])] > 0)
    });
    for (axis, margin) in margin.into_iter().enumerate() {
        wide.affine[axis][3] -= f64::from(margin) * wide.affine[axis][axis];
    }
    assert!(
        truth == places(&trace(&wide.in_scanner_order(), RadiusFrom::Area, Cavities::Keep).expect("lines")),
        "a margin of background"
    );
}

/// Loops as scikit-image's skeletons of these masks have them (data/tubetk-masks/PROVENANCE.md), lines near the expert's tubes, and the
/// volume of the mask.
#[test]
fn real_masks_give_lines_where_the_expert_drew_them() {
    for (subject, pieces, loops) in [("002", 15, 93), ("003", 51, 92)] {
        let Some(path) = shared(&format!("tubetk-masks/labels-{subject}.nii.gz")) else { return };
        let tubes = path.with_file_name(format!("tubes-{subject}.vtp"));
        let lines_of =
            |path: &std::path::Path| match read(path, &ReadOptions { cavities: Cavities::Keep, ..ReadOptions::default() })
                .expect("read")
                .content
            {
                Content::Centerlines(lines) => lines,
                other => panic!("{other:?}"),
            };
        let (lines, expert) = (lines_of(&path), lines_of(&tubes));
        assert_eq!(graph(&lines), (pieces, loops), "{subject}");
        // The tubes are in the frame of indices times spacing: x and y run the other way.
        let turned = |p: Point| [-p[0], -p[1], p[2]];
        let near = |p: Point| lines.points.iter().any(|q| distance(turned(p), *q) < 1.2e-3);
        let tubes: Vec<Point> = expert.points.iter().copied().step_by(7).collect();
        let share = tubes.iter().filter(|p| near(**p)).count() as f64 / tubes.len() as f64;
        assert!(share > 0.97, "{subject}: {share} of the expert's points");
        let volume = |[a, b]: &[u32; 2]| {
            let (r, s) = (lines.radii[*a as usize], lines.radii[*b as usize]);
            PI * (r * r + r * s + s * s) / 3.0 * distance(lines.points[*a as usize], lines.points[*b as usize])
        };
        let total = lines.links.iter().map(volume).sum::<f64>();
        let voxels = if subject == "002" { 71118.0 } else { 73576.0 };
        let ratio = total / (voxels * 0.210_858e-9);
        assert!((ratio - 1.0).abs() < 0.05, "{subject}: volume {ratio}");
    }
}

const PEERS: &str = r#"
import sys, numpy as np
from skimage.measure import euler_number, label
from skimage.morphology import skeletonize
import edt
rng = np.random.default_rng(5)
np.seterr(all="ignore")
for case in range(40):
    shape = rng.integers(5, 16, 3)
    a = rng.random(shape) < rng.uniform(.1, .6)
    spacing = rng.uniform(.3, 2, 3)
    d = edt.edt(np.asfortranarray(a), anisotropy=tuple(spacing), black_border=False)
    s = skeletonize(a.T, method="lee").T > 0
    t = [label(a, connectivity=3).max(), euler_number(a, connectivity=3)]
    bits = lambda of: "".join("1" if v else "0" for v in of.ravel(order="F"))
    print(*shape, *spacing, *t, bits(s), bits(a), *np.round(d.ravel(order="F"), 4), sep=" ")
"#;

/// The voxels that are left of the mask that ships, as rows with z fastest, as in scanner order.
const SHIPPED: &str = r#"
import sys, nibabel, numpy as np
from skimage.morphology import skeletonize
left = skeletonize(np.asarray(nibabel.as_closest_canonical(nibabel.load(sys.argv[1])).dataobj) > 0, method="lee") > 0
print(*np.flatnonzero(left))
"#;

#[test]
fn scikit_image_and_edt_say_the_same() {
    let Some(out) = python(PEERS, &[]) else { return };
    let (mut same, mut either, mut cases) = (0, 0, 0);
    for line in out.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let number = |n: usize| words[n].parse::<f64>().expect("a number");
        let shape = [0, 1, 2].map(|n| number(n) as usize);
        let [left, is] = [8, 9].map(|word: usize| words[word].bytes().map(|byte| byte == b'1').collect::<Vec<bool>>());
        let mask = mask(shape, |[x, y, z]| is[x + shape[0] * (y + shape[1] * z)]);
        let (vessels, thinned) = skeleton(&mask);
        assert_eq!(topology(shape, &thinned), (number(6) as usize, number(7) as i64), "{shape:?}");
        let found = distances(&vessels, [3, 4, 5].map(number));
        for (row, found) in found.iter().enumerate() {
            let [x, y, z] = vessels.voxel(row);
            let truth = number(10 + x + shape[0] * (y + shape[1] * z));
            assert!((found - truth).abs() < 2e-4, "{found} {truth}");
        }
        let row = |[x, y, z]: [usize; 3]| x + shape[0] * (y + shape[1] * z);
        let kept: BTreeSet<usize> = thinned.into_iter().map(row).collect();
        same += kept.iter().filter(|row| left[**row]).count();
        either += (0..left.len()).filter(|row| left[*row] || kept.contains(row)).count();
        cases += 1;
    }
    // In noise theirs also removes voxels that are not simple, which opens or closes loops.
    assert!(cases == 40 && same as f64 > 0.9 * either as f64, "{same} {either}");
}

#[test]
fn of_a_mask_of_vessels_the_voxels_of_scikit_image_are_left() {
    let scan = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scan.nii.gz");
    let Some(out) = python(SHIPPED, &[&scan]) else { return };
    let theirs: BTreeSet<usize> = out.split_whitespace().map(|word| word.parse().expect("a row")).collect();
    let mask = read_mask(&scan, &ReadOptions::default(), Frame::Unknown).expect("a mask").in_scanner_order();
    let mine: BTreeSet<usize> =
        skeleton(&mask).1.into_iter().map(|[x, y, z]| x + mask.shape[0] * (y + mask.shape[1] * z)).collect();
    let apart = mine.symmetric_difference(&theirs).count();
    assert!(mine.len() > 1000 && apart <= 5, "{apart} of {}", mine.len());
}

#[test]
fn a_vessel_that_leaves_the_image_ends_at_its_border() {
    // A bar from face to face, and one that ends inside.
    let through = mask([30, 9, 9], |[_, y, z]| (3..6).contains(&y) && (3..6).contains(&z));
    let traced = trace(&through, RadiusFrom::Area, Cavities::Keep).expect("lines");
    assert_eq!(traced.lines.at_border.len(), 2);
    let xs: Vec<f64> = traced.lines.points.iter().map(|p| p[0] * 1e3).collect();
    let (low, high) = (xs.iter().copied().fold(f64::MAX, f64::min), xs.iter().copied().fold(f64::MIN, f64::max));
    assert!((low + 0.5).abs() < 0.3 && (high - 29.5).abs() < 0.3, "{low} {high}");
    let inside = mask([30, 9, 9], |[x, y, z]| x > 6 && (3..6).contains(&y) && (3..6).contains(&z));
    let lines = trace(&inside, RadiusFrom::Area, Cavities::Keep).expect("lines").lines;
    assert_eq!(lines.at_border.len(), 1);
    let row = lines.ids.iter().position(|id| lines.at_border.contains(id)).expect("an end");
    assert!(lines.points[row][0] > 28e-3, "{:?}", lines.points[row]);
}

/// The skeleton of a hollow ball is a shell of many thousand voxels that all have many neighbours.
#[test]
fn a_shell_is_thinned_and_drawn() {
    let ball = mask([64, 64, 64], |p| (26.0..29.0).contains(&norm_squared(p.map(|x| x as f64 - 32.0)).sqrt()));
    let traced = trace(&ball, RadiusFrom::Area, Cavities::Keep).expect("lines");
    assert!(traced.lines.points.len() > 5000 && traced.lines.radii.iter().all(|r| *r > 0.0));
}

const AFFINE: Affine = [[-0.5, 0.0, 0.0, 10.0], [0.0, 0.5, 0.0, -20.0], [0.0, 0.0, 2.0, 30.0]];

fn ball(radius: f64, size: usize) -> Mask {
    let middle = (size as f64 - 1.0) / 2.0;
    let inside = |at: [usize; 3]| at.iter().map(|x| (*x as f64 - middle).powi(2)).sum::<f64>() <= radius * radius;
    let classes = (0..size.pow(3)).map(|n| u8::from(inside([n % size, n / size % size, n / (size * size)]))).collect();
    Mask::new([size; 3], classes, AFFINE)
}

/// The places and positions (mm) of what is inside, read back as the page does.
fn read_back(runs: &RunLengths) -> Vec<[f64; 3]> {
    let (mut at, mut inside, mut place, mut found) = (0, false, 0, Vec::new());
    while at < runs.bytes.len() {
        let (mut length, mut shift) = (0_usize, 0);
        loop {
            let byte = runs.bytes[at];
            at += 1;
            length |= usize::from(byte & 0x7f) << shift;
            shift += 7;
            if byte < 0x80 {
                break;
            }
        }
        let [x, y, _] = runs.shape;
        found.extend((place..place + length).filter(|_| inside).map(|p| {
            let index = [p % x, p / x % y, p / (x * y)];
            runs.affine.map(|row| row[3] + (0..3).map(|axis| row[axis] * index[axis] as f64).sum::<f64>())
        }));
        place += length;
        inside = !inside;
    }
    found
}

/// Read back, every voxel of the mask is there at its own position, and no other.
#[test]
fn nothing_is_lost() {
    let mask = ball(4.2, 11);
    let runs = RunLengths::of(&Foreground::of(&mask).expect("voxels"), usize::MAX, usize::MAX);
    assert_eq!(runs.block, 1);
    let truth: Vec<[f64; 3]> = (0..mask.classes.len())
        .filter(|n| mask.classes[*n] > 0)
        .map(|n| AFFINE.map(|row| row[3] + row[0] * (n % 11) as f64 + row[1] * (n / 11 % 11) as f64 + row[2] * (n / 121) as f64))
        .collect();
    assert_eq!(read_back(&runs), truth);
}

/// In blocks the surface keeps its limit; the middle of the ball stays, and its volume to the width of a block.
#[test]
fn blocks_keep_the_limit_and_the_place() {
    let vessels = Foreground::of(&ball(12.0, 29)).expect("voxels");
    let all = RunLengths::of(&vessels, usize::MAX, usize::MAX);
    for faces in [1_500, 600, 10] {
        let runs = RunLengths::of(&vessels, faces, usize::MAX);
        assert!(runs.block > 1);
        let (found, truth) = (read_back(&runs), read_back(&all));
        let mean = |of: &[[f64; 3]], axis: usize| of.iter().map(|p| p[axis]).sum::<f64>() / of.len() as f64;
        for (axis, step) in [0.5, 0.5, 2.0].into_iter().enumerate() {
            assert!((mean(&found, axis) - mean(&truth, axis)).abs() <= 0.5 * step * runs.block as f64, "{faces} {axis}");
        }
        let volume = (found.len() * runs.block.pow(3)) as f64 / truth.len() as f64;
        assert!((0.9..(1.0 + runs.block as f64 / 12.0).powi(3)).contains(&volume) || found.len() == 1, "{faces}: {volume}");
    }
    assert!(RunLengths::of(&vessels, usize::MAX, 5_000).block > 1);
}

/// A bar has a line along it, whatever its sides are: no line is undone from its end. It ends about half a width short of the bar.
#[test]
fn bars_of_every_width_have_a_line_along_them() {
    for (wide, high) in (1..8).flat_map(|wide| (1..8).map(move |high| (wide, high))) {
        for axis in 0..3 {
            let sides = [[30, wide, high], [wide, 30, high], [wide, high, 30]][axis];
            let bar = mask(sides.map(|side| side + 4), |at| (0..3).all(|axis| (2..sides[axis] + 2).contains(&at[axis])));
            let lines = trace(&bar, RadiusFrom::Area, Cavities::Keep).expect("lines").lines;
            let along = || lines.points.iter().map(|point| millimetres(point[axis]));
            let length = along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min);
            assert!(length >= 29.0 - 1.5 * wide.max(high) as f64 - 2.0, "{sides:?}: {length}");
        }
    }
}
