//! The steady pressures of one network, all its vessels open or some of them closed.

use super::cholesky::{self, Cholesky};
use super::circuit::Circuit;
use super::floating::{grounded, stranded};
use super::star_mesh::StarMesh;
use crate::error::{Error, Result};
use crate::simd::Scalar;

/// Mesh updates above which the sparse Cholesky solver takes over from star-mesh elimination.
pub const LANES_LIMIT: usize = 2_000_000;

/// The pressure (Pa) of every node with the vessels `open`; `None` in floating components, where it is undefined.
///
/// # Errors
///
/// A large circuit whose conductances lie too far apart for the sparse factorisation.
pub fn pressures(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
    let mut above_level = vec![0.0; circuit.node_count()];
    if let Some(program) = StarMesh::compile(circuit, LANES_LIMIT) {
        let masks: Vec<u64> = (0..circuit.vessel_count()).map(|v| u64::from(open(v))).collect();
        let mut work = program.workspace::<1>();
        program.solve(Scalar::new(), &masks, 0, &stranded(circuit, &masks, 1), &mut work);
        for (node, p) in above_level.iter_mut().enumerate() {
            *p = work.pressure[program.slot(node)][0];
        }
    } else {
        let factor = Cholesky::compile(circuit).ok_or(Error::Breakdown)?;
        factor.solve(&open, &mut cholesky::Workspace::default(), |node, p| above_level[node] = p)?;
    }
    let grounded = grounded(circuit, open);
    Ok(above_level.iter().zip(grounded).map(|(p, grounded)| grounded.then_some(p + circuit.level)).collect())
}
