//! Sparse Cholesky factorisation of the grounded Laplacian by faer, for circuits beyond the star-mesh program.
//!
//! The pattern is analysed once; closed vessels stay as zeros. Floating components are found by structure and pinned.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};

use super::circuit::Circuit;
use super::dead_ends;
use super::dead_ends::DeadEnds;
use super::floating::grounded;
use crate::error::{Error, Result};

/// Conductances further apart than this leave a factorisation without a right digit behind the weakest.
const SPAN: f64 = 1e14;

/// The analysed pattern of a circuit.
#[derive(Debug)]
pub struct Cholesky {
    circuit: Circuit,
    /// Per node its row; `usize::MAX` where the pressure is fixed.
    row: Vec<usize>,
    pattern: SymbolicSparseColMat<usize>,
    /// Per vessel the place of its off-diagonal entry.
    entry: Vec<Option<usize>>,
    /// Per row the place of its diagonal entry.
    diagonal: Vec<usize>,
    symbolic: SymbolicCholesky<usize>,
    dead_ends: DeadEnds,
}

/// The memory of one worker.
#[derive(Default)]
pub struct Workspace {
    values: Vec<f64>,
    factor: Vec<f64>,
    right: Vec<f64>,
    memory: Option<MemBuffer>,
    pressure: Vec<f64>,
    dead_ends: dead_ends::Workspace,
}

impl Cholesky {
    /// Analyses the pattern of a circuit; `None` when its conductances lie further apart than a factorisation can tell,
    /// or memory does not suffice.
    pub fn compile(circuit: &Circuit) -> Option<Self> {
        if too_far_apart(circuit, &circuit.conductance) {
            return None;
        }
        let mut row = vec![usize::MAX; circuit.node_count()];
        let free: Vec<usize> = (0..circuit.node_count()).filter(|n| circuit.fixed[*n].is_none()).collect();
        for (i, node) in free.iter().enumerate() {
            row[*node] = i;
        }
        let below = |[a, b]: [usize; 2]| {
            let (low, high) = (row[a].min(row[b]), row[a].max(row[b]));
            (high != usize::MAX && low != high).then_some((low, high))
        };
        let mut columns: Vec<Vec<usize>> = (0..free.len()).map(|i| vec![i]).collect();
        for (low, high) in circuit.ends.iter().filter_map(|e| below(*e)) {
            columns[low].push(high);
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(column);
            starts.push(rows.len());
        }
        let entry = circuit.ends.iter().map(|e| {
            let (low, high) = below(*e)?;
            rows[starts[low]..starts[low + 1]].binary_search(&high).ok().map(|at| starts[low] + at)
        });
        let entry = entry.collect();
        let diagonal = starts[..free.len()].to_vec();
        let pattern = SymbolicSparseColMat::new_checked(free.len(), free.len(), starts, None, rows);
        let params = CholeskySymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::AUTO, ..Default::default() };
        let symbolic = factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, SymmetricOrdering::Amd, params).ok()?;
        Some(Self { dead_ends: DeadEnds::new(circuit), circuit: circuit.clone(), row, pattern, entry, diagonal, symbolic })
    }

    /// The entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Solves one sample: the pressure of every node, Pa above the circuit's level; zero in floating components.
    ///
    /// # Errors
    ///
    /// The conductances are too far apart for a factorisation in double precision.
    pub fn solve(&self, open: impl Fn(usize) -> bool, work: &mut Workspace, pressure: impl FnMut(usize, f64)) -> Result<()> {
        self.at(&self.circuit.conductance, open, work, pressure)
    }

    /// As [`Cholesky::solve`], with other conductances of the vessels (m³/(Pa s)) in the same pattern, zero for a closed one.
    ///
    /// # Errors
    ///
    /// The same.
    pub fn solve_with(&self, conductance: &[f64], work: &mut Workspace, pressure: impl FnMut(usize, f64)) -> Result<()> {
        if too_far_apart(&self.circuit, conductance) {
            return Err(Error::Breakdown);
        }
        self.at(conductance, |vessel| conductance[vessel] > 0.0, work, pressure)
    }

    fn at(
        &self,
        conductance: &[f64],
        open: impl Fn(usize) -> bool,
        work: &mut Workspace,
        mut pressure: impl FnMut(usize, f64),
    ) -> Result<()> {
        let circuit = &self.circuit;
        let grounded = grounded(circuit, &open);
        work.values.clear();
        work.values.resize(self.pattern.row_idx().len(), 0.0);
        work.right.clear();
        work.right.resize(self.diagonal.len(), 0.0);
        for (node, row) in self.row.iter().enumerate().filter(|(_, row)| **row != usize::MAX) {
            let at = &mut work.values[self.diagonal[*row]];
            if grounded[node] {
                *at += circuit.shunt[node];
                work.right[*row] += circuit.source[node];
            } else {
                *at += 1.0;
            }
        }
        for (vessel, [a, b]) in circuit.ends.iter().enumerate().filter(|(vessel, e)| e[0] != e[1] && open(*vessel)) {
            let c = conductance[vessel];
            for (here, there) in [(*a, *b), (*b, *a)] {
                if self.row[here] == usize::MAX {
                    continue;
                }
                let scale = if grounded[here] { c } else { 0.0 };
                work.values[self.diagonal[self.row[here]]] += scale;
                work.right[self.row[here]] += scale * circuit.fixed[there].unwrap_or(0.0);
            }
            if let Some(at) = self.entry[vessel].filter(|_| grounded[*a]) {
                work.values[at] -= c;
            }
        }
        self.factorise_and_solve(work).ok_or(Error::Breakdown)?;
        work.pressure.clear();
        work.pressure.extend(self.row.iter().zip(&circuit.fixed).map(|(row, fixed)| fixed.unwrap_or_else(|| work.right[*row])));
        self.dead_ends.level(&open, &mut work.dead_ends, &mut work.pressure, &circuit.fixed);
        for (node, p) in work.pressure.iter().enumerate() {
            pressure(node, *p);
        }
        Ok(())
    }

    /// Replaces the right-hand side by the solution; `None` when the factorisation breaks down.
    fn factorise_and_solve(&self, work: &mut Workspace) -> Option<()> {
        let memory = work.memory.get_or_insert_with(|| {
            MemBuffer::new(StackReq::any_of(&[
                self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
                self.symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
            ]))
        });
        work.factor.resize(self.symbolic.len_val(), 0.0);
        let matrix = SparseColMatRef::<usize, f64>::new(self.pattern.as_ref(), &work.values);
        let factor = self.symbolic.factorize_numeric_llt::<f64>(
            &mut work.factor,
            matrix,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(memory),
            Default::default(),
        );
        let rows = work.right.len();
        let right = MatMut::from_column_major_slice_mut(&mut work.right, rows, 1);
        factor.ok()?.solve_in_place_with_conj(Conj::No, right, Par::Seq, MemStack::new(memory));
        Some(())
    }
}

/// Whether conductances lie further apart than a factorisation can tell; a vessel from a node to itself counts for nothing.
fn too_far_apart(circuit: &Circuit, conductance: &[f64]) -> bool {
    let in_use = || circuit.ends.iter().zip(conductance).filter(|(e, _)| e[0] != e[1]).map(|(_, c)| *c);
    in_use().fold(0.0, f64::max) > SPAN * in_use().fold(f64::INFINITY, f64::min)
}
