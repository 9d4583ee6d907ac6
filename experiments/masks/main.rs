//! Radii of tubes whose radius is known, by each rule, and time and memory of a dense mask or map: `masks radii`, `masks dense`, `masks dense-map`, and
//! `masks volume MASK...` for the volume of the lines over that of the mask.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;
use std::time::Instant;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use willis::Scale;
use willis::internals::formats::{Format, ReadOptions};
use willis::internals::masks::{Affine, Cavities, Foreground, Mask, RadiusFrom, Traced, distances, thin, trace};
use willis::internals::support::geometry::{Point, distance, dot, norm_squared, sub, unit};
use willis::internals::support::random::stream;
use willis::internals::support::statistics::{median, quantile};

const RULES: [RadiusFrom; 3] = [RadiusFrom::Area, RadiusFrom::Distance, RadiusFrom::Inscribed];
/// Radii in voxels.
const WIDTHS: [f64; 7] = [0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0];
/// Shapes of voxels, mm.
const SPACINGS: [[f64; 3]; 3] = [[1.0; 3], [1.0, 1.0, 1.6], [0.5, 0.5, 0.8]];
/// Tubes for each width and shape.
const TUBES: usize = 20;

fn affine_of([a, b, c]: [f64; 3]) -> Affine {
    [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, 0.0], [0.0, 0.0, c, 0.0]]
}

/// A NumPy array, the first axis fastest.
fn npy([x, y, z]: [usize; 3], values: impl Iterator<Item = f32>) -> Vec<u8> {
    let text = format!("{{'descr': '<f4', 'fortran_order': True, 'shape': ({x}, {y}, {z}), }}");
    let mut file = Vec::with_capacity(128 + 4 * x * y * z);
    file.extend(b"\x93NUMPY\x01\x00\x76\x00");
    file.extend(format!("{text:117}\n").bytes());
    file.extend(values.flat_map(f32::to_le_bytes));
    file
}

/// A straight tube in an image of voxels; mm.
struct Tube {
    shape: [usize; 3],
    spacing: [f64; 3],
    middle: Point,
    along: Point,
    radius: f64,
    length: f64,
}

impl Tube {
    /// At a random angle and place.
    fn draw(draw: &mut ChaCha8Rng, spacing: [f64; 3], radius: f64, length: f64) -> Self {
        let along = unit(loop {
            let toward: Point = std::array::from_fn(|_| draw.random_range(-1.0..1.0));
            if (0.01..1.0).contains(&norm_squared(toward)) {
                break toward;
            }
        });
        let half: Point = std::array::from_fn(|axis| along[axis].abs() * length / 2.0 + radius + 3.0 * spacing[axis]);
        let shape: [usize; 3] = std::array::from_fn(|axis| (2.0 * half[axis] / spacing[axis]) as usize + 1);
        let middle: Point = std::array::from_fn(|axis| half[axis] + draw.random_range(-0.5..0.5) * spacing[axis]);
        Self { shape, spacing, middle, along, radius, length }
    }

    /// How far a point lies inside the wall and between the ends.
    fn depth(&self, at: Point) -> f64 {
        let by = sub(at, self.middle);
        let on = dot(by, self.along);
        (self.length / 2.0 - on.abs()).min(self.radius - (norm_squared(by) - on * on).max(0.0).sqrt())
    }

    fn centre(&self, row: usize) -> Point {
        let [x, y, _] = self.shape;
        let voxel = [row % x, row / x % y, row / (x * y)];
        std::array::from_fn(|axis| voxel[axis] as f64 * self.spacing[axis])
    }

    /// The mask of the voxels whose centre is inside.
    fn mask(&self) -> Mask {
        let is = |row| u8::from(self.depth(self.centre(row)) >= 0.0);
        let classes = (0..self.shape.iter().product()).map(is).collect();
        Mask::new(self.shape, classes, affine_of(self.spacing))
    }

    /// The part of each voxel that is inside, by points in it.
    fn parts(&self) -> Vec<f64> {
        const POINTS: usize = 8;
        let corner = norm_squared(self.spacing).sqrt() / 2.0;
        let part = |row| {
            let centre = self.centre(row);
            let depth = self.depth(centre);
            if depth.abs() > corner {
                return f64::from(u8::from(depth > 0.0));
            }
            let at = |n: usize, axis: usize| ((n as f64 + 0.5) / POINTS as f64 - 0.5) * self.spacing[axis];
            let point = |n: usize| {
                let by = [at(n % POINTS, 0), at(n / POINTS % POINTS, 1), at(n / (POINTS * POINTS), 2)];
                [0, 1, 2].map(|axis| centre[axis] + by[axis])
            };
            let inside = (0..POINTS.pow(3)).filter(|n| self.depth(point(*n)) >= 0.0).count();
            inside as f64 / POINTS.pow(3) as f64
        };
        (0..self.shape.iter().product()).map(part).collect()
    }

    /// The same blurred by a Gaussian whose standard deviation is half a voxel along each axis.
    fn blurred(&self, mut parts: Vec<f64>) -> Vec<f64> {
        let weights: Vec<f64> = (-3..=3).map(|n| (-2.0 * f64::from(n * n)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let mut stride = 1;
        for length in self.shape {
            let at = |row: usize, by: usize| {
                (row / stride % length + by).checked_sub(3).filter(|n| *n < length).map(|_| row + by * stride)
            };
            let sum = |row: usize| {
                let near = (0..7).filter_map(|by| at(row, by).map(|to| weights[by] * parts[to - 3 * stride]));
                near.sum::<f64>() / total
            };
            parts = (0..parts.len()).map(sum).collect();
            stride *= length;
        }
        parts
    }

    /// What is read of a file of probabilities.
    fn read(&self, parts: &[f64], level: f64) -> Option<Mask> {
        let file = npy(self.shape, parts.iter().map(|part| *part as f32));
        read_npy(&file, self.spacing, level)
    }

    /// The median of found over true radius around the middle; none where no line is there.
    fn ratio(&self, mask: &Mask, rule: RadiusFrom) -> Option<f64> {
        let lines = trace(mask, rule, Cavities::Fill)?.lines;
        let near = 10.0 * self.spacing.iter().product::<f64>().cbrt();
        let central = lines
            .points
            .iter()
            .zip(&lines.radii)
            .filter(|(at, _)| dot(sub(at.map(|x| x * 1e3), self.middle), self.along).abs() < near);
        median(&central.map(|(_, radius)| radius * 1e3 / self.radius).collect::<Vec<_>>())
    }
}

/// For each width and rule the median of found over true radius, and half the span from the 5th to the 95th percentile over tubes; the
/// radii by area of maps of probabilities too, as they are and as masks cut from them.
fn radii() {
    println!("width,image,rule,bias_percent,spread_percent,tubes");
    for (row, wide) in WIDTHS.into_iter().enumerate() {
        let mut found: BTreeMap<(usize, &str, &str), Vec<f64>> = BTreeMap::new();
        for (n, spacing) in SPACINGS.into_iter().enumerate() {
            let mut draw = stream(1, (10 * row + n) as u64);
            let voxel = spacing.iter().product::<f64>().cbrt();
            for _ in 0..TUBES {
                let tube = Tube::draw(&mut draw, spacing, wide * voxel, (40.0 * voxel).max(8.0 * wide * voxel));
                let mask = tube.mask();
                for (place, rule) in RULES.into_iter().enumerate() {
                    found.entry((place, "mask", rule.name())).or_default().extend(tube.ratio(&mask, rule));
                }
                let parts = tube.parts();
                let blurred = tube.blurred(parts.clone());
                for (place, (image, cut, parts, level)) in [
                    ("map at 0.5", "mask cut at 0.5", &parts, 0.5),
                    ("map at 0.3", "mask cut at 0.3", &parts, 0.3),
                    ("blurred map at 0.3", "mask of it cut at 0.3", &blurred, 0.3),
                ]
                .into_iter()
                .enumerate()
                {
                    let Some(mut mask) = tube.read(parts, level) else { continue };
                    let place = RULES.len() + 2 * place;
                    let ratio = tube.ratio(&mask, RadiusFrom::Area);
                    found.entry((place, image, "area")).or_default().extend(ratio);
                    mask.walls = None;
                    let ratio = tube.ratio(&mask, RadiusFrom::Area);
                    found.entry((place + 1, cut, "area")).or_default().extend(ratio);
                }
            }
        }
        for ((_, image, rule), found) in found {
            let at = |q: f64| quantile(&found, q).unwrap_or(f64::NAN);
            let (bias, spread) = (100.0 * (at(0.5) - 1.0), 50.0 * (at(0.95) - at(0.05)));
            println!("{wide},\"{image}\",{rule},{bias:.1},{spread:.1},{}", found.len());
        }
    }
}

/// The most memory that this process has had, bytes; none where the system does not say.
fn most_memory() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0)
}

/// A solid ellipsoid that fills half of 256³ voxels, as a mask or as a map of probabilities: the time of each step, and bytes a voxel
/// beyond the mask, and beyond the map's own file.
fn dense(is_map: bool) {
    const N: usize = 256;
    let at = |n: usize| n as f64 - (N as f64 - 1.0) / 2.0;
    let depth = |row: usize| {
        let p = [at(row % N), at(row / N % N), at(row / (N * N))];
        126.0 - norm_squared([p[0], p[1] * 1.015, p[2] * 1.005]).sqrt()
    };
    let (spacing, rows) = ([0.5, 0.5, 0.8], 0..N * N * N);
    let file = if is_map { npy([N; 3], rows.clone().map(|row| (depth(row) + 0.5).clamp(0.0, 1.0) as f32)) } else { Vec::new() };
    let started = Instant::now();
    let mut before = most_memory();
    let mask = if is_map {
        let Some(mask) = read_npy(&file, spacing, 0.5) else { return };
        println!("reading a map: {:.1} s", started.elapsed().as_secs_f64());
        before = before.map(|before| before + mask.classes.len() as f64);
        mask
    } else {
        let classes = rows.map(|row| u8::from(depth(row) >= 0.0)).collect();
        let mask = Mask::new([N; 3], classes, affine_of(spacing));
        before = most_memory();
        mask
    };
    let started = Instant::now();
    let Some(vessels) = Foreground::of(&mask) else { return };
    let kept = thin(&vessels).len();
    println!("thinning: {:.1} s for {} voxels, {kept} of which stay", started.elapsed().as_secs_f64(), vessels.count());
    let started = Instant::now();
    drop(distances(&vessels, mask.spacing()));
    println!("distance: {:.1} s", started.elapsed().as_secs_f64());
    drop(vessels);
    let started = Instant::now();
    drop(trace(&mask, RadiusFrom::Area, Cavities::Fill));
    println!("mask to lines: {:.1} s", started.elapsed().as_secs_f64());
    match most_memory().zip(before) {
        Some((all, before)) => println!("memory: {:.1} bytes a voxel beyond the mask", (all - before) / (N * N * N) as f64),
        None => println!("memory: not known on this system"),
    }
}

/// The mask in a NumPy file of probabilities.
fn read_npy(file: &[u8], spacing: [f64; 3], level: f64) -> Option<Mask> {
    let scale = Scale { spacing: Some(spacing), ..Scale::default() };
    let options = ReadOptions { scale, level: Some(level), max_input: u64::MAX, ..ReadOptions::default() };
    Format::Npy.read_mask(Path::new("a.npy"), file, &options).ok()
}

/// The volume of the lines and of the mask, mm³, and the time for the lines, alone and with reading.
fn volume(path: &Path) -> Result<()> {
    let started = Instant::now();
    let options = ReadOptions::default();
    let mask = Format::Nifti.read_mask(path, &fs::read(path)?, &options).map_err(Error::other)?;
    let voxels = mask.classes.iter().filter(|class| **class > 0).count() as f64 * mask.voxel_volume();
    let mask = mask.in_scanner_order();
    let drawing = Instant::now();
    let Some(Traced { lines, .. }) = trace(&mask, RadiusFrom::Area, Cavities::Fill) else { return Ok(()) };
    let (drawing, seconds) = (drawing.elapsed().as_secs_f64(), started.elapsed().as_secs_f64());
    let of = |[a, b]: &[u32; 2]| {
        let (r, s) = (lines.radii[*a as usize], lines.radii[*b as usize]);
        PI * (r * r + r * s + s * s) / 3.0 * distance(lines.points[*a as usize], lines.points[*b as usize])
    };
    let total = lines.links.iter().map(of).sum::<f64>() * 1e9;
    let name = path.file_name().unwrap_or_default().display();
    println!("{name},{total:.0},{voxels:.0},{:.3},{drawing:.2},{seconds:.2}", total / voxels);
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["radii"] => radii(),
        ["dense"] => dense(false),
        ["dense-map"] => dense(true),
        ["volume", ref masks @ ..] => {
            println!("mask,lines_mm3,mask_mm3,ratio,lines_s,read_and_lines_s");
            masks.iter().try_for_each(|mask| volume(Path::new(mask)))?;
        }
        _ => return Err(Error::new(ErrorKind::InvalidInput, "expected radii, dense, dense-map, or volume MASK...")),
    }
    Ok(())
}
