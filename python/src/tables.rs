//! Tables and polylines as NumPy arrays.

use crate::interrupt::detached;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use willis::Network;
use willis::internals::formats::{Column, NamedArray, Values, graph_columns};
use willis::internals::network::units::millimetres;

/// Arrays by name, in the order of the columns; numbers are handed over, not copied.
pub fn dict(py: Python<'_>, columns: Vec<Column>) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    let text = py.import("numpy")?.getattr("array")?;
    for Column { name, values } in columns {
        match values {
            Values::Real(values) => out.set_item(name.as_ref(), values.into_pyarray(py))?,
            Values::Integer(values) => out.set_item(name.as_ref(), values.into_pyarray(py))?,
            Values::Text(values) => {
                let list = PyList::new(py, values.iter())?;
                let dtype = PyDict::new(py);
                dtype.set_item("dtype", "str")?;
                out.set_item(name.as_ref(), text.call((list,), Some(&dtype))?)?;
            }
        }
    }
    Ok(out)
}

/// The same of two tables.
pub fn pair(py: Python<'_>, [a, b]: [Vec<Column>; 2]) -> PyResult<[Bound<'_, PyDict>; 2]> {
    Ok([dict(py, a)?, dict(py, b)?])
}

/// Arrays of any shape by name.
pub fn arrays(py: Python<'_>, arrays: Vec<NamedArray>) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    for NamedArray { name, shape, values } in arrays {
        out.set_item(name, values.into_pyarray(py).call_method1("reshape", (shape,))?)?;
    }
    Ok(out)
}

/// The columns of the nodes and of the vessels of a network.
pub fn of_network<'py>(py: Python<'py>, network: &Network) -> PyResult<[Bound<'py, PyDict>; 2]> {
    pair(py, detached(py, || graph_columns(network)).into())
}

/// The two nodes of each vessel, and the points of all vessels one after another: their positions and radii, mm, and where each vessel
/// begins among them.
pub type Lines<'py> =
    (Bound<'py, PyArray2<i64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>);

/// The lines of a network.
pub fn lines<'py>(py: Python<'py>, network: &Network) -> PyResult<Lines<'py>> {
    let (mut ends, mut points, mut radii, mut first) = (Vec::new(), Vec::new(), Vec::new(), vec![0_i64]);
    for ([a, b], vessel) in network.vessels() {
        ends.extend([a as i64, b as i64]);
        for point in &vessel.path {
            points.extend(point.position.map(millimetres));
            radii.push(millimetres(point.radius));
        }
        if vessel.path.is_empty() {
            for node in [a, b] {
                points.extend(network.node(node).position.map_or([f64::NAN; 3], |p| p.map(millimetres)));
                radii.push(millimetres(vessel.radius));
            }
        }
        first.push(radii.len() as i64);
    }
    let (count, places) = (network.vessel_count(), radii.len());
    let ends = ends.into_pyarray(py).call_method1("reshape", (count, 2))?.cast_into()?;
    let points = points.into_pyarray(py).call_method1("reshape", (places, 3))?.cast_into()?;
    Ok((ends, points, radii.into_pyarray(py), first.into_pyarray(py)))
}
