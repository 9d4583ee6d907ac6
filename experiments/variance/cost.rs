//! What the schemes cost: serial time of a run of blocks, the fastest of a few.

use std::hint::black_box;
use std::time::Instant;

use crate::masks::{Masks, Scheme};
use crate::model::{Model, Work};
use crate::moments::{Control, Moments};

const BLOCKS: u64 = 16;
const TRIES: usize = 24;

pub struct Cost {
    draw: Vec<(Scheme, f64)>,
    solve: f64,
    neighbours: f64,
    all: f64,
}

impl Cost {
    /// Of `schemes`, plain first.
    pub fn measure(model: &Model, schemes: &[Scheme]) -> Self {
        let mut work = Work::default();
        let mut draw: Vec<(Scheme, f64)> = schemes.iter().map(|scheme| (*scheme, f64::INFINITY)).collect();
        for (scheme, best) in &mut draw {
            let mut masks = Masks::new(*scheme, &model.keep, 0);
            (0..TRIES).for_each(|_| *best = best.min(time(|block| masks.draw(block, &mut work.masks))));
        }
        Masks::new(Scheme::Plain, &model.keep, 0).draw(0, &mut work.masks);
        let masks = work.masks.clone();
        let mut sum = vec![0.0; model.vessels()];
        let mut moments = Moments::of(model, 0, 0);
        let mut cross: Vec<Vec<(f64, u32)>> = model.neighbours.iter().map(|n| vec![(0.0, 0); n.len()]).collect();
        let (mut solve, mut all, mut neighbours) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        // In turn, so that a busy machine is busy for all of them.
        for _ in 0..TRIES {
            solve = solve.min(time(|_| model.solve(&mut work, |_, vessel, y| sum[vessel] += y)));
            all = all.min(time(|_| moments.add_block(model, &mut work)));
            neighbours = neighbours.min(time(|_| {
                model.solve(&mut work, |sample, vessel, y| {
                    for (sum, other) in cross[vessel].iter_mut().zip(&model.neighbours[vessel]) {
                        sum.0 += y * (masks[*other] >> sample & 1) as f64;
                    }
                });
                for ((row, around), mask) in cross.iter_mut().zip(&model.neighbours).zip(&masks) {
                    row.iter_mut().zip(around).for_each(|(sum, other)| sum.1 += (mask & masks[*other]).count_ones());
                }
            }));
        }
        black_box((sum, moments, cross));
        Self { draw, solve, neighbours: (neighbours - solve).max(0.0), all: (all - solve).max(0.0) }
    }

    /// The time of a sample over that of a plain one.
    pub fn relative(&self, scheme: Scheme, control: Control) -> f64 {
        let extra = match control {
            Control::None | Control::Own => 0.0,
            Control::Neighbours | Control::OpenNeighbours => self.neighbours,
            Control::All | Control::OpenAll => self.all,
        };
        let draw = self.draw.iter().find(|(s, _)| *s == scheme).map_or(f64::NAN, |(_, time)| *time);
        (draw + self.solve + extra) / (self.draw[0].1 + self.solve)
    }

    /// Microseconds of a plain sample.
    pub fn plain_sample(&self) -> f64 {
        (self.draw[0].1 + self.solve) / (BLOCKS * 64) as f64 * 1e6
    }
}

/// Seconds of a run of blocks.
fn time(step: impl FnMut(u64)) -> f64 {
    let start = Instant::now();
    (0..BLOCKS).for_each(step);
    start.elapsed().as_secs_f64()
}
