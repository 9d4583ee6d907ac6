//! The geodesic trees of VTrails: `*_GeodesicMSTs.mat`, which MATLAB 7.3 writes as HDF5. The only file that knows HDF5.

use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions, reference::read_object_references};

use crate::formats::{Centerlines, Fault, ReadOptions, Scale, UnpackLimit, ensure};

const STRUCT: &str = "GeodesicMSTs";
const FIELD: &str = "CGPathContinuous";
/// The most points in all, so that a small file cannot claim all memory.
const MOST_POINTS: u64 = 1 << 26;

/// Reads the paths `GeodesicMSTs(i).CGPathContinuous` (points x 3), one strand each, without radii.
///
/// VTrails saves them in voxels of its grid, counted from 1, the second axis of the image first; with its option `Paraview`
/// in mm.
///
/// # Errors
///
/// A file that is broken or of another kind; a path that is not points x 3 or not finite; radii that are not optional, since the
/// file has none.
pub fn read_vtrails(bytes: &[u8], read: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let room = &UnpackLimit::of(bytes.len(), read.max_input);
    let options = OpenOptions::default()
        .with_max_read_bytes(room.left())
        .with_max_chunk_bytes(room.left().min(1 << 28))
        .with_max_object_header_bytes(1 << 22);
    let broken = |e: hdf5_reader::error::Error| {
        let word = e.to_string().replace(['\n', '\r'], " ");
        Fault::file(format!("the HDF5 file is broken: {word}"), "expected a whole file of MATLAB 7.3")
    };
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(broken)?;
    let (groups, arrays) = file.root_group().and_then(|root| root.member_names()).map_err(broken)?;
    if !groups.iter().any(|name| name == STRUCT) {
        let names: Vec<String> = groups.into_iter().chain(arrays).filter(|name| name != "#refs#").collect();
        let found = if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
        let accepted = format!("expected a file of VTrails with the struct {STRUCT}; other HDF5 and MATLAB files are not read");
        return Err(Fault::file(format!("HDF5 with {found}"), accepted));
    }
    let fields = file.group(STRUCT).map_err(broken)?;
    let paths = fields.dataset(FIELD).map_err(|_| Fault::item(STRUCT, format!("no {FIELD}"), "expected a file of VTrails"))?;
    ensure(read.is_radius_optional(), || Fault::file("VTrails' trees have no radii", "give `default_radius`"))?;
    let mut lines = Centerlines::default();
    let mut void = 0;
    if matches!(paths.dtype(), Datatype::Reference { .. }) {
        let count = paths.shape().iter().try_fold(8_u64, |all, n| all.checked_mul(*n)).unwrap_or(u64::MAX);
        let too_many = |(found, accepted): (String, &str)| Fault::item(STRUCT, found, accepted);
        room.take(usize::try_from(count).unwrap_or(usize::MAX)).map_err(too_many)?;
        let references = paths.read_raw_bytes().and_then(|raw| read_object_references(&raw, 8)).map_err(broken)?;
        let all = file.group("#refs#").and_then(|group| group.datasets()).map_err(broken)?;
        let at: std::collections::HashMap<u64, &Dataset> = all.iter().map(|array| (array.address(), array)).collect();
        for (row, reference) in references.iter().enumerate() {
            let missing = || Fault::item(format!("{STRUCT}({})", row + 1), "refers to nothing", "expected a whole file");
            let path = at.get(reference).ok_or_else(missing)?;
            if path.attribute("MATLAB_empty").is_ok() {
                void += 1;
            } else {
                add(&mut lines, path, row, &read.scale, room)?;
            }
        }
    } else {
        // A struct of one element holds its field itself.
        add(&mut lines, &paths, 0, &read.scale, room)?;
    }
    ensure(!lines.links.is_empty(), || Fault::item(STRUCT, "no paths", "expected paths of two or more points"))?;
    let units = "VTrails saves voxels of its grid, the image's second axis first, unless it ran with Paraview: see `units=voxel`";
    let mut notes = vec![units.to_owned()];
    if void > 0 {
        notes.push(format!("{void} paths are empty: left out"));
    }
    Ok((lines, notes))
}

/// Adds a path. MATLAB's points x 3 are stored in HDF5 as 3 x points.
fn add(lines: &mut Centerlines, path: &Dataset, row: usize, scale: &Scale, room: &UnpackLimit) -> Result<(), Fault> {
    let fault = |found: String, accepted: &str| Fault::item(format!("{STRUCT}({}).{FIELD}", row + 1), found, accepted);
    let [3, n] = *path.shape() else {
        let shape: Vec<String> = path.shape().iter().rev().map(u64::to_string).collect();
        return Err(fault(format!("an array of {}", shape.join(" x ")), "expected points x 3"));
    };
    let wrong = || fault(format!("{n} points"), "expected fewer than 2^26 in all");
    ensure(n.saturating_add(lines.points.len() as u64) <= MOST_POINTS, wrong)?;
    room.take(24 * n as usize).map_err(|(found, accepted)| fault(found, accepted))?;
    let values = path.read_array::<f64>().map_err(|e| fault(format!("cannot be read: {e}"), "expected numbers"))?;
    let values = values.as_slice().unwrap_or_default();
    let n = n as usize;
    for point in 0..n {
        let axis = |which: usize| values.get(which * n + point).copied().unwrap_or(f64::NAN);
        let position = [axis(0), axis(1), axis(2)];
        let wrong = || fault(format!("point {} is {position:?}", point + 1), "expected finite numbers");
        ensure(position.iter().all(|x| x.is_finite()), wrong)?;
        let id = lines.points.len() as u64;
        let at = lines.add_point(scale.position(position), f64::NAN, id, row as u32);
        if point > 0 {
            lines.add_link([at - 1, at], "");
        }
    }
    Ok(())
}
