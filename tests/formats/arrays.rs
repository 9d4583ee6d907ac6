//! Skeleton graphs in `.npz` and VTrails' trees in `.mat`, against NumPy, SciPy and h5py.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::io::{Cursor, Write};

use crate::peers::{courses, network_of, positions, python, read_first, sizes, truncated};
use willis::internals::formats::{Content, Format, ReadOptions, read_skeleton_npz, read_vtrails, write_skeleton_npz};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::metres;
use willis::internals::network::{Network, Node, Origin, PathPoint, RadiusRule, Vessel};

fn mm() -> ReadOptions {
    ReadOptions::default()
}

fn optional() -> ReadOptions {
    ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() }
}

/// A Y whose trunk has a name, and a parallel vessel.
fn curved() -> Network {
    let mut network = Network::new();
    let at = [[0.0, 0.0, 0.0], [1.0 / 3.0, 0.1, 2.0], [5.0, 0.7, 1e-7], [5.5, -3.0, 1.0]];
    for (row, p) in at.iter().enumerate() {
        let (position, radius) = (Some(p.map(metres)), Some(metres(1.0 / (row + 3) as f64)));
        network.add_node(Node { id: row.to_string(), position, radius, ..Node::default() });
    }
    for ([a, b], middle, label) in [([0, 1], 0.1, "L-M1 é"), ([1, 2], 0.2, ""), ([1, 2], 0.4, "b"), ([2, 3], 0.3, "")] {
        let end = |n: usize| PathPoint { position: at[n].map(metres), radius: metres(1.0 / (n + 3) as f64), id: None };
        let inner = PathPoint { position: [middle, 1.0, middle / 3.0].map(metres), radius: metres(middle), id: None };
        let vessel = Vessel::along(vec![end(a), inner, end(b)], RadiusRule::Mean);
        network.add_vessel([a, b], Vessel { label: label.to_owned(), ..vessel });
    }
    network
}

fn straight() -> Network {
    let mut network = curved();
    for row in 0..network.vessel_count() {
        let vessel = network.vessel_mut(row);
        (vessel.length, vessel.radius) = (metres(7.0 + row as f64 / 3.0), metres(0.1 + row as f64 / 7.0));
        vessel.path.clear();
    }
    let again = network.vessel(0).clone();
    network.add_vessel([3, 3], again);
    network
}

fn written(network: &Network) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write_skeleton_npz(&mut out, network).unwrap();
    out.into_inner()
}

#[test]
fn a_network_comes_back_from_its_arrays() {
    let bytes = written(&curved());
    let document = read_first(&[("a.npz", &bytes)], &mm()).unwrap();
    assert_eq!(document.format, Format::Npz);
    let found = network_of(document);
    assert_eq!(positions(&found), positions(&curved()));
    assert_eq!(courses(&found), courses(&curved()));
    assert!(bytes == written(&curved()), "the same network gives the same bytes");
    let document = read_first(&[("a.npz", &written(&straight()))], &mm()).unwrap();
    assert!(matches!(document.content, Content::Vessels(_)));
    let found = network_of(document);
    assert_eq!((positions(&found), sizes(&found)), (positions(&straight()), sizes(&straight())));
    assert!(found.vessels().all(|(_, v)| v.origin == Origin::Observed));
}

#[test]
fn numpy_and_scipy_read_what_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a.npz", "b.npz"].map(|name| folder.path().join(name));
    std::fs::write(&paths[0], written(&curved())).unwrap();
    std::fs::write(&paths[1], written(&straight())).unwrap();
    let script = "
import sys, numpy as np, scipy.sparse as sp
a, b = (np.load(p) for p in sys.argv[1:])
assert sorted(a.files) == ['coords', 'edges', 'labels', 'radii'] and sorted(b.files) == sorted(a.files + ['lengths'])
assert a['coords'].shape == (8, 3) and a['coords'].dtype == 'f8' and a['edges'].shape == (8, 2) and a['edges'].dtype == 'i8'
assert a['radii'].shape == (8,) and a['coords'][1].tolist() == [1/3, 0.1, 2.0] and a['radii'][:2].tolist() == [1/3, 1/4]
assert a['labels'].tolist() == ['L-M1 é', 'L-M1 é', '', '', 'b', 'b', '', '']
i, j = a['edges'].T
assert sp.csgraph.connected_components(sp.coo_array((np.ones(8), (i, j)), (8, 8)), directed=False)[0] == 1
assert b['edges'].tolist() == [[0, 1], [1, 2], [1, 2], [2, 3], [3, 3]] and b['lengths'][1] == 7 + 1/3 and b['radii'][1] == 0.1 + 1/7
";
    python(script, &[&paths[0], &paths[1]]);
}

/// The Y that the scripts below write: trunk from 0 over 1 to 2, branches to 3 and 4.
fn is_y(lines: &Centerlines, label: &str, radii: [f64; 5]) {
    let mm = lines.points.iter().map(|p| p.map(|x| x * 1e3)).collect::<Vec<_>>();
    assert_eq!(mm, [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 1.5, 0.0], [3.0, -1.5, 0.25]]);
    assert_eq!(lines.links, [[0, 1], [1, 2], [2, 3], [2, 4]]);
    assert_eq!([0, 1, 2, 3].map(|link| lines.labels.of(link).to_owned()), [label, label, "", ""]);
    for (found, expected) in lines.radii.iter().zip(radii) {
        assert!((found * 1e3 - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn arrays_of_every_type_order_and_name_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let script = "
import sys, numpy as np, scipy.sparse as sp
out = sys.argv[1]
c = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 1.5, 0], [3, -1.5, 0.25]]); e = np.array([[0, 1], [1, 2], [2, 3], [2, 4]])
r = np.array([1, 0.5, 0.75, 2, 3]); l = np.array(['M1', 'M1', '', ''])
n = 0
for ct in ('<f8', '>f8', '<f4', '>f4'):
    for et in ('<i8', '>i8', '<i4', '<u4', '>u2', 'u1', 'i1'):
        for f in (np.asfortranarray, np.ascontiguousarray):
            for save in (np.savez, np.savez_compressed):
                save(f'{out}/read-{n}.npz', coords=f(c.astype(ct)), edges=f(e.astype(et)), radii=r.astype(ct), labels=l); n += 1
np.savez(f'{out}/read-s.npz', coordinates=c, edges=e, radius=r.reshape(-1, 1), labels=l.astype('S'), other=np.array([None]))
np.savez(f'{out}/read-big.npz', vertices=c, edges=e, radii=r, labels=l.astype('>U9'))
np.savez(f'{out}/number.npz', coords=c, edges=e, radii=r, labels=np.array([5, 5, 0, 0]))
np.savez(f'{out}/points.npz', coords=c, edges=e, radii=r, labels=np.array(['M1', 'M1', 'M1', '', '']))
np.savez(f'{out}/edges.npz', coords=c, edges=e, radii=np.array([1, 3, 0, 2]), labels=l)
np.savez(f'{out}/none.npz', coords=c, edges=e, labels=l)
np.savez(f'{out}/long.npz', coords=c, edges=e, radii=np.ones(4), lengths=np.arange(4) + 2.0)
np.savez(f'{out}/bad-lengths.npz', coords=c, edges=e, radii=r, lengths=np.arange(4) + 2.0)
np.savez(f'{out}/bad-object.npz', coords=c, edges=e, radii=np.array(r, dtype=object))
np.savez(f'{out}/bad-bool.npz', coords=c > 1, edges=e, radii=r)
np.savez(f'{out}/bad-struct.npz', coords=c, edges=np.zeros(4, dtype=[('a', 'i4'), ('b', 'i4')]), radii=r)
np.savez(f'{out}/bad-float.npz', coords=c, edges=e.astype(float), radii=r)
np.savez(f'{out}/bad-range.npz', coords=c, edges=e + 1, radii=r)
np.savez(f'{out}/bad-minus.npz', coords=c, edges=e - 1, radii=r)
np.savez(f'{out}/bad-nan.npz', coords=np.where(c == 0.25, np.nan, c), edges=e, radii=r)
np.savez(f'{out}/bad-flat.npz', coords=c[:, :2], edges=e, radii=r)
np.savez(f'{out}/bad-count.npz', coords=c, edges=e, radii=r[:3])
np.savez(f'{out}/bad-labels.npz', coords=c, edges=e, radii=r, labels=l[:3])
np.savez(f'{out}/bad-zero.npz', coords=c, edges=e[:0], radii=r)
np.savez(f'{out}/bad-names.npz', x=c, edges=e)
np.savez(f'{out}/bad-empty.npz')
sp.save_npz(f'{out}/bad-csr.npz', sp.csr_array(np.eye(3))); sp.save_npz(f'{out}/bad-coo.npz', sp.coo_array(np.eye(3)))
np.save(f'{out}/bad-one.npy', c)
";
    if python(script, &[folder.path()]).is_none() {
        return;
    }
    let load =
        |name: &str, options: &ReadOptions| read_first(&[(name, &std::fs::read(folder.path().join(name)).unwrap())], options);
    let lines = |name: &str, options: &ReadOptions| match load(name, options).unwrap().content {
        Content::Centerlines(lines) => lines,
        other => panic!("{name}: {other:?}"),
    };
    let names = std::fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
    let names: Vec<String> = names.filter(|name| name.starts_with("read-")).collect();
    assert_eq!(names.len(), 4 * 7 * 2 * 2 + 2);
    for name in names {
        is_y(&lines(&name, &mm()), "M1", [1.0, 0.5, 0.75, 2.0, 3.0]);
    }
    is_y(&lines("number.npz", &mm()), "5", [1.0, 0.5, 0.75, 2.0, 3.0]);
    is_y(&lines("points.npz", &mm()), "M1", [1.0, 0.5, 0.75, 2.0, 3.0]);
    // (1·1 + 3·1)/2; at the junction 3 over 1 and 2 over sqrt(13/4 + 1/16), the branch without a radius apart.
    let branch = (3.25_f64 + 0.0625).sqrt();
    let of_edges = lines("edges.npz", &mm());
    assert!(of_edges.radii[3].is_nan());
    let mut known = of_edges.clone();
    known.radii[3] = 0.0;
    let junction = (3.0 + 2.0 * branch) / (1.0 + branch);
    is_y(&known, "M1", [1.0, 2.0, junction, 0.0, 2.0]);
    // Vessels are as wide as their own edges, one without a radius as the junction.
    for (vessel, wanted) in sizes(&network_of(load("edges.npz", &mm()).unwrap())).iter().zip([2.0, junction, 2.0]) {
        assert!((vessel.3 - wanted).abs() < 1e-12, "{vessel:?} {wanted}");
    }
    assert!(lines("none.npz", &optional()).radii.iter().all(|r| r.is_nan()));
    let long = network_of(load("long.npz", &mm()).unwrap());
    assert_eq!(sizes(&long).iter().map(|v| (v.2, v.3)).collect::<Vec<_>>(), [(2.0, 1.0), (3.0, 1.0), (4.0, 1.0), (5.0, 1.0)]);
    let or_mask = "or a mask: mask, and affine or spacing";
    let graph = "expected a skeleton graph: coords (N, 3), edges (M, 2) and radii (N) or (M)";
    let types = "expected float32, float64, integers, or text for labels";
    for (name, said) in [
        ("none.npz", "no array radii among coords, edges, labels; expected radii, or give `default_radius`"),
        ("bad-object.npz", &format!("array radii: Python objects (pickled); {types}")),
        ("bad-bool.npz", &format!("array coords: values of type |b1; {types}")),
        ("bad-struct.npz", &format!("array edges: structured values; {types}")),
        ("bad-float.npz", "array edges: values that are not whole numbers; expected an integer type"),
        ("bad-range.npz", "array edges: row 3 names point 5; expected rows of coords, 0 to 4"),
        ("bad-minus.npz", "array edges: row 0 names point -1; expected rows of coords, 0 to 4"),
        ("bad-nan.npz", "array coords: row 4 is [3.0, -1.5, NaN]; expected finite numbers"),
        ("bad-flat.npz", "array coords: shape (5, 2); expected a row of 3 for each"),
        ("bad-count.npz", "array radii: 3 values; expected 5, one a point, or 4, one an edge"),
        ("bad-lengths.npz", "array lengths: beside radii of points; expected 4 radii, one an edge, or no lengths"),
        ("bad-labels.npz", "array labels: 3 values; expected 4, one an edge, or 5, one a point"),
        ("bad-zero.npz", "array edges: no edges; expected a row for every edge"),
        ("bad-names.npz", &format!("no array coords among x, edges; {graph}; {or_mask}")),
        ("bad-empty.npz", &format!("no array coords among nothing; {graph}; {or_mask}")),
        ("bad-csr.npz", &format!("a sparse matrix of scipy.sparse, such as likelihood.npz; {graph}")),
        ("bad-coo.npz", &format!("a sparse matrix of scipy.sparse, such as likelihood.npz; {graph}")),
        (
            "bad-one.npy",
            "array of voxels: 2 dimensions; expected a mask of three, or a skeleton graph as .npz: coords, edges, radii",
        ),
    ] {
        let found = load(name, &mm()).expect_err(name);
        assert_eq!(found, format!("{name}: {said}"));
    }
}

/// An `.npz` of one member with any header.
fn made(header: &str, data: &[u8], deflated: bool) -> Vec<u8> {
    let method = if deflated { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for name in ["coords", "edges", "radii"] {
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
        zip.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
        zip.write_all(header.as_bytes()).unwrap();
        zip.write_all(data).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn headers_that_promise_too_much_allocate_nothing() {
    let header = |descr: &str, shape: &str| format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let read = |header: &str, data: &[u8]| read_first(&[("a.npz", &made(header, data, false))], &mm()).unwrap_err();
    let most = "expected at most 134217728 values";
    assert_eq!(read(&header("'<f8'", "(99999999999, 3)"), b""), format!("a.npz: array coords: shape (99999999999, 3); {most}"));
    let huge = "(18446744073709551615, 18446744073709551615)";
    assert_eq!(read(&header("'<f8'", huge), b""), format!("a.npz: array coords: shape {huge}; {most}"));
    let short = "a.npz: array coords: shape (40000000, 3) needs 960000000 bytes, the file has 177; expected a whole file";
    assert_eq!(read(&header("'<f8'", "(40000000, 3)"), &[0; 100]), short);
    let short = "a.npz: array coords: shape (2, 3) needs 48 bytes, the file has 47; expected a whole file";
    assert_eq!(read(&header("'<f8'", "(2, 3)"), &[0; 47]), short);
    let unreadable = "expected descr, fortran_order and shape";
    for text in [
        "{",
        "",
        "{'descr': '<f8'}",
        "{'descr': '<f8', 'fortran_order': 1, 'shape': (1, 3)}",
        "(((((",
        "{'shape': (-1, 3), 'descr': '<f8', 'fortran_order': False}",
    ] {
        assert_eq!(read(text, &[0; 24]), format!("a.npz: array coords: header {text}; {unreadable}"));
    }
    let deep = "(".repeat(4000);
    assert_eq!(read(&deep, b""), "a.npz: array coords: not a NumPy array; expected .npy members");
    // A thousand million zeros in a megabyte: read as what its header says and no further.
    let bomb = made(&header("'<f8'", "(2, 3)"), &vec![0; 50_000_000], true);
    let said = read_first(&[("a.npz", &bomb)], &mm()).unwrap_err();
    assert_eq!(said, "a.npz: array coords: shape (2, 3) needs 48 bytes, the file has 49; expected a whole file");
}

#[test]
fn an_archive_cut_or_spoiled_anywhere_never_panics() {
    let bytes = written(&curved());
    assert_eq!(truncated(&[("a.npz", &bytes)], 1, &mm()), 0);
    let mut read = 0;
    for at in 0..bytes.len() {
        for to in [0, 0xff, bytes[at] ^ 1] {
            let mut spoiled = bytes.clone();
            spoiled[at] = to;
            read += usize::from(read_skeleton_npz(&spoiled, &ReadOptions::default()).is_ok());
        }
    }
    assert!(read > 0 && read < 3 * bytes.len());
}

/// A struct array as MATLAB 7.3 lays it out: a data set of references for each field, what they refer to in `#refs#`, a user
/// block of 512 bytes before the HDF5.
const MATLAB: &str = r##"
import h5py, numpy as np, struct, sys
def mat(path, paths, name="GeodesicMSTs", chunk=False, empty=False):
    with h5py.File(path, "w", userblock_size=512, libver="earliest") as f:
        refs, fields = f.create_group("#refs#"), {"CGPathContinuous": [], "GroupID": [], "isLeaf": []}
        def put(a, kind):
            packed = dict(chunks=True, compression="gzip", compression_opts=3) if chunk and a.size > 8 else {}
            d = refs.create_dataset("r%d" % len(refs), data=a.T, **packed)
            d.attrs["MATLAB_class"], d.attrs["H5PATH"] = np.bytes_(kind), np.bytes_("/GeodesicMSTs")
            return d
        g = f.create_group(name); g.attrs["MATLAB_class"] = np.bytes_("struct")
        if len(paths) == 1:
            d = g.create_dataset("CGPathContinuous", data=paths[0].T); d.attrs["MATLAB_class"] = np.bytes_("double")
        else:
            for p in paths:
                fields["CGPathContinuous"].append(put(p, "double").ref)
                fields["GroupID"].append(put(np.array([[1.0]]), "double").ref)
                fields["isLeaf"].append(put(np.array([[1]], "u1"), "logical").ref)
            if empty:
                d = put(np.array([0, 0], "u8"), "double"); d.attrs["MATLAB_empty"] = np.uint8(1)
                fields["CGPathContinuous"].append(d.ref)
            for k, r in fields.items():
                g.create_dataset(k, data=np.array(r, dtype=h5py.ref_dtype).reshape(-1, 1), dtype=h5py.ref_dtype)
        m = f.create_group("GeodesicMSTsMatrix"); m.attrs["MATLAB_class"] = np.bytes_("struct")
    with open(path, "r+b") as f:
        f.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64 HDF5 schema 1.00 .".ljust(116) + b"\0" * 8 + struct.pack("<H", 0x200) + b"IM")
out = sys.argv[1]
y = [np.array(p, float) for p in ([[0, 0, 0], [1, 0, 0], [2, 0.5, 0.25]], [[2, 0.5, 0.25], [3, 1, 1], [4, 2, 2]], [[2, 0.5, 0.25], [3, 0, 0]])]
mat(out + "/y.mat", y); mat(out + "/packed.mat", y, chunk=True, empty=True); mat(out + "/one.mat", y[:1])
mat(out + "/other.mat", y, name="Trees"); mat(out + "/flat.mat", [y[0][:, :2], y[1]]); mat(out + "/nan.mat", [y[0], y[1] * np.nan])
"##;

#[test]
fn the_trees_of_vtrails_are_read_from_matlab_s_hdf5() {
    let folder = tempfile::tempdir().unwrap();
    if python(MATLAB, &[folder.path()]).is_none() {
        return;
    }
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let load = |name: &str, options: &ReadOptions| read_first(&[(name, &bytes(name))], options);
    for (name, links) in [("y.mat", 5), ("packed.mat", 5), ("one.mat", 2)] {
        let document = load(name, &optional()).unwrap();
        assert_eq!(document.format, Format::VTrails);
        let void = document.notes.iter().any(|note| note == "1 paths are empty: left out");
        assert_eq!(void, name == "packed.mat");
        let Content::Centerlines(mut lines) = document.content else { panic!("{name}") };
        assert_eq!(lines.links.len(), links);
        assert_eq!(lines.points[2], [2.0, 0.5, 0.25].map(metres));
        lines.weld(1e-6);
        lines.radii.fill(1e-3);
        let network = willis::internals::network::contract(&lines, RadiusRule::Mean, None).unwrap().network;
        assert_eq!(network.vessel_count(), if links == 5 { 3 } else { 1 });
    }
    for (name, options, said) in [
        ("y.mat", mm(), "y.mat: VTrails' trees have no radii; give `default_radius`"),
        (
            "other.mat",
            optional(),
            "other.mat: HDF5 with GeodesicMSTsMatrix, Trees; expected a file of VTrails with the struct GeodesicMSTs; \
             other HDF5 and MATLAB files are not read",
        ),
        ("flat.mat", optional(), "flat.mat: GeodesicMSTs(1).CGPathContinuous: an array of 3 x 2; expected points x 3"),
        ("nan.mat", optional(), "nan.mat: GeodesicMSTs(2).CGPathContinuous: point 1 is [NaN, NaN, NaN]; expected finite numbers"),
    ] {
        assert_eq!(load(name, &options).unwrap_err(), said);
    }
    // What is cut off may be what nothing refers to; the rest is refused.
    let whole = bytes("packed.mat");
    truncated(&[("a.mat", &whole)], 7, &optional());
    for at in (0..whole.len()).step_by(5) {
        let mut spoiled = whole.clone();
        spoiled[at] ^= 0xa5;
        let _ = read_vtrails(&spoiled, &ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() });
    }
}
