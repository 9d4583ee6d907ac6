//! When the pulse arrives: the feet of the pressure waves by intersecting tangents, followed from the inlets along the vessels.

use std::cell::Cell;

use num_complex::Complex64;

use super::fourier::{at, behind, derivative, samples};
use super::{Drive, Setting};
use crate::{network::ShortestPaths, support::marked};

/// Even times of a period among which rises are looked for.
const TIMES: usize = 1000;
/// A rise counts where it is at least this share as steep as the steepest.
const STEEP: f64 = 0.5;
/// What is below this share of the largest amplitude is rounding, and no wave.
const ROUNDING: f64 = 1e-9;

/// By at most this share of the period a reflection brings a foot before the one upstream; what rises earlier still is another wave.
const EARLY: f64 = 0.01;

/// A rise of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rise {
    /// Where the tangent at its steepest place meets the horizontal through the minimum before it, s; not before -T.
    pub foot: f64,
    /// The slope there, unit of the signal per s.
    pub slope: f64,
}

/// The rises of a signal of period T (s) that are steep: none of a constant one.
///
/// The foot is that of intersecting tangents (Chiu et al. 1991; Gaddum et al. 2013): the tangent at the steepest place, and the lowest value in the
/// half period before. Lanczos's factors sin(x)/x, x = πn/(H + 1), are put on the harmonics first: the steepest place of a sum that was cut off at H
/// would be a ripple (Gibbs). They delay nothing.
pub fn rises(coefficients: &[Complex64], period: f64) -> Vec<Rise> {
    let smooth = |(n, c): (usize, &Complex64)| {
        let x = std::f64::consts::PI * n as f64 / coefficients.len() as f64;
        if n == 0 { *c } else { c * (x.sin() / x) }
    };
    let signal: Vec<Complex64> = coefficients.iter().enumerate().map(smooth).collect();
    let slope = derivative(&signal, period);
    let (bend, twist) = (derivative(&slope, period), derivative(&derivative(&slope, period), period));
    let (values, slopes) = (samples(&signal, TIMES), samples(&slope, TIMES));
    let step = period / TIMES as f64;
    let highest = slopes.iter().copied().fold(0.0, f64::max);
    // Between the times Newton's method finds where a derivative is zero.
    let refined = |k: usize, first: &[Complex64], second: &[Complex64]| {
        let middle = k as f64 * step;
        let next = |t: f64| t - at(first, t, period) / at(second, t, period);
        let found = (0..3).fold(middle, |t, _| next(t));
        if (found - middle).abs() <= step { found } else { middle }
    };
    let is_top = |k: &usize| {
        let [before, here, after] = [k + TIMES - 1, *k, k + 1].map(|k| slopes[k % TIMES]);
        here > 0.0 && here >= STEEP * highest && here >= before && here > after
    };
    let rise = |k: usize| {
        let steepest = refined(k, &bend, &twist);
        let lower = |best: usize, back: usize| {
            if values[(k + TIMES - back) % TIMES] < values[(k + TIMES - best) % TIMES] { back } else { best }
        };
        let lowest = (k + TIMES - (0..TIMES / 2).fold(0, lower)) % TIMES;
        let low = at(&signal, refined(lowest, &slope, &bend), period);
        let slope = at(&slope, steepest, period);
        Rise { foot: steepest - (at(&signal, steepest, period) - low) / slope, slope }
    };
    (0..TIMES).filter(is_top).map(rise).collect()
}

/// By how much the foot at a place is behind that upstream, s, where a wave of speed c₀ takes the time `travel`: of the `rises` there the one
/// nearest to where the wave is expected, but none before it left. At least zero; `travel` where there is none.
fn delay(rises: &[Rise], upstream: f64, travel: f64, period: f64) -> f64 {
    let late = rises.iter().map(|rise| travel + behind(rise.foot, upstream + travel, period));
    let nearest = late.filter(|late| *late >= -EARLY * period).min_by(|a, b| (a - travel).abs().total_cmp(&(b - travel).abs()));
    nearest.map_or(travel, |late| late.max(0.0))
}

/// When the wave arrives, s.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrivals {
    /// The foot at the inlet where it comes first; NaN where no inlet has one.
    pub first: f64,
    /// By node the foot, counted on from the period of `first`; NaN where none is.
    pub nodes: Vec<f64>,
    /// By row the same in the middle of the vessel.
    pub vessels: Vec<f64>,
}

impl Arrivals {
    /// Follows the wave from each drive with the speed c₀ of the vessels between `ends`, over pressures of nodes and, after them, of the
    /// middles of vessels.
    ///
    /// A signal may have several rises: its own, those of other inlets, and those that come back. The foot is that which lies nearest to where
    /// the wave from upstream is expected, and not before the one upstream; upstream is where the wave comes from first.
    pub fn follow(ends: &[[usize; 2]], setting: &Setting<'_>, pressure: &[Option<&[Complex64]>]) -> Self {
        let (period, places) = (setting.period, pressure.len());
        let nodes = places - ends.len();
        let signal = |place: usize| pressure[place];
        let amplitude = |signal: &[Complex64]| signal[1..].iter().map(|c| c.norm()).fold(0.0, f64::max);
        let largest = (0..places).filter_map(signal).map(amplitude).fold(0.0, f64::max);
        let moves = |place: usize| signal(place).filter(|signal| amplitude(signal) > ROUNDING * largest);

        let own = |drive: &Drive| {
            let steepest = rises(&drive.coefficients, period).into_iter().max_by(|a, b| a.slope.total_cmp(&b.slope))?;
            moves(drive.node).map(|_| (drive.node, steepest.foot))
        };
        let mut starts: Vec<(usize, f64)> = setting.drives.iter().filter_map(own).collect();
        let reference = starts.first().map_or(f64::NAN, |(_, foot)| foot.rem_euclid(period));
        let risen: Vec<Vec<Rise>> = (0..places).map(|place| moves(place).map_or_else(Vec::new, |s| rises(s, period))).collect();
        for (node, foot) in &mut starts {
            let driven = reference + behind(*foot, reference, period);
            let late = risen[*node].iter().map(|rise| behind(rise.foot, driven, period));
            *foot = driven + late.min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
        }
        let first = starts.iter().map(|(_, foot)| *foot).fold(f64::NAN, f64::min);
        let is_start = marked(places, starts.iter().map(|(node, _)| *node));

        let mut steps: Vec<Vec<(usize, f64)>> = vec![Vec::new(); places];
        for (row, [a, b]) in ends.iter().enumerate().filter(|(row, _)| pressure[nodes + row].is_some()) {
            for (node, half) in [*a, *b].into_iter().zip(&setting.vessels[row].halves) {
                let time = half.iter().map(|segment| segment.length / segment.wave_speed(setting.fluid)).sum();
                steps[node].push((nodes + row, time));
                steps[nodes + row].push((node, time));
            }
        }
        // From one place before all inlets, to each of them in the time by which its wave begins later, and on from foot to foot, so that
        // a place has the wave that comes first. A wave does not pass what keeps still.
        let foot = Cell::new(first);
        let edges = |place: usize| {
            let (foot, risen, is_start) = (foot.get(), &risen, &is_start);
            let from_start = starts.iter().filter(move |_| place == places).map(move |(node, foot)| (*node, *node, foot - first));
            let on = steps.get(place).filter(|_| place < places).into_iter().flatten();
            let on = on.filter(move |(next, _)| !is_start[*next] && !risen[*next].is_empty());
            from_start.chain(on.map(move |(next, time)| (*next, *next, delay(&risen[*next], foot, *time, period))))
        };
        let mut feet = vec![f64::NAN; places];
        ShortestPaths::new(places + 1).search(&[places], f64::INFINITY, edges, |times, place| {
            foot.set(first + times[place]);
            if let Some(own) = feet.get_mut(place) {
                *own = foot.get();
            }
            true
        });
        let vessels = feet.split_off(nodes);
        Self { first, nodes: feet, vessels }
    }
}
