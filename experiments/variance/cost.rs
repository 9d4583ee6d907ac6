//! What the schemes cost: serial time of a run of blocks, the fastest of a few.

use std::hint::black_box;
use std::time::Instant;

use crate::masks::{Masks, Scheme};
use crate::model::{Model, Work};
use crate::moments::{Control, Moments};

const BLOCKS: u64 = 32;
const TRIES: usize = 5;

pub struct Cost {
    draw: [f64; Scheme::ALL.len()],
    solve: f64,
    neighbours: f64,
    all: f64,
}

impl Cost {
    pub fn measure(model: &Model) -> Self {
        let mut work = Work::default();
        let draw = Scheme::ALL.map(|scheme| {
            let mut masks = Masks::new(scheme, &model.keep, 0);
            fastest(|block| masks.draw(block, &mut work.masks))
        });
        let mut masks = Vec::new();
        Masks::new(Scheme::Plain, &model.keep, 0).draw(0, &mut masks);
        work.masks = masks;
        let mut sum = vec![0.0; model.vessels()];
        let solve = fastest(|_| model.solve(&mut work, |_, vessel, y| sum[vessel] += y));
        let mut moments = Moments::of(model, 0, 0);
        let all = fastest(|_| moments.add_block(model, &mut work)) - solve;
        let masks = work.masks.clone();
        let mut cross: Vec<Vec<(f64, u32)>> = model.neighbours.iter().map(|n| vec![(0.0, 0); n.len()]).collect();
        let neighbours = fastest(|_| {
            model.solve(&mut work, |sample, vessel, y| {
                for (sum, other) in cross[vessel].iter_mut().zip(&model.neighbours[vessel]) {
                    sum.0 += y * (masks[*other] >> sample & 1) as f64;
                }
            });
            for ((row, around), mask) in cross.iter_mut().zip(&model.neighbours).zip(&masks) {
                row.iter_mut().zip(around).for_each(|(sum, other)| sum.1 += (mask & masks[*other]).count_ones());
            }
        }) - solve;
        black_box((sum, moments, cross));
        Self { draw, solve, neighbours: neighbours.max(0.0), all: all.max(0.0) }
    }

    /// The time of a sample over that of a plain one.
    pub fn relative(&self, scheme: Scheme, control: Control) -> f64 {
        let extra = match control {
            Control::None | Control::Own => 0.0,
            Control::Neighbours | Control::OpenNeighbours => self.neighbours,
            Control::All | Control::OpenAll => self.all,
        };
        (self.draw[scheme as usize] + self.solve + extra) / (self.draw[0] + self.solve)
    }

    /// Microseconds of a plain sample.
    pub fn plain_sample(&self) -> f64 {
        (self.draw[0] + self.solve) / (BLOCKS * 64) as f64 * 1e6
    }
}

fn fastest(mut step: impl FnMut(u64)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..TRIES {
        let start = Instant::now();
        (0..BLOCKS).for_each(&mut step);
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}
