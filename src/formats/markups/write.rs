//! Writes a network as markups curves.

use std::io::{self, Write};

use crate::centerline::is_radius;
use crate::formats::column::real;
use crate::formats::polyline::polylines;
use crate::network::Network;
use crate::units::millimetres;

const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

/// Writes every vessel as a Curve of one markups file, its label as the name, the radius as the measurement `Radius` at the control
/// points; LPS, millimetres. A vessel without a path is straight, a missing radius 0.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_markups(mut out: impl Write, network: &Network) -> io::Result<()> {
    writeln!(out, "{{\n\"@schema\": \"{SCHEMA}\",\n\"markups\": [")?;
    for (row, points) in polylines(network)?.into_iter().enumerate() {
        let before = if row > 0 { ",\n" } else { "" };
        let name = serde_json::to_string(&network.vessel(row).label)?;
        writeln!(
            out,
            "{before}{{\"type\": \"Curve\", \"name\": {name}, \"coordinateSystem\": \"LPS\", \"coordinateUnits\": \"mm\","
        )?;
        writeln!(out, "\"controlPoints\": [")?;
        for (at, point) in points.iter().enumerate() {
            let [x, y, z] = point.position.map(|x| real(millimetres(x)));
            let comma = if at + 1 < points.len() { "," } else { "" };
            writeln!(out, "{{\"id\": \"{}\", \"position\": [{x}, {y}, {z}]}}{comma}", at + 1)?;
        }
        let radius = |r: f64| if is_radius(r) { real(millimetres(r)) } else { "0".into() };
        let radii: Vec<String> = points.iter().map(|p| radius(p.radius)).collect();
        writeln!(out, "],\n\"measurements\": [{{\"name\": \"Radius\", \"enabled\": true, \"units\": \"mm\",")?;
        write!(out, "\"controlPointValues\": [{}]}}]}}", radii.join(", "))?;
    }
    writeln!(out, "\n]\n}}")?;
    out.flush()
}
