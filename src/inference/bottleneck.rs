//! The maximum spanning forest of many samples at once, by elimination over the (max, min) semiring.
//!
//! Eliminating node k offers its neighbours i and j the path through k, whose narrowest vessel is min(m_ki, m_kj). The widest
//! way out of k belongs to the forest (Borůvka); to every other neighbour the new paths lead as k's own vessels did, by
//! way of the widest one, so that the rest of the forest is the forest of the rest. The vessel stands in the low bits of
//! its key, so that one pass through the order reads the whole forest off. Maxima and minima only select: the answer is
//! exact, and there is no sort and no branch.

use super::forest::vessel;
use crate::elimination::{Elimination, NOWHERE};
use crate::simd::{Lanes, zip};

/// The compiled elimination of a graph's forests.
#[derive(Debug, Clone)]
pub struct Bottleneck {
    program: Elimination,
    steps: Vec<Step>,
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
        Some(Self { steps: steps(&program), program, ray })
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
    pub fn offer<const B: usize>(&self, vessel: usize, keys: &Lanes<B>, widest: &mut [Lanes<B>]) {
        if let Some(m) = widest.get_mut(self.ray[vessel] as usize) {
            *m = wider(m, keys);
        }
    }

    /// Grows the forests of the keys offered: sets bit `first` + lane of `taken[vessel]` for every vessel in a lane's forest.
    ///
    /// `taken` has one place more than there are vessels; what is in it means nothing.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    pub fn grow<const B: usize>(&self, widest: &mut [Lanes<B>], first: usize, taken: &mut [u64]) {
        for step in &self.steps {
            let k = step.k as usize;
            if step.twin {
                self.two(k, widest, first, taken);
            } else {
                self.one(k, widest, first, taken);
            }
        }
    }

    /// Eliminates the k-th node.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    fn one<const B: usize>(&self, k: usize, widest: &mut [Lanes<B>], first: usize, taken: &mut [u64]) {
        let star = self.program.star(k);
        let (done, later) = widest.split_at_mut(star.end);
        let mut mesh = self.program.mesh(k).iter();
        let rays = &done[star.clone()];
        let mut best = Lanes::ZERO;
        for (i, a) in rays.iter().enumerate() {
            best = wider(&best, a);
            for (b, target) in rays[i + 1..].iter().zip(&mut mesh) {
                let m = &mut later[*target as usize - star.end];
                *m = wider(m, &narrower(a, b));
            }
        }
        take(&best, first, taken);
    }

    /// Eliminates the k-th node and the next, its twin, together: the same joins with one pass over their targets.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    fn two<const B: usize>(&self, k: usize, widest: &mut [Lanes<B>], at: usize, taken: &mut [u64]) {
        let (near, far) = (self.program.star(k), self.program.star(k + 1));
        let (done, later) = widest.split_at_mut(far.end);
        let (near, second) = done[near.start..].split_at_mut(near.len());
        let (between, first) = (near[0], &near[1..]);
        let (mut best, mut next) = (between, Lanes::ZERO);
        for (a, b) in first.iter().zip(&mut *second) {
            best = wider(&best, a);
            let c = wider(&narrower(&between, a), b);
            next = wider(&next, &c);
            *b = c;
        }
        take(&best, at, taken);
        take(&next, at, taken);
        let mut mesh = self.program.mesh(k + 1).iter();
        for i in 0..second.len() {
            let (a, c) = (first[i], second[i]);
            for ((b, d), target) in first[i + 1..].iter().zip(&second[i + 1..]).zip(&mut mesh) {
                let m = &mut later[*target as usize - far.end];
                *m = wider(&wider(m, &narrower(&a, b)), &narrower(&c, d));
            }
        }
    }
}

/// One or two nodes eliminated at a time.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// The node's place.
    k: u32,
    /// Whether the next one has the same neighbours and goes with it.
    twin: bool,
}

/// Pairs each node with its next where that is its neighbour and has all its other neighbours.
fn steps(program: &Elimination) -> Vec<Step> {
    let to = |k: usize| &program.ray_to()[program.star(k)];
    let (mut out, mut k) = (Vec::new(), 0);
    while k < program.nodes() {
        let twin = k + 1 < program.nodes() && to(k).first() == Some(&(k as u32 + 1)) && to(k)[1..] == *to(k + 1);
        out.push(Step { k: k as u32, twin });
        k += 1 + usize::from(twin);
    }
    out
}

/// Marks the vessels of the keys, one a lane; a key of zero is marked in the last place.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
fn take<const B: usize>(keys: &Lanes<B>, first: usize, taken: &mut [u64]) {
    let last = taken.len() - 1;
    let mut at = [0; B];
    for lane in 0..B {
        at[lane] = vessel(keys[lane].to_bits());
    }
    for lane in 0..B {
        taken[at[lane].min(last)] |= 1 << (first + lane);
    }
}

/// The larger of two, lane by lane; `f64::max` would add the handling of NaN.
#[expect(clippy::inline_always, reason = "one instruction")]
#[inline(always)]
fn wider<const B: usize>(a: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    zip(a, b, |a, b| if a > b { a } else { b })
}

/// The smaller of two, lane by lane.
#[expect(clippy::inline_always, reason = "one instruction")]
#[inline(always)]
fn narrower<const B: usize>(a: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    zip(a, b, |a, b| if a < b { a } else { b })
}
