//! Readers against files of VMTK, VTK, NetworkX, igraph, BraVa and INSIST, with VTK as the judge of what they hold.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use crate::peers::{python, shared};
use willis::internals::formats::{Content, ReadOptions, read, read_graphml, read_vtp};
use willis::internals::network::units::{metres, pascals};
use willis::internals::network::{Condition, Origin, RadiusRule, Role, contract, cycles};

#[test]
fn five_encodings_of_one_geometry_agree() {
    let Some(folder) = shared("formats") else { return };
    let read = |name: &str| read_vtp(&std::fs::read(folder.join(name)).unwrap(), &ReadOptions::default()).unwrap().0;
    let reference = read("y-vmtkcenterlinemerge.vtp");
    assert_eq!((reference.points.len(), reference.links.len()), (144, 143));
    for name in ["y-xml-ascii.vtp", "y-xml-binary.vtp", "y-xml-appended.vtp"] {
        assert!(read(name) == reference, "{name}");
    }
    let Some(script) = std::env::var_os("WILLIS_PYTHON").map(|_| ENCODINGS) else { return };
    let out = tempfile::tempdir().unwrap();
    let Some(written) = python(script, &[&folder.join("y-xml-ascii.vtp"), out.path()]) else { return };
    assert_eq!(written, "26");
    for file in std::fs::read_dir(out.path()).unwrap() {
        let file = file.unwrap().path();
        let found = read_vtp(&std::fs::read(&file).unwrap(), &ReadOptions::default()).unwrap().0;
        assert!(found == reference, "{}", file.display());
    }
}

const ENCODINGS: &str = r"
import sys, vtk, itertools
r = vtk.vtkXMLPolyDataReader(); r.SetFileName(sys.argv[1]); r.Update()
n = 0
for mode, b64, zlib, big, wide in itertools.product(range(3), (0, 1), (0, 1), (0, 1), (0, 1)):
    if mode != 2 and b64: continue
    if mode == 0 and (zlib or big): continue
    w = vtk.vtkXMLPolyDataWriter(); w.SetInputData(r.GetOutput()); w.SetFileName(f'{sys.argv[2]}/{n}.vtp')
    (w.SetDataModeToAscii, w.SetDataModeToBinary, w.SetDataModeToAppended)[mode]()
    w.SetEncodeAppendedData(b64)
    w.SetCompressorTypeToZLib() if zlib else w.SetCompressorTypeToNone()
    w.SetByteOrderToBigEndian() if big else w.SetByteOrderToLittleEndian()
    w.SetHeaderTypeToUInt64() if wide else w.SetHeaderTypeToUInt32()
    w.SetBlockSize(1024)
    assert w.Write() == 1; n += 1
print(n)
";

#[test]
fn the_y_of_vmtk_is_three_vessels() {
    let Some(folder) = shared("formats") else { return };
    for name in ["y-vmtknetworkextraction.vtp", "y-vmtkcenterlinemerge.vtp"] {
        let (mut lines, _) = read_vtp(&std::fs::read(folder.join(name)).unwrap(), &ReadOptions::default()).unwrap();
        lines.weld(1e-6);
        let found = contract(&lines, RadiusRule::Mean, None).unwrap().network;
        assert_eq!((found.node_count(), found.vessel_count()), (4, 3), "{name}");
    }
}

#[test]
fn files_of_networkx_and_igraph_are_read() {
    let Some(folder) = shared("formats") else { return };
    for name in ["networkx.graphml", "igraph.graphml"] {
        let document = read(&folder.join(name), &ReadOptions::default()).unwrap();
        let Content::Graph(g) = document.content else { panic!() };
        assert_eq!((g.node_count(), g.vessel_count(), cycles(&g)), (5, 6, 2), "{name}");
        assert_eq!(g.node(0).condition, Some(Condition::Pressure(pascals(100.0))));
        assert_eq!(g.node(2).position, Some([16.0, 6.0, 1.0].map(metres)));
        assert_eq!(g.node(4).condition, Some(Condition::Pressure(0.0)));
        assert_eq!(g.vessel(0).radius, metres(1.5));
    }
    let (g, _) = read_graphml(&std::fs::read(folder.join("networkx.graphml")).unwrap()[..], &ReadOptions::default()).unwrap();
    assert_eq!(g.node(2).label, "L <M1> & é");
    assert_eq!((g.node(0).role, g.node(4).role), (Some(Role::Inlet), Some(Role::Outlet)));
    assert_eq!(g.vessels().filter(|(_, v)| v.origin == Origin::Candidate).count(), 1);
}

#[test]
fn every_brava_file_agrees_with_vtk() {
    let Some(folder) = shared("brava/vtp") else { return };
    let mut ours = Vec::new();
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|f| f.unwrap().path()).collect();
    files.sort();
    for file in files {
        let Content::Centerlines(lines) = read(&file, &ReadOptions::default()).unwrap().content else { panic!() };
        assert!(lines.points.len() > 2000);
        let sum: f64 = lines.radii.iter().sum::<f64>() * 1e3;
        let place: f64 = lines.points.iter().flatten().map(|x| x.abs()).sum::<f64>() * 1e3;
        ours.push(format!("{} {} {sum:.4} {place:.1}", lines.points.len(), lines.links.len()));
    }
    let script = r"
import sys, vtk, glob
from vtk.util.numpy_support import vtk_to_numpy as a
for f in sorted(glob.glob(sys.argv[1] + '/*')):
    r = vtk.vtkXMLPolyDataReader(); r.SetFileName(f); r.Update(); p = r.GetOutput()
    used = set(); links = 0
    l = p.GetLines(); l.InitTraversal(); ids = vtk.vtkIdList()
    while l.GetNextCell(ids):
        row = [ids.GetId(i) for i in range(ids.GetNumberOfIds())]; used.update(row); links += len(row) - 1
    used = sorted(used)
    s = a(p.GetPointData().GetArray('Radius')).astype(float)[used].sum(); q = abs(a(p.GetPoints().GetData()).astype(float)[used]).sum()
    print(len(used), links, f'{s:.4f}', f'{q:.1f}')
";
    if let Some(theirs) = python(script, &[&folder]) {
        assert_eq!(ours.join("\n"), theirs);
    }
}

#[test]
fn every_insist_file_is_a_forest_of_all_its_lines() {
    let Some(folder) = shared("insist-cow") else { return };
    let mut files = 0;
    for subject in std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).filter(|p| p.is_dir()) {
        let file = subject.join("tracing_ves_TH_XX_X.swc");
        let text = std::fs::read_to_string(&file).unwrap();
        let Content::Centerlines(lines) = read(&file, &ReadOptions::default()).unwrap().content else { panic!() };
        let rows = text.lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'));
        let roots = rows.clone().filter(|l| l.trim_end().ends_with(" -1")).count();
        assert_eq!(lines.points.len(), rows.count());
        assert_eq!(lines.points.len() - lines.links.len(), roots);
        assert_eq!(*lines.strand.iter().max().unwrap() as usize + 1, roots);
        files += 1;
    }
    assert!(files > 20);
}
