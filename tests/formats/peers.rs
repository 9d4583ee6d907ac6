//! What tests of formats share: Python, files in a folder of their own, and what two networks have in common.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;

use willis::internals::formats::convert::{Target, write_into};
use willis::internals::formats::{Content, Document, ReadOptions, read, write_loops};
use willis::internals::network::units::millimetres;
use willis::internals::network::{Network, RadiusRule, contract};

/// Every word for a format that is written, with the name of a file of it.
pub const FILES: [(&str, &str); 12] = [
    ("swc", "a.swc"),
    ("vtp", "a.vtp"),
    ("vtk", "a.vtk"),
    ("graphml", "a.graphml"),
    ("csv", "edges.csv"),
    ("points", "a.csv"),
    ("voreen", "edges.csv"),
    ("vesselvio", "edges.csv"),
    ("markups", "a.mrk.json"),
    ("tre", "a.tre"),
    ("npz", "a.npz"),
    ("amira", "a.am"),
];

/// Runs a script with a python that has the peers' packages; `None` where there is none.
pub fn python(script: &str, arguments: &[&Path]) -> Option<String> {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no python");
        return None;
    };
    let output = Command::new(python).arg("-c").arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap().trim().to_owned())
}

/// A file or folder of the shared data; `None`, said, where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    beside_package("../shared/data", name)
}

/// A file of the small cases that once failed; `None`, said, where it is absent.
pub fn case(name: &str) -> Option<PathBuf> {
    beside_package("../shared/cases-in", name)
}

fn beside_package(folder: &str, name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join(name);
    if !path.exists() {
        eprintln!("skipped: no {name} beside the package");
    }
    path.exists().then_some(path)
}

/// Reads a file of its own; an error without the folder's name.
pub fn document(name: &str, content: &[u8]) -> Result<Document, String> {
    read_first(&[(name, content)], &ReadOptions::default())
}

/// Reads the first of some files that lie in one folder; an error without the folder's name.
pub fn read_first(files: &[(&str, &[u8])], options: &ReadOptions) -> Result<Document, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let place = format!("{}/", folder.path().display());
    read(&folder.path().join(files[0].0), options)
        .map(|mut document| {
            document.notes.iter_mut().for_each(|note| *note = note.replace(&place, ""));
            document
        })
        .map_err(|error| error.to_string().replace(&place, ""))
}

/// The vessels that a document comes to.
pub fn network_of(document: Document) -> Network {
    match document.content {
        Content::Vessels(network) | Content::Graph(network) => network,
        Content::Centerlines(mut lines) => {
            lines.weld(1e-6);
            contract(&lines, RadiusRule::Mean, None).unwrap().network
        }
    }
}

/// Positions, mm, by node.
pub fn positions(network: &Network) -> Vec<[f64; 3]> {
    network.nodes().map(|n| n.position.unwrap().map(millimetres)).collect()
}

/// Ends, label, and points with radii (mm) of every vessel.
pub fn courses(network: &Network) -> Vec<([usize; 2], String, Vec<[f64; 4]>)> {
    let point = |p: &willis::internals::network::PathPoint| {
        let [x, y, z] = p.position.map(millimetres);
        [x, y, z, millimetres(p.radius)]
    };
    network.vessels().map(|(ends, v)| (ends, v.label.clone(), v.path.iter().map(point).collect())).collect()
}

/// Ends, label, length and radius (mm) of every vessel.
pub fn sizes(network: &Network) -> Vec<([usize; 2], String, f64, f64)> {
    network.vessels().map(|(ends, v)| (ends, v.label.clone(), millimetres(v.length), millimetres(v.radius))).collect()
}

/// Every prefix of a file is read or refused in one line; none may panic. Returns how many are read.
pub fn truncated(files: &[(&str, &[u8])], step: usize, options: &ReadOptions) -> usize {
    let mut whole = 0;
    for length in (0..files[0].1.len()).step_by(step) {
        let mut cut = files.to_vec();
        cut[0].1 = &files[0].1[..length];
        match read_first(&cut, options) {
            Ok(_) => whole += 1,
            Err(line) => assert!(!line.contains('\n') && line.contains(';'), "{length}: {line}"),
        }
    }
    whole
}

/// The files of a conversion with their bytes, the one that was named first.
pub fn converted(network: &Network, target: &Target) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut vessels, mut nodes, mut loops) = (Vec::new(), Vec::new(), Vec::new());
    let written =
        write_into(network, target, Cursor::new(&mut vessels), &mut nodes).unwrap_or_else(|e| panic!("{target:?}: {e}"));
    write_loops(&mut loops, &written.loops).expect("a table");
    let mut files = vec![(target.path.clone(), vessels)];
    files.extend(target.nodes.clone().map(|path| (path, nodes)));
    files.extend((!written.loops.is_empty()).then(|| (target.loops(), loops)));
    files
}
