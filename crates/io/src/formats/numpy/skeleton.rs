//! A skeleton graph as NumPy arrays in one `.npz`: `coords`, `edges`, `radii`, and `labels` and `lengths` where there are any.

use std::io::{self, Seek, Write};

use ndarray::{Array1, Array2};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::formats::polylines::{PointLinks, add_straight, centerlines, network_of_points, radii_of_points};
use crate::formats::{Centerlines, Content, Fault, Frame, Network, Point, ReadOptions, UnpackLimit, ensure, millimetres};

/// What the points are called: by this program, by skan, by kimimaro and cloud-volume.
const COORDS: [&str; 3] = ["coords", "coordinates", "vertices"];
/// Likewise the radii.
const RADII: [&str; 2] = ["radii", "radius"];
/// The array that states the frame of the coordinates.
const FRAME: &str = "frame";
const ACCEPTED: &str = "expected a skeleton graph: coords (N, 3), edges (M, 2) and radii (N) or (M)";

/// Reads a skeleton graph: `coords` (N, 3), `edges` (M, 2) of rows of `coords`, `radii`, and where they are there `labels`
/// and `lengths`. Any number of bytes a value, either byte order, either order of axes; stored or deflated.
///
/// - N radii are those of the points. The edges are then links of centerlines.
/// - M radii are those of the edges. With `lengths` (M) every edge is one observed vessel; without, the edges are
///   links of centerlines. Where N = M the radii are those of the points, unless there are lengths.
/// - N radii beside `lengths` are an error: a link is as long as its points are apart.
/// - M `labels` (text, or whole numbers other than 0) name the edges; N name the points, and an edge takes the name on which
///   its two points agree.
///
/// Missing radii (NaN, 0) of points are interpolated along the vessel; no radii at all is an error unless radii are optional.
///
/// # Errors
///
/// A broken archive, another kind of `.npz` (a sparse matrix), Python objects, an array that is missing or whose shape or
/// type is another, a row that `coords` lacks, a position that is not finite.
pub fn read_skeleton_npz(bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>), Fault> {
    let (scale, radius_optional) = (&options.scale, options.is_radius_optional());
    let room = UnpackLimit::of(bytes.len(), options.max_input);
    let mut archive = super::array::Archive::open(bytes, &room)?;
    let is_sparse = archive.has("indptr") || (archive.has("row") && archive.has("col"));
    ensure(!is_sparse, || Fault::file("a sparse matrix of scipy.sparse, such as likelihood.npz", ACCEPTED))?;
    let coords = archive.first(&COORDS)?.ok_or_else(|| archive.lacks("coords"))?;
    let edges = archive.first(&["edges"])?.ok_or_else(|| archive.lacks("edges"))?;
    let radii = archive.first(&RADII)?;
    let found = || format!("no array radii among {}", archive.names.join(", "));
    ensure(radii.is_some() || radius_optional, || Fault::file(found(), "expected radii, or give `default_radius`"))?;
    let labels = archive.first(&["labels"])?.map(|labels| labels.texts().map(|texts| (labels, texts))).transpose()?;
    let lengths = archive.first(&["lengths"])?;
    // An array of another program that happens to have this name says nothing.
    let words = archive.first(&[FRAME]).ok().flatten().and_then(|array| array.texts().ok()).unwrap_or_default();
    let frame = words.first().map_or(Frame::Unknown, |word| Frame::of_word(word));
    let mut points: Vec<Point> = Vec::new();
    for (row, position) in coords.rows::<3>()?.into_iter().enumerate() {
        let wrong = || coords.fault(format!("row {row} is {position:?}"), "expected finite numbers");
        ensure(position.iter().all(|x| x.is_finite()), wrong)?;
        points.push(scale.position(position));
    }
    let links = links(&edges, points.len())?;
    let (n, m) = (points.len(), links.len());
    ensure(m > 0, || edges.fault("no edges", "expected a row for every edge"))?;
    let label = |link: usize| match &labels {
        None => String::new(),
        Some((_, names)) if names.len() == m => names[link].clone(),
        Some((_, names)) => {
            let [a, b] = links[link].map(|end| &names[end as usize]);
            if a == b { a.clone() } else { String::new() }
        }
    };
    if let Some((array, names)) = labels.as_ref().filter(|(_, names)| names.len() != m && names.len() != n) {
        return Err(array.fault(format!("{} values", names.len()), format!("expected {m}, one an edge, or {n}, one a point")));
    }
    let sizes = match &radii {
        None => vec![f64::NAN; if lengths.is_some() { m } else { n }],
        Some(array) => array.reals()?.into_iter().map(|r| scale.length(r)).collect(),
    };
    if let Some(array) = radii.filter(|array| array.len() != n && array.len() != m) {
        return Err(array.fault(format!("{} values", array.len()), format!("expected {n}, one a point, or {m}, one an edge")));
    }
    if let Some(array) = lengths {
        let beside = || array.fault("beside radii of points", format!("expected {m} radii, one an edge, or no lengths"));
        ensure(sizes.len() == m, beside)?;
        let lengths = array.reals()?;
        ensure(lengths.len() == m, || array.fault(format!("{} values", lengths.len()), format!("expected {m}, one an edge")))?;
        let lengths: Vec<f64> = lengths.into_iter().map(|x| scale.course(x)).collect();
        let mut network = vessels(&points, &links, &sizes, &lengths, label, radius_optional)?;
        network.frame = frame;
        return Ok((Content::Vessels(network), Vec::new()));
    }
    let are_of_edges = sizes.len() != n;
    let note = are_of_edges.then(|| "radii are those of edges: each point takes the mean of its edges over length".to_owned());
    let of_points = are_of_edges.then(|| radii_of_points(&points, &links, &sizes));
    let (radii, link_radii) = of_points.as_ref().map_or((&sizes, &[][..]), |radii| (radii, &sizes));
    let lines = Centerlines { frame, ..centerlines(&points, radii, &links, link_radii, label) };
    Ok((Content::Centerlines(lines), note.into_iter().collect()))
}

/// The edges as vessels.
fn vessels(
    points: &[Point],
    links: &[[u32; 2]],
    radii: &[f64],
    lengths: &[f64],
    label: impl Fn(usize) -> String,
    radius_optional: bool,
) -> Result<Network, Fault> {
    let mut network = network_of_points(points);
    for (row, ends) in links.iter().enumerate() {
        let item = |found: &str, accepted: &str| Fault::item(format!("edge {row}"), found, accepted);
        let radius = Some(radii[row]).filter(|r| crate::formats::is_radius(*r));
        let wrong = || item("no valid radius", "expected a positive radius, or give `default_radius`");
        ensure(radius.is_some() || radius_optional, wrong)?;
        add_straight(&mut network, ends.map(|end| end as usize), lengths[row], radius.unwrap_or(f64::NAN), &label(row))
            .ok_or_else(|| item("no positive length", "expected a positive length"))?;
    }
    Ok(network)
}

/// The rows of `edges`, all of which must be points.
fn links(edges: &super::array::NumpyArray, points: usize) -> Result<Vec<[u32; 2]>, Fault> {
    ensure(edges.is_whole(), || edges.fault("values that are not whole numbers", "expected an integer type"))?;
    let mut links = Vec::new();
    for (row, ends) in edges.rows::<2>()?.into_iter().enumerate() {
        if let Some(end) = ends.iter().find(|end| !(**end >= 0.0 && **end < points as f64)) {
            let found = format!("row {row} names point {end}");
            return Err(edges.fault(found, format!("expected rows of coords, 0 to {}", points.saturating_sub(1))));
        }
        links.push(ends.map(|end| end as u32));
    }
    Ok(links)
}

/// Writes `coords` (N, 3) and `edges` (M, 2), the nodes first in their order, and the other arrays as
/// [`read_skeleton_npz`] takes them, mm.
///
/// Where a vessel has points between its nodes, the edges link points and `radii` (N) are theirs. Where none has, every edge
/// is a vessel, `radii` (M) and `lengths` (M) are the vessels'. `labels` (M) is left out where no vessel has one, `frame` (1) where it
/// is not known.
///
/// # Errors
///
/// A node without a position; two vessels that points cannot distinguish (`InvalidInput`); the writer's own.
pub fn write_skeleton_npz(out: impl Write + Seek, network: &Network) -> io::Result<()> {
    let graph = PointLinks::of(network)?;
    let mut zip = ZipWriter::new(out);
    write(&mut zip, "coords", &Array2::from(graph.points.iter().map(|p| p.map(millimetres)).collect::<Vec<_>>()))?;
    write(&mut zip, "edges", &Array2::from(graph.links.iter().map(|link| link.map(|row| row as i64)).collect::<Vec<_>>()))?;
    write(&mut zip, "radii", &graph.radii.iter().map(|radius| millimetres(*radius)).collect::<Array1<f64>>())?;
    if graph.is_straight {
        write(&mut zip, "lengths", &network.vessels().map(|(_, v)| millimetres(v.length)).collect::<Array1<f64>>())?;
    }
    texts(&mut zip, "labels", &graph.labels(network).collect::<Vec<_>>())?;
    texts(&mut zip, FRAME, &network.frame.name().map_or(vec![], |name| vec![name]))?;
    zip.finish().map_err(io::Error::other)?.flush()
}

fn start(zip: &mut ZipWriter<impl Write + Seek>, name: &str) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true);
    zip.start_file(format!("{name}.npy"), options).map_err(io::Error::other)
}

fn write(zip: &mut ZipWriter<impl Write + Seek>, name: &str, array: &impl ndarray_npy::WriteNpyExt) -> io::Result<()> {
    start(zip, name)?;
    array.write_npy(zip).map_err(io::Error::other)
}

/// Text as NumPy's `<U`: UTF-32 of equal length, which no element type of a fixed size can be.
fn texts(zip: &mut ZipWriter<impl Write + Seek>, name: &str, labels: &[&str]) -> io::Result<()> {
    let longest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    if longest == 0 {
        return Ok(());
    }
    start(zip, name)?;
    let mut header = format!("{{'descr': '<U{longest}', 'fortran_order': False, 'shape': ({},), }}", labels.len());
    // The values begin at a multiple of 64.
    let padded = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header.extend(std::iter::repeat_n(' ', padded - header.len() - 1).chain(['\n']));
    zip.write_all(b"\x93NUMPY\x01\x00")?;
    zip.write_all(&(header.len() as u16).to_le_bytes())?;
    zip.write_all(header.as_bytes())?;
    for label in labels {
        let letters = label.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest);
        let bytes: Vec<u8> = letters.flat_map(u32::to_le_bytes).collect();
        zip.write_all(&bytes)?;
    }
    Ok(())
}
