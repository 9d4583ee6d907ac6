//! The stages of the loop, timed apart in one thread.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use willis::internals::flow::BatchSolver;
use willis::internals::flow::batch::{conductances::MaskedRows, solver::BatchWorkspace};
use willis::internals::sampling::{Coins, ForestProgram, InForest, wider};
use willis::internals::support::simd::{InstructionSet, Kernel, Lanes, Simd};

use crate::Result;
use crate::case::{Case, Pieces};
use crate::clock::per_call;

/// Seconds for each figure.
const BUDGET: f64 = 0.4;

/// Microseconds a sample of the flow solver.
pub fn solve(pieces: &Pieces, program: &BatchSolver, budget: f64) -> f64 {
    let instructions = InstructionSet::detect();
    let mut masks = Vec::new();
    pieces.occlusion.draw(0, 0, &mut masks);
    let rows = MaskedRows { conductance: &pieces.circuit.conductance, masks: &masks, first: 0 };
    if instructions == InstructionSet::Avx512 {
        solve_lanes::<16>(instructions, program, rows, budget)
    } else {
        solve_lanes::<8>(instructions, program, rows, budget)
    }
}

struct Solve<'a, const B: usize>(&'a BatchSolver, MaskedRows<'a>, &'a mut BatchWorkspace<B>);

impl<const B: usize> Kernel for Solve<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.solve(simd, &self.1, 0, &[], self.2);
    }
}

fn solve_lanes<const B: usize>(instructions: InstructionSet, program: &BatchSolver, rows: MaskedRows<'_>, budget: f64) -> f64 {
    let mut work = program.workspace::<B>();
    per_call(budget, || instructions.run(Solve(program, rows, &mut work))) / B as f64
}

/// Microseconds a sample of the forest program: keys put in, paths widened, vessels taken.
pub fn forest(program: &ForestProgram, keys: &[Vec<u64>], budget: f64) -> f64 {
    let instructions = InstructionSet::detect();
    if instructions == InstructionSet::Avx512 {
        forest_lanes::<16>(instructions, program, keys, budget)
    } else {
        forest_lanes::<8>(instructions, program, keys, budget)
    }
}

struct Grow<'a, const B: usize> {
    program: &'a ForestProgram,
    coins: &'a Coins,
    keys: &'a [Lanes<B>],
    widest: &'a mut [Lanes<B>],
    taken: &'a mut [InForest<B>],
}

impl<const B: usize> Kernel for Grow<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (widest, vessels) in self.widest.iter_mut().zip(self.program.vessels_of()) {
            *widest = Lanes::ZERO;
            for vessel in vessels {
                *widest = wider(simd, widest, &self.keys[*vessel as usize]);
            }
        }
        self.program.grow(simd, self.coins, self.widest, self.taken);
    }
}

fn forest_lanes<const B: usize>(instructions: InstructionSet, program: &ForestProgram, samples: &[Vec<u64>], budget: f64) -> f64 {
    let vessels = samples[0].len();
    let keys: Vec<Lanes<B>> = (0..vessels).map(|v| Lanes(std::array::from_fn(|lane| f64::from_bits(samples[lane][v])))).collect();
    let coins = Coins::new(vessels, 0);
    let (mut widest, mut taken) = (vec![Lanes::ZERO; program.rays()], vec![[0; B]; vessels + 1]);
    let time = per_call(budget, || {
        instructions.run(Grow { program, coins: &coins, keys: &keys, widest: &mut widest, taken: &mut taken });
        std::hint::black_box(&taken);
    });
    time / B as f64
}

/// Prints one CSV row: mask, solve, forest, the joins of both programs.
pub fn print(case: &Case) -> Result<()> {
    let pieces = case.pieces()?;
    let program = BatchSolver::star_mesh(&pieces.circuit, usize::MAX).ok_or("no program")?;
    let bottleneck =
        ForestProgram::compile(case.network.node_count(), &pieces.in_forest, usize::MAX).ok_or("no forest program")?;
    let (mut masks, mut block) = (Vec::new(), 0);
    let mask = per_call(BUDGET, || {
        pieces.occlusion.draw(0, block, &mut masks);
        block += 1;
    }) / willis::internals::support::random::BLOCK as f64;
    let solve = solve(&pieces, &program, BUDGET);
    let forest = forest(&bottleneck, &pieces.keys(&program, 16), BUDGET);
    println!("{mask:.4},{solve:.4},{forest:.4},{},{}", program.joins(), bottleneck.joins());
    Ok(())
}
