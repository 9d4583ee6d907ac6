//! Reads one period of a pressure or a flow: a table with `time_s` and `pressure_mmHg` or `flow_mL_per_min`.

use super::reader::{TableReader, columns};
use willis_core::error::Fault;
use willis_core::network::units::{cubic_metres_per_second, pascals};
use willis_core::network::waveform::{Quantity, Waveform};

const PRESSURE: &str = "pressure_mmHg";
const FLOW: &str = "flow_mL_per_min";

/// Reads a waveform; other columns are left alone.
///
/// # Errors
///
/// No column of times; both a pressure and a flow, or neither; fewer than two rows; a time that falls; a number that is not finite.
pub fn read_waveform(bytes: &[u8]) -> Result<Waveform, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let time = rows.column(&["time_s"], "the time of each row")?;
    let quantity = match (rows.find(&[PRESSURE]), rows.find(&[FLOW])) {
        (Some(_), Some(_)) => {
            let found = format!("both {PRESSURE} and {FLOW}");
            return Err(Fault::line(rows.header_line(), found, "expected one of them: an inlet has a pressure or a flow"));
        }
        (Some(column), None) => (Quantity::Pressure, column),
        (None, Some(column)) => (Quantity::Flow, column),
        (None, None) => {
            let accepted = format!("expected a column {PRESSURE} or {FLOW}");
            return Err(Fault::line(rows.header_line(), columns(rows.header()), accepted));
        }
    };
    let (quantity, column) = quantity;
    let (mut times, mut values) = (Vec::<f64>::new(), Vec::new());
    while let Some(row) = rows.row()? {
        let (t, x) = (row.finite(time)?, row.finite(column)?);
        if let Some(before) = times.last().filter(|before| **before > t) {
            return Err(Fault::line(row.line, format!("time_s {t} after {before}"), "expected times that never fall"));
        }
        times.push(t);
        values.push(match quantity {
            Quantity::Pressure => pascals(x),
            Quantity::Flow => cubic_metres_per_second(x),
        });
    }
    if times.len() < 2 || times[0] == times[times.len() - 1] {
        let found = if times.len() == 1 { "one row".to_owned() } else { format!("{} rows at one time", times.len()) };
        return Err(Fault::file(found, "expected two or more rows over one period"));
    }
    Ok(Waveform { quantity, times, values })
}
