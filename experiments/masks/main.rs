//! Radii of tubes whose radius is known, by each rule, and time and memory of a dense mask: `masks radii`, `masks dense`, and
//! `masks volume MASK...` for the volume of the lines over that of the mask.

use std::f64::consts::PI;
use std::fs;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;
use std::time::Instant;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use willis::internals::io::{ReadOptions, read_nifti};
use willis::internals::masks::{Foreground, Mask, RadiusFrom, Traced, distances, thin, trace};
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

/// A mask, the middle of the tube in it and its direction, mm. A voxel is inside where its centre is.
fn tube(draw: &mut ChaCha8Rng, spacing: [f64; 3], radius: f64, length: f64) -> (Mask, Point, Point) {
    let along = unit(loop {
        let toward: Point = std::array::from_fn(|_| draw.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&norm_squared(toward)) {
            break toward;
        }
    });
    let half: Point = std::array::from_fn(|axis| along[axis].abs() * length / 2.0 + radius + 3.0 * spacing[axis]);
    let shape: [usize; 3] = std::array::from_fn(|axis| (2.0 * half[axis] / spacing[axis]) as usize + 1);
    let middle: Point = std::array::from_fn(|axis| half[axis] + draw.random_range(-0.5..0.5) * spacing[axis]);
    let is = |row: usize| {
        let p = [row % shape[0], row / shape[0] % shape[1], row / (shape[0] * shape[1])];
        let by = sub(std::array::from_fn(|axis| p[axis] as f64 * spacing[axis]), middle);
        let on = dot(by, along);
        u8::from(on.abs() <= length / 2.0 && norm_squared(by) - on * on <= radius * radius)
    };
    let classes = (0..shape.iter().product()).map(is).collect();
    let [a, b, c] = spacing;
    (Mask { shape, classes, affine: [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, 0.0], [0.0, 0.0, c, 0.0]], walls: None }, middle, along)
}

/// For each width and rule the median of found over true radius, and half the span from the 5th to the 95th percentile over tubes.
fn radii() {
    println!("width,rule,bias_percent,spread_percent");
    for (row, wide) in WIDTHS.into_iter().enumerate() {
        let mut found: [Vec<f64>; 3] = Default::default();
        for (n, spacing) in SPACINGS.into_iter().enumerate() {
            let mut draw = stream(1, (10 * row + n) as u64);
            let voxel = spacing.iter().product::<f64>().cbrt();
            for _ in 0..TUBES {
                let radius = wide * voxel;
                let (mask, middle, along) = tube(&mut draw, spacing, radius, (40.0 * voxel).max(8.0 * radius));
                for (rule, found) in RULES.into_iter().zip(&mut found) {
                    let Some(traced) = trace(&mask, rule) else { continue };
                    let points = traced.lines.points.iter().zip(&traced.lines.radii);
                    let central = points.filter(|(p, _)| dot(sub(p.map(|x| x * 1e3), middle), along).abs() < 10.0 * voxel);
                    let ratios: Vec<f64> = central.map(|(_, r)| r * 1e3 / radius).collect();
                    found.extend(median(&ratios));
                }
            }
        }
        for (rule, found) in RULES.into_iter().zip(&found) {
            let at = |q: f64| quantile(found, q).unwrap_or(f64::NAN);
            let (bias, spread) = (100.0 * (at(0.5) - 1.0), 50.0 * (at(0.95) - at(0.05)));
            println!("{wide},{},{bias:.1},{spread:.1}", rule.name());
        }
    }
}

/// The most memory that this process has had, bytes; none where the system does not say.
fn most_memory() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0)
}

/// A solid ellipsoid that fills half of 256³ voxels: the time of each step, and bytes a voxel beyond the mask.
fn dense() {
    const N: usize = 256;
    let at = |n: usize| n as f64 - (N as f64 - 1.0) / 2.0;
    let is = |row: usize| {
        let p = [at(row % N), at(row / N % N), at(row / (N * N))];
        u8::from(norm_squared([p[0], p[1] * 1.015, p[2] * 1.005]).sqrt() <= 126.0)
    };
    let affine = [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.8, 0.0]];
    let mask = Mask { shape: [N; 3], classes: (0..N * N * N).map(is).collect(), affine, walls: None };
    let before = most_memory();
    let started = Instant::now();
    let Some(vessels) = Foreground::of(&mask) else { return };
    let kept = thin(&vessels).len();
    println!("thinning: {:.1} s for {} voxels, {kept} of which stay", started.elapsed().as_secs_f64(), vessels.len());
    let started = Instant::now();
    drop(distances(&vessels, mask.spacing()));
    println!("distance: {:.1} s", started.elapsed().as_secs_f64());
    drop(vessels);
    let started = Instant::now();
    drop(trace(&mask, RadiusFrom::Area));
    println!("mask to lines: {:.1} s", started.elapsed().as_secs_f64());
    match most_memory().zip(before) {
        Some((all, before)) => println!("memory: {:.1} bytes a voxel beyond the mask", (all - before) / (N * N * N) as f64),
        None => println!("memory: not known on this system"),
    }
}

/// The volume of the lines and of the mask, mm³, and the time for the lines, alone and with reading.
fn volume(path: &Path) -> Result<()> {
    let started = Instant::now();
    let options = ReadOptions::default();
    let mask = read_nifti(&fs::read(path)?, None, options.max_input).map_err(|fault| Error::other(fault.in_file(path)))?;
    let voxels = mask.classes.iter().filter(|class| **class > 0).count() as f64 * mask.voxel_volume();
    let mask = mask.in_scanner_order();
    let drawing = Instant::now();
    let Some(Traced { lines, .. }) = trace(&mask, RadiusFrom::Area) else { return Ok(()) };
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
        ["dense"] => dense(),
        ["volume", ref masks @ ..] => {
            println!("mask,lines_mm3,mask_mm3,ratio,lines_s,read_and_lines_s");
            masks.iter().try_for_each(|mask| volume(Path::new(mask)))?;
        }
        _ => return Err(Error::new(ErrorKind::InvalidInput, "expected radii, dense, or volume MASK...")),
    }
    Ok(())
}
