//! The maximum spanning forest of many samples at once, by elimination over the (max, min) semiring.
//!
//! Eliminating node k offers its neighbours i and j the path through k, whose narrowest vessel is min(m_ki, m_kj). Upwards and
//! then downwards through the order this makes m_ij the bottleneck of the best path between i and j. With keys that all
//! differ, a vessel is in the forest exactly when nothing between its ends is wider than the vessel itself. Maxima and
//! minima only select, so that the answer is exact; there is no sort and no branch.

use crate::elimination::{Elimination, NOWHERE};
use crate::simd::zip;

/// The compiled elimination of a graph's forests.
#[derive(Debug, Clone)]
pub struct Bottleneck {
    program: Elimination,
    /// Per vessel its ray; `NOWHERE` for one that is in no forest.
    ray: Vec<u32>,
}

impl Bottleneck {
    /// Orders and compiles; `None` when it would take more than `limit` joins a sample. `None` among the ends is a vessel
    /// that is in no forest.
    pub fn compile(nodes: usize, ends: &[Option<[usize; 2]>], limit: usize) -> Option<Self> {
        let links: Vec<[usize; 2]> = ends.iter().flatten().copied().collect();
        let program = Elimination::compile(nodes, &links, limit)?;
        let ray = |[a, b]: [usize; 2]| program.ray(program.place(a), program.place(b));
        let ray = ends.iter().map(|e| e.filter(|[a, b]| a != b).map_or(NOWHERE, ray)).collect();
        Some(Self { program, ray })
    }

    /// The joins of one sample: the length of the program.
    pub fn joins(&self) -> usize {
        self.program.joins()
    }

    /// How many rays there are: the length of the memory that the other functions take.
    pub fn rays(&self) -> usize {
        self.program.rays()
    }

    /// Offers the keys of a vessel, one a lane, zero where it is not diffused.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    pub fn offer<const B: usize>(&self, vessel: usize, keys: &[f64; B], widest: &mut [[f64; B]]) {
        if let Some(m) = widest.get_mut(self.ray[vessel] as usize) {
            *m = wider(m, keys);
        }
    }

    /// Whether a vessel is in the forest, lane by lane: all bits or none.
    #[expect(clippy::inline_always, clippy::needless_bitwise_bool, reason = "a lane loop in the caller's instruction set")]
    #[inline(always)]
    pub fn takes<const B: usize>(&self, vessel: usize, keys: &[f64; B], widest: &[[f64; B]]) -> [u64; B] {
        let mut takes = [0; B];
        if let Some(m) = widest.get(self.ray[vessel] as usize) {
            for lane in 0..B {
                takes[lane] = u64::from((keys[lane] >= m[lane]) & (keys[lane] > 0.0)).wrapping_neg();
            }
        }
        takes
    }

    /// Makes the widest keys offered between neighbours the bottlenecks of the best paths between them.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    pub fn widen<const B: usize>(&self, widest: &mut [[f64; B]]) {
        for k in 0..self.program.nodes() {
            let star = self.program.star(k);
            let (done, later) = widest.split_at_mut(star.end);
            let mut mesh = self.program.mesh(k).iter();
            let rays = &done[star.clone()];
            for (i, a) in rays.iter().enumerate() {
                for (b, target) in rays[i + 1..].iter().zip(&mut mesh) {
                    let m = &mut later[*target as usize - star.end];
                    *m = wider(m, &narrower(a, b));
                }
            }
        }
        for k in (0..self.program.nodes()).rev() {
            let star = self.program.star(k);
            let (done, later) = widest.split_at_mut(star.end);
            let mut mesh = self.program.mesh(k).iter();
            let rays = &mut done[star.clone()];
            for i in 0..rays.len() {
                let (head, tail) = rays.split_at_mut(i + 1);
                let mut a = head[i];
                for (b, target) in tail.iter_mut().zip(&mut mesh) {
                    let m = &later[*target as usize - star.end];
                    let before = *b;
                    *b = wider(&before, &narrower(&a, m));
                    a = wider(&a, &narrower(&before, m));
                }
                head[i] = a;
            }
        }
    }
}

/// The larger of two, lane by lane; `f64::max` would add the handling of NaN.
#[expect(clippy::inline_always, reason = "one instruction")]
#[inline(always)]
fn wider<const B: usize>(a: &[f64; B], b: &[f64; B]) -> [f64; B] {
    zip(a, b, |a, b| if a > b { a } else { b })
}

/// The smaller of two, lane by lane.
#[expect(clippy::inline_always, reason = "one instruction")]
#[inline(always)]
fn narrower<const B: usize>(a: &[f64; B], b: &[f64; B]) -> [f64; B] {
    zip(a, b, |a, b| if a < b { a } else { b })
}
