//! Radii from a map of probabilities: tubes of known radius whose voxels have the part of them that is inside, by points in each; what may
//! surround the vessels; and masks, which have no partial volume.

use std::path::Path;

use crate::draw::Draw;
use crate::images::npy;
use crate::masks::{median, places};
use willis::Scale;
use willis::internals::formats::{Format, ReadOptions};
use willis::internals::masks::{Cavities, Mask, RadiusFrom, Traced, trace};
use willis::internals::support::geometry::{Point, dot, norm_squared, sub};

/// The values of an image of cubic voxels of 1 mm, the first axis fastest.
#[derive(Clone)]
struct Map {
    shape: [usize; 3],
    values: Vec<f64>,
}

impl Map {
    fn at(&self, [x, y, z]: [usize; 3]) -> f64 {
        self.values[x + self.shape[0] * (y + self.shape[1] * z)]
    }

    fn with(&self, change: impl Fn([usize; 3], f64) -> f64) -> Self {
        let [x, y, _] = self.shape;
        let change = |(row, value): (usize, &f64)| change([row % x, row / x % y, row / (x * y)], *value);
        Self { shape: self.shape, values: self.values.iter().enumerate().map(change).collect() }
    }

    /// What is read of it; `last_fastest` stores it in the other order.
    fn read(&self, level: Option<f64>, last_fastest: bool) -> Mask {
        let [x, y, z] = self.shape;
        let values: Vec<f64> = if last_fastest {
            (0..x * y * z).map(|n| self.at([n / (y * z), n / z % y, n % z])).collect()
        } else {
            self.values.clone()
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let file = npy("<f8", !last_fastest, &format!("({x}, {y}, {z})"), &bytes);
        let scale = Scale { spacing: Some([1.0; 3]), ..Scale::default() };
        let options = ReadOptions { scale, level, ..ReadOptions::default() };
        Format::Npy.read_mask(Path::new("a.npy"), &file, &options).expect("a mask")
    }
}

fn lines(mask: &Mask) -> Traced {
    trace(mask, RadiusFrom::Area, Cavities::Fill).expect("lines")
}

/// A tube of a radius at a random angle, 40 mm long: the part of each voxel that is inside, its middle and its direction.
fn tube(draw: &mut Draw, radius: f64) -> (Map, Point, Point) {
    const POINTS: usize = 6;
    let toward: Point = std::array::from_fn(|_| draw.within(-1.0, 1.0));
    let along = toward.map(|x| x / norm_squared(toward).sqrt());
    let half: Point = along.map(|x| x.abs() * 20.0 + radius + 5.0);
    let middle: Point = half.map(|x| x + draw.within(-0.5, 0.5));
    let shape = half.map(|x| (2.0 * x) as usize + 1);
    let is_inside = |at: Point| {
        let by = sub(at, middle);
        let on = dot(by, along);
        on.abs() <= 20.0 && norm_squared(by) - on * on <= radius * radius
    };
    let part = |voxel: [usize; 3]| {
        let along_axis = |axis: usize, n: usize| voxel[axis] as f64 - 0.5 + (n as f64 + 0.5) / POINTS as f64;
        let point = |n: usize| [along_axis(0, n % POINTS), along_axis(1, n / POINTS % POINTS), along_axis(2, n / POINTS.pow(2))];
        (0..POINTS.pow(3)).filter(|n| is_inside(point(*n))).count() as f64 / POINTS.pow(3) as f64
    };
    let empty = Map { shape, values: vec![0.0; shape.iter().product()] };
    // Points are counted only where the tube may be.
    let near = |at: Point| norm_squared(sub(at, middle)) - dot(sub(at, middle), along).powi(2) < (radius + 1.0).powi(2);
    (empty.with(|voxel, _| if near(voxel.map(|x| x as f64)) { part(voxel) } else { 0.0 }), middle, along)
}

/// The median of the radii in the middle of a tube.
fn radius_of(mask: &Mask, middle: Point, along: Point) -> f64 {
    let Traced { lines, .. } = lines(mask);
    let is_central = |at: &Point| dot(sub(at.map(|x| x * 1e3), middle), along).abs() < 10.0;
    median(lines.points.iter().zip(&lines.radii).filter(|(at, _)| is_central(at)).map(|(_, radius)| radius * 1e3).collect())
}

#[test]
fn a_tube_thinner_than_two_voxels_has_its_radius_from_the_map_and_not_from_the_mask() {
    let mut draw = Draw::new(3);
    for (radius, level) in [(0.8, 0.5), (0.8, 0.3), (1.3, 0.5)] {
        let (mut of_map, mut of_mask) = (Vec::new(), Vec::new());
        for _ in 0..10 {
            let (map, middle, along) = tube(&mut draw, radius);
            let mut mask = map.read(Some(level), false);
            of_map.push(radius_of(&mask, middle, along) / radius);
            mask.walls = None;
            of_mask.push(radius_of(&mask, middle, along) / radius);
        }
        assert!(of_map.iter().all(|ratio| (ratio - 1.0).abs() < 0.03), "{radius}, {level}: {of_map:?}");
        let ratio = median(of_mask.clone());
        assert!((ratio - 1.0).abs() > 0.03, "{radius}, {level}: {of_mask:?}");
    }
}

#[test]
fn an_image_on_a_bright_background_gives_the_radii_of_the_map() {
    let (map, middle, along) = tube(&mut Draw::new(5), 1.2);
    let truth = radius_of(&map.read(Some(0.5), false), middle, along);
    for (outside, inside) in [(100.0, 400.0), (0.2, 0.8), (-1000.0, 300.0)] {
        let image = map.with(|_, part| outside + (inside - outside) * part);
        let mask = image.read(Some(f64::midpoint(outside, inside)), false);
        let walls = mask.walls.as_ref().expect("walls").values;
        assert!((walls[0] - outside).abs() < 1e-4 && (walls[1] - inside).abs() < 1e-4, "{walls:?}");
        let found = radius_of(&mask, middle, along);
        assert!((found / truth - 1.0).abs() < 1e-4, "{outside} to {inside}: {found} {truth}");
    }
}

#[test]
fn haze_that_no_vessel_touches_does_not_count() {
    let (map, ..) = tube(&mut Draw::new(6), 1.5);
    let is_near = |[x, y, z]: [usize; 3]| {
        let around = |at: usize, n: usize| at.saturating_sub(2)..(at + 3).min(map.shape[n]);
        around(z, 2).any(|c| around(y, 1).any(|b| around(x, 0).any(|a| map.at([a, b, c]) >= 0.5)))
    };
    let hazy = map.with(|at, part| if is_near(at) { part } else { 0.4 });
    assert!(hazy.values.iter().filter(|part| **part == 0.4).count() > 1000);
    let (clear, hazy) = (lines(&map.read(Some(0.5), false)), lines(&hazy.read(Some(0.5), false)));
    assert_eq!(clear.lines.points, hazy.lines.points);
    assert_eq!(clear.lines.radii, hazy.lines.radii);
}

#[test]
fn a_mask_has_no_partial_volume_whatever_its_classes_and_the_level() {
    let (map, ..) = tube(&mut Draw::new(7), 1.5);
    let binary = map.with(|_, part| f64::from(u8::from(part >= 0.5)));
    let truth = lines(&binary.read(None, false)).lines;
    let several = map.with(|[x, ..], part| if part >= 0.5 { 1.0 + (x % 3) as f64 } else { 0.0 });
    for (map, level) in [(&binary, 0.5), (&several, 1.0), (&several, 0.5)] {
        let mask = map.read(Some(level), false);
        assert_eq!(mask.walls, None);
        let found = lines(&mask).lines;
        assert_eq!((&found.points, &found.radii), (&truth.points, &truth.radii));
    }
}

#[test]
fn the_order_and_the_direction_of_the_axes_do_not_matter() {
    let (map, ..) = tube(&mut Draw::new(8), 1.2);
    let truth = map.read(Some(0.5), false).in_scanner_order();
    let other = map.read(Some(0.5), true).in_scanner_order();
    assert_eq!((&truth.classes, &truth.walls), (&other.classes, &other.walls));
    let last = map.shape[0] - 1;
    let mut mirrored = map.with(|[x, y, z], _| map.at([last - x, y, z])).read(Some(0.5), false);
    mirrored.affine[0] = [-1.0, 0.0, 0.0, last as f64];
    let mirrored = mirrored.in_scanner_order();
    assert_eq!(truth.walls, mirrored.walls);
    assert_eq!(places(&lines(&truth)), places(&lines(&mirrored)));
    // Each voxel has its own part still.
    let walls = truth.walls.expect("walls");
    let [x, y, _] = truth.shape;
    for (row, part) in walls.voxels {
        let [a, b, c] = [row as usize % x, row as usize / x % y, row as usize / (x * y)];
        assert_eq!(part, map.at([c, b, a]) as f32);
    }
}

#[test]
fn only_the_wall_counts_in_part_between_outside_and_inside() {
    // Random values in images of few slices: the wall and its surroundings by their definition, voxel by voxel.
    let mut kinds = [0; 2];
    for (seed, shape) in (0_u64..).zip([[7, 6, 5], [9, 4, 1], [1, 1, 60], [5, 8, 2], [21, 20, 19], [1, 40, 3]]) {
        let mut draw = Draw::new(seed);
        let base = [0.0, 0.3][seed as usize % 2];
        let mut values: Vec<f64> =
            (0..shape.iter().product()).map(|_| base + (1.0 - base) * draw.within(0.0, 1.0).powi(30)).collect();
        values[0] = 0.75;
        let map = Map { shape, values };
        let walls = map.read(Some(0.5), false).walls.expect("walls");
        let touches = |at: [usize; 3], reach: usize, vessel: bool| {
            let around = |axis: usize| at[axis].saturating_sub(reach)..(at[axis] + reach + 1).min(shape[axis]);
            around(2).any(|c| around(1).any(|b| around(0).any(|a| (map.at([a, b, c]) >= 0.5) == vessel)))
        };
        let voxels = || (0..map.values.len()).map(|row| [row % shape[0], row / shape[0] % shape[1], row / (shape[0] * shape[1])]);
        let second = voxels().filter(|at| touches(*at, 2, true) && !touches(*at, 1, true)).map(|at| map.at(at)).collect();
        let around = median(second);
        let [outside, inside] = if around <= 0.05 { [0.0, 1.0] } else { [around, 1.0 - around] };
        kinds[usize::from(around <= 0.05)] += 1;
        assert!((walls.values[0] - outside).abs() < 1e-6 && (walls.values[1] - inside).abs() < 1e-6, "seed {seed}: {walls:?}");
        let mut found = walls.voxels.iter().copied().peekable();
        for (row, at) in voxels().enumerate() {
            let is_vessel = map.at(at) >= 0.5;
            let whole = f64::from(u8::from(is_vessel));
            let part = ((map.at(at) - outside) / (inside - outside)).clamp(0.0, 1.0);
            let expected = if touches(at, 1, !is_vessel) { part } else { whole };
            let part = found.next_if(|(voxel, _)| *voxel as usize == row).map_or(whole, |(_, part)| f64::from(part));
            assert!((part - expected).abs() < 1e-5, "seed {seed}, voxel {at:?}: {part} {expected}");
        }
        assert_eq!(found.next(), None);
    }
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
}
