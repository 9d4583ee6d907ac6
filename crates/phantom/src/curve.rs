//! A smooth curve of a given length between two points: a sine wave in a plane through the chord.

use std::f64::consts::PI;

use willis_core::support::{Point, arc_lengths::place_at, distance, dot, lerp, norm_squared, sub, unit};

/// The side to which a vessel curves, and how often it swings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bow {
    /// The direction of the first swing; only its part across the chord counts.
    pub side: [f64; 3],
    /// Half waves between the two ends, at least 1.
    pub swings: u32,
}

/// Points at equal steps of about `spacing` (m) from `a` to `b` along a polyline of arc length `length` (m).
///
/// p(s) = a + s (b - a) + h sin(kπs) n, where n is the unit vector of the bow's side across the chord and k the number of swings.
/// The length grows with the amplitude h. Bisection finds h to the last bit, for the length of the polyline, not of the smooth curve.
/// Each swing has at least four steps, which keeps the shape of the wave.
///
/// # Panics
///
/// When `length` is below the distance between the ends, or when the bow's side points along the chord.
pub fn course(a: Point, b: Point, length: f64, bow: Bow, spacing: f64) -> Vec<Point> {
    let chord = distance(a, b);
    assert!(length >= chord, "a course of {length} m cannot span {chord} m");
    let along = unit(sub(b, a));
    let side = unit(sub(bow.side, along.map(|x| x * dot(bow.side, along))));
    assert!(norm_squared(side) > 0.5, "the side {:?} of a bow is along its chord", bow.side);

    let steps = ((length / spacing).ceil() as usize).max(4 * bow.swings as usize);
    let wave = |s: f64| if s > 0.0 && s < 1.0 { (f64::from(bow.swings) * PI * s).sin() } else { 0.0 };
    let fine: Vec<f64> = (0..=16 * steps).map(|i| i as f64 / (16 * steps) as f64).collect();
    let shares = equal_steps(&fine, chord, amplitude(&fine, chord, length, wave), wave, steps);
    let height = amplitude(&shares, chord, length, wave);
    (shares.iter().enumerate())
        .map(|(i, s)| {
            let on_chord = if i == steps { b } else { lerp(a, b, *s) };
            [0, 1, 2].map(|axis| on_chord[axis] + height * wave(*s) * side[axis])
        })
        .collect()
}

/// The arc length at each share of the chord.
fn arc(shares: &[f64], chord: f64, height: f64, wave: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut total = 0.0;
    let steps = shares.windows(2).map(|s| {
        total += (chord * (s[1] - s[0])).hypot(height * (wave(s[1]) - wave(s[0])));
        total
    });
    std::iter::once(0.0).chain(steps).collect()
}

/// The amplitude that gives the polyline through these shares of the chord its length.
fn amplitude(shares: &[f64], chord: f64, length: f64, wave: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, length);
    let mut middle = 0.5 * (low + high);
    // Until no number lies between; not even once where a figure is none.
    while low < middle && middle < high {
        if arc(shares, chord, middle, &wave)[shares.len() - 1] > length {
            high = middle;
        } else {
            low = middle;
        }
        middle = 0.5 * (low + high);
    }
    low
}

/// The shares of the chord at which the fine polyline's arc length is cut into equal steps.
fn equal_steps(fine: &[f64], chord: f64, height: f64, wave: impl Fn(f64) -> f64, steps: usize) -> Vec<f64> {
    let at = arc(fine, chord, height, wave);
    (0..=steps)
        .map(|i| {
            let (row, share) = place_at(&at, at[at.len() - 1] * i as f64 / steps as f64);
            if i == steps { 1.0 } else { fine[row] + share * (fine[row + 1] - fine[row]) }
        })
        .collect()
}
