//! Linear orthogonal arrays of strength 2 (Rao-Hamming): in s^k samples every pair of vessels meets every pair of s levels
//! equally often, so that neither the first nor the second order is left but for what lies inside a level.

use rand::Rng;
use willis::internals::perturbation::Occlusion;
use willis::internals::support::random::stream;

/// The stream that an array is drawn from.
const STREAM: u64 = 1 << 41;

/// An array of s^k samples, s a prime.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    pub levels: u32,
    pub digits: u32,
}

impl Shape {
    pub fn samples(self) -> u64 {
        u64::from(self.levels).pow(self.digits)
    }

    /// How many vessels it can serve: the points of a projective space.
    pub fn vessels(self) -> u64 {
        (self.samples() - 1) / u64::from(self.levels - 1)
    }
}

/// The one array of a seed, its points dealt to the vessels and its levels permuted at random.
pub struct Array {
    shape: Shape,
    columns: Vec<Column>,
    /// Whether the level that is neither open nor closed is open.
    between: Occlusion,
}

struct Column {
    /// Prefix sums of the point's digits: what the level gains when so many digits of the sample's number turn over.
    gains: Vec<u32>,
    /// Bit l: level l is open.
    open: u64,
    /// Bit l: level l is open in some samples.
    between: u64,
}

impl Array {
    pub fn new(shape: Shape, keep: &[f64], seed: u64) -> Self {
        let (s, mut rng) = (shape.levels, stream(seed, STREAM));
        let digits = |number: u64| (0..shape.digits).map(move |d| (number / u64::from(s).pow(d)) as u32 % s);
        let mut points: Vec<u64> = (1..shape.samples()).filter(|p| digits(*p).rfind(|d| *d > 0) == Some(1)).collect();
        let columns = keep.iter().enumerate().map(|(i, keep)| {
            let other = i + below(points.len() - i, &mut rng);
            points.swap(i, other);
            let mut order: Vec<u32> = (0..s).collect();
            (1..order.len()).rev().for_each(|last| order.swap(last, below(last + 1, &mut rng)));
            let always = (keep * f64::from(s)) as usize;
            Column {
                gains: digits(points[i])
                    .scan(0, |sum, d| {
                        *sum = (*sum + d) % s;
                        Some(*sum)
                    })
                    .collect(),
                open: order[..always].iter().fold(0, |set, level| set | 1 << level),
                between: order.get(always).map_or(0, |level| 1 << level),
            }
        });
        let columns = columns.collect();
        Self { shape, columns, between: Occlusion::new(keep.iter().map(|p| (p * f64::from(s)).fract())) }
    }

    /// Draws a block that begins within the array; samples past its end begin it again.
    pub fn draw(&self, seed: u64, block: u64, masks: &mut Vec<u64>) {
        let s = u64::from(self.shape.levels);
        let turns = |sample: u64| {
            (0..self.shape.digits as usize - 1).take_while(|d| (sample + 1).is_multiple_of(s.pow(*d as u32 + 1))).count()
        };
        let turns: [usize; 64] = std::array::from_fn(|i| turns(block * 64 + i as u64));
        self.between.draw(seed, block, masks);
        for (mask, column) in masks.iter_mut().zip(&self.columns) {
            let mut level = self.level(column, block * 64);
            let (mut open, mut between) = (0, 0);
            for (i, turns) in turns.iter().enumerate() {
                open |= (column.open >> level & 1) << i;
                between |= (column.between >> level & 1) << i;
                level += column.gains[*turns];
                level -= if level >= self.shape.levels { self.shape.levels } else { 0 };
            }
            *mask = open | between & *mask;
        }
    }

    fn level(&self, column: &Column, sample: u64) -> u32 {
        let (mut level, mut before, mut rest) = (0, 0, sample);
        for gain in &column.gains {
            let digit = gain + self.shape.levels - before;
            level += digit * (rest % u64::from(self.shape.levels)) as u32;
            (before, rest) = (*gain, rest / u64::from(self.shape.levels));
        }
        level % self.shape.levels
    }
}

/// A number below `count`, uniform to 2⁻³².
fn below(count: usize, rng: &mut impl Rng) -> usize {
    (((rng.next_u64() >> 32) * count as u64) >> 32) as usize
}
