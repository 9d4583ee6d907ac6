//! Files read as their authors meant them: masks that went through real numbers, missing values, arrays in C order, and what a folder
//! means. Truth: the same content written plainly, and nibabel, NetworkX and igraph as writers.

use std::fs;
use std::path::Path;

use willis::Result;
use willis::internals::formats::{Format, ReadOptions, write_nifti};
use willis::internals::masks::Mask;

use crate::command::{data, folder, stderr, willis};
use crate::masks::mask;
use crate::peers::python;
use crate::refused::refused;

const AFFINE: [[f64; 4]; 3] = [[0.5, 0.0, 0.0, -10.0], [0.0, 0.5, 0.0, -10.0], [0.0, 0.0, 0.5, 5.0]];

/// A tube along z in two classes.
fn tube(class: impl Fn(usize) -> u8) -> Mask {
    let mut drawn = mask([16, 16, 40], |[x, y, z]| (x as f64 - 7.5).hypot(y as f64 - 7.5) < 3.2 && (4..36).contains(&z));
    for (row, value) in drawn.classes.iter_mut().enumerate() {
        *value *= class(row / (16 * 16));
    }
    Mask::new(drawn.shape, drawn.classes, AFFINE)
}

/// The bytes of a mask as NIfTI, one byte a voxel by `stored`, with this slope and intercept.
fn nifti(mask: &Mask, stored: impl Fn(u8) -> u8, slope: [f32; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_nifti(&mut bytes, mask, false).expect("written");
    bytes[112..116].copy_from_slice(&slope[0].to_le_bytes());
    bytes[116..120].copy_from_slice(&slope[1].to_le_bytes());
    bytes[352..].iter_mut().for_each(|voxel| *voxel = stored(*voxel));
    bytes
}

fn read(bytes: &[u8]) -> Result<Mask> {
    Format::Nifti.read_mask(Path::new("a.nii"), bytes, &ReadOptions::default())
}

#[test]
fn classes_that_went_through_real_numbers_are_whole() {
    let plain = tube(|z| if z < 20 { 1 } else { 3 });
    // Classes of 0 to 3 in steps of a 255th of the largest: 1 is 1.00000006.
    let scaled = read(&nifti(&plain, |class| class * 85, [3.0 / 255.0, 0.0])).expect("a mask");
    assert_eq!((&scaled.classes, scaled.notes.len()), (&plain.classes, 0));
    // The largest is 4, and 1 is 64 steps: 1.0039, within half a step.
    let four = tube(|z| if z < 20 { 1 } else { 4 });
    let scaled = read(&nifti(&four, |class| (f64::from(class) * 63.75).round() as u8, [4.0 / 255.0, 0.0])).expect("a mask");
    assert_eq!(scaled.classes, four.classes);
    // A slope of 0 or NaN, an intercept of NaN: none.
    for slope in [[0.0, 0.0], [f32::NAN, f32::NAN], [1.0, f32::NAN], [0.0, 7.0]] {
        assert_eq!(read(&nifti(&plain, |class| class, slope)).expect("a mask").classes, plain.classes, "{slope:?}");
    }
    // In an image of real numbers every value is near a whole one, or it is none.
    let wanted = "classes are rounded: 2.0234";
    let old = tube(|z| if z < 20 { 1 } else { 2 });
    let steps = read(&nifti(&old, |class| [0, 84, 172][usize::from(class)], [0.011_764_5, 0.0])).expect("a mask");
    assert_eq!(steps.classes, old.classes);
    assert!(steps.notes.len() == 1 && steps.notes[0].starts_with(wanted), "{:?}", steps.notes);
}

#[test]
fn probabilities_and_images_are_no_classes() {
    let ramp = tube(|z| z as u8);
    for (stored, slope) in [
        (Box::new(|class: u8| class * 6) as Box<dyn Fn(u8) -> u8>, [1.0 / 255.0, 0.0]),
        (Box::new(|class: u8| class), [0.25, 0.0]),
        (Box::new(|class: u8| class), [1.1, 0.1]),
    ] {
        let said = read(&nifti(&ramp, stored, slope)).map(|mask| mask.notes).expect_err("an image").to_string();
        assert!(said.contains("looks like an image, not a mask"), "{slope:?}: {said}");
    }
    // Two values of one class are no mask in steps.
    let two = tube(|z| if z < 20 { 9 } else { 10 });
    assert!(read(&nifti(&two, |class| class, [0.1, 0.05])).is_err());
}

#[test]
fn nibabel_saves_classes_as_real_numbers() {
    let here = folder();
    let script = r#"
import sys, numpy as np, nibabel as nib
data = np.zeros((16, 16, 40))
x, y = np.meshgrid(np.arange(16) - 7.5, np.arange(16) - 7.5, indexing="ij")
data[:, :, 4:36][np.hypot(x, y) < 3.2] = 1
data[:, :, 20:][data[:, :, 20:] > 0] = 3
affine = np.diag([.5, .5, .5, 1])
nib.save(nib.Nifti1Image(data.astype(np.uint8), affine), sys.argv[1] + "/plain.nii.gz")
image = nib.Nifti1Image(data, affine)
image.set_data_dtype(np.uint8)
nib.save(image, sys.argv[1] + "/scaled.nii.gz")
np.save(sys.argv[1] + "/plain.npy", data)
np.savez_compressed(sys.argv[1] + "/batch.npz", mask=data[None], affine=affine)
np.savez(sys.argv[1] + "/spaced.npz", arr_0=np.asfortranarray(data), spacing=[.5, .5, .5])
print(nib.load(sys.argv[1] + "/scaled.nii.gz").dataobj.slope)
"#;
    let Some(slope) = python(script, &[here.path()]) else { return };
    assert!(slope.starts_with("0.0117"), "{slope}");
    let lines = |name: &str, more: &[&str]| {
        let done = willis(here.path(), &[&["skeleton", name, "-o", "out.csv", "--force"], more].concat());
        assert!(done.status.success(), "{name}: {}", stderr(&done));
        (fs::read_to_string(here.path().join("out.csv")).expect("a table"), stderr(&done))
    };
    let (plain, said) = lines("plain.nii.gz", &[]);
    assert!(said.contains("16 x 16 x 40 voxels of 0.5 x 0.5 x 0.5 mm") && said.contains("scanner's frame"), "{said}");
    for name in ["scaled.nii.gz", "batch.npz", "spaced.npz"] {
        let (table, said) = lines(name, &[]);
        assert_eq!(table, plain, "{name}");
        assert!(said.contains("16 x 16 x 40 voxels"), "{name}: {said}");
        assert_eq!(said.contains("nobody states which way"), name == "spaced.npz", "{name}: {said}");
    }
    let (table, said) = lines("plain.npy", &["--spacing", "0.5", "--frame", "RAS"]);
    assert_eq!(table, plain);
    assert!(said.contains("16 x 16 x 40 voxels of 0.5"), "{said}");
}

/// An array counts its axes as NumPy does: in errors, in notes, whatever the order of its bytes.
#[test]
fn an_array_in_c_order_is_told_in_its_own_axes() {
    let array = |fortran: bool, at: [usize; 3], value: f32| {
        let shape = [4, 5, 6];
        let order = if fortran { "True" } else { "False" };
        let mut header = format!("{{'descr': '<f4', 'fortran_order': {order}, 'shape': (4, 5, 6), }}");
        header.push_str(&" ".repeat((128 - 11 - header.len()) % 64));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.into_bytes());
        let mut values = vec![0.0_f32; 120];
        let place =
            if fortran { (at[2] * shape[1] + at[1]) * shape[0] + at[0] } else { (at[0] * shape[1] + at[1]) * shape[2] + at[2] };
        values[place] = value;
        bytes.extend(values.into_iter().flat_map(f32::to_le_bytes));
        bytes
    };
    for fortran in [false, true] {
        let wrong = array(fortran, [3, 1, 2], 7.4);
        refused(&[("a.npy", &wrong)], &["skeleton", "a.npy", "-o", "b.csv", "--spacing", "1,2,3"], &["voxel 3,1,2", "7.4"]);
    }
}

/// NaN, NA and nothing are the same: no value, in every attribute and format.
#[test]
fn missing_is_missing() {
    let here = folder();
    let nodes = |missing: &str| {
        format!(
            "node,x_mm,y_mm,z_mm,label,role,pressure_mmHg,radius_mm,found\n0,0,0,0,{missing},inlet,90,{missing},{missing}\n1,10,0,0,BA,{missing},{missing},1,false\n2,10,9,0,{missing},outlet,{missing},{missing},{missing}\n"
        )
    };
    let edges = |missing: &str| {
        format!(
            "node_a,node_b,length_mm,radius_mm,label,origin,prior,certain,kept,points,resistance_mmHg_s_per_mL,pwv_m_per_s\n0,1,{missing},1,{missing},{missing},{missing},{missing},{missing},{missing},{missing},{missing}\n1,2,12,0.8,BA,observed,0.5,true,true,{missing},{missing},{missing}\n"
        )
    };
    let converted = |missing: &str| {
        fs::write(here.path().join("c.csv"), edges(missing)).expect("written");
        fs::write(here.path().join("c.nodes.csv"), nodes(missing)).expect("written");
        let done = willis(here.path(), &["convert", "c.csv", "out.graphml", "--force"]);
        assert!(done.status.success(), "{missing}: {}", stderr(&done));
        fs::read_to_string(here.path().join("out.graphml")).expect("a graph")
    };
    let empty = converted("");
    for missing in ["NaN", "nan", "-nan", "NA", "<NA>", "N/A", "n/a"] {
        assert_eq!(converted(missing), empty, "{missing}");
    }
    for (attribute, row) in [("radius_mm", "0,1,5,inf"), ("length_mm", "0,1,-inf,1"), ("radius_mm", "0,1,5,Infinity")] {
        let table = format!("node_a,node_b,length_mm,radius_mm\n{row}\n");
        refused(
            &[("a.csv", table.as_bytes())],
            &["convert", "a.csv", "b.graphml", "--default-radius", "1"],
            &["a.csv:2", attribute, "finite"],
        );
    }
}

#[test]
fn graphml_of_networkx_and_igraph_has_no_artery_called_nan() {
    let here = folder();
    let script = r#"
import sys, networkx as nx
g = nx.Graph()
for n in range(4):
    g.add_node(n, x=10. * n, y=0., z=0.)
for n in range(3):
    g.add_edge(n, n + 1, radius_mm=1., label=float("nan"), origin="observed", length_mm=float("nan") if n else 12.)
nx.write_graphml(g, sys.argv[1] + "/nx.graphml")
"#;
    let Some(_) = python(script, &[here.path()]) else { return };
    let convert = |name: &str| {
        let done = willis(here.path(), &["convert", name, "edges.csv", "--force"]);
        assert!(done.status.success(), "{}", stderr(&done));
        fs::read_to_string(here.path().join("edges.csv")).expect("a table")
    };
    assert!(fs::read_to_string(here.path().join("nx.graphml")).expect("text").contains("attr.type=\"double\""));
    assert!(!convert("nx.graphml").to_lowercase().contains("nan"));
    // As igraph writes a graph whose vertices have ids.
    let igraph = r#"<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
  <key id="v_id" for="node" attr.name="id" attr.type="string"/>
  <key id="v_x" for="node" attr.name="x" attr.type="double"/><key id="v_y" for="node" attr.name="y" attr.type="double"/>
  <key id="v_z" for="node" attr.name="z" attr.type="double"/><key id="e_radius" for="edge" attr.name="radius_mm" attr.type="double"/>
  <graph id="G" edgedefault="undirected">
    <node id="n0"><data key="v_id">carotid</data><data key="v_x">0</data><data key="v_y">0</data><data key="v_z">0</data></node>
    <node id="n1"><data key="v_id">17</data><data key="v_x">9</data><data key="v_y">0</data><data key="v_z">0</data></node>
    <edge source="n0" target="n1"><data key="e_radius">2</data></edge>
  </graph>
</graphml>"#;
    fs::write(here.path().join("i.graphml"), igraph).expect("written");
    convert("i.graphml");
    let nodes =
        fs::read_to_string(here.path().join("edges.nodes.csv")).or_else(|_| fs::read_to_string(here.path().join("nodes.csv")));
    let nodes = nodes.expect("a table of nodes");
    assert!(nodes.contains("carotid") && nodes.contains("17"), "{nodes}");
}

/// `to_directed` of NetworkX has each edge of a graph in both directions, which `to_undirected` makes one again. What is not the same in both is two vessels.
#[test]
fn graphml_of_a_directed_graph_has_each_vessel_once() {
    let here = folder();
    let script = r#"
import sys, networkx as nx
here = sys.argv[1]
g = nx.Graph()
for n in range(3):
    g.add_node(n, x=10. * n, y=0., z=0.)
    g.add_edge(n, (n + 1) % 3, radius_mm=1. + n, length_mm=12., points="".join(f"{10. * m} 0 0 1;" for m in (n, (n + 1) % 3)))
both = g.to_directed()
nx.write_graphml(both, here + "/both.graphml")
nx.write_graphml(both.to_undirected(), here + "/once.graphml")
with open(here + "/both.csv", "w") as rows:
    print("node_a,node_b,radius_mm,length_mm", *(f"{a},{b},{of['radius_mm']},12" for a, b, of in both.edges(data=True)), sep="\n", file=rows)
both.add_edge(1, 0, radius_mm=.5, length_mm=15.)
nx.write_graphml(both, here + "/double.graphml")
"#;
    let Some(_) = python(script, &[here.path()]) else { return };
    let convert = |name: &str| {
        let done = willis(here.path(), &["convert", name, "edges.csv", "--force"]);
        assert!(done.status.success(), "{}", stderr(&done));
        (fs::read_to_string(here.path().join("edges.csv")).expect("a table"), stderr(&done))
    };
    let (both, said) = convert("both.graphml");
    assert_eq!(both, convert("once.graphml").0);
    assert!(said.contains("undirected, 3 edges in both directions, as one vessel"), "{said}");
    let (double, said) = convert("double.graphml");
    assert_eq!(double.lines().count(), 1 + 4, "{double}");
    assert!(said.contains("2 edges in both directions"), "{said}");
    // A table says nothing of directions.
    let (twice, said) = convert("both.csv");
    assert_eq!(twice.lines().count(), 1 + 6, "{twice}");
    assert!(said.contains("3 edges like another from its other end"), "{said}");
}

/// A class that went through real numbers is whole, a missing one is none, an infinite one an error where its type is a number.
#[test]
fn labels_that_went_through_real_numbers_are_names() {
    let here = folder();
    let script = r#"
import sys, numpy as np, networkx as nx, pandas as pd, vtk
from vtk.util.numpy_support import numpy_to_vtk
here, nan = sys.argv[1], float("nan")
for name, labels in [("nx", [16, nan, 3.]), ("inf", [16., float("inf"), 3.])]:
    g = nx.Graph()
    for n in range(4):
        g.add_node(n, x=9. * n, y=0.5, z=0.)
    for n in range(3):
        g.add_edge(n, n + 1, radius_mm=1., label=labels[n])
    nx.write_graphml(g, f"{here}/{name}.graphml")
table = pd.DataFrame(dict(node_a=[0, 1, 2], node_b=[1, 2, 3], length_mm=9., radius_mm=1., label=[16, None, 3]))
table.to_csv(f"{here}/pandas.csv", index=False)
at = np.array([[9. * (n % 2), 9. * (n // 2), .5] for n in range(6)])
points = pd.DataFrame(dict(fragment=np.arange(6) // 2, x=at[:, 0], y=at[:, 1], z=.5, radius=1, label=[16, 16, None, None, 3, 3]))
points.to_csv(f"{here}/points.csv", index=False)
np.savez(f"{here}/numpy.npz", coords=at, edges=np.arange(6).reshape(3, 2), radii=np.ones(6), labels=[16, nan, 3])
places, cells, data = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
places.SetData(numpy_to_vtk(at, deep=True))
for n in range(3):
    cells.InsertNextCell(2, [2 * n, 2 * n + 1])
data.SetPoints(places)
data.SetLines(cells)
for name, values, to in [("Radius", np.ones(6), data.GetPointData()), ("labels", np.array([16, nan, 3]), data.GetCellData())]:
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    to.AddArray(array)
for mode in ["Ascii", "Binary"]:
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetInputData(data)
    writer.SetFileName(f"{here}/{mode}.vtp")
    writer.SetCompressorTypeToLZ4()
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.Write()
"#;
    let Some(_) = python(script, &[here.path()]) else { return };
    for name in ["nx.graphml", "pandas.csv", "points.csv", "numpy.npz", "Ascii.vtp"] {
        let done = willis(here.path(), &["convert", name, "out.csv", "--force"]);
        assert!(done.status.success(), "{name}: {}", stderr(&done));
        let table = fs::read_to_string(here.path().join("out.csv")).expect("a table");
        let column = table.lines().next().and_then(|header| header.split(',').position(|name| name == "label")).expect("labels");
        let labels: Vec<&str> = table.lines().skip(1).filter_map(|line| line.split(',').nth(column)).collect();
        assert_eq!(labels, ["16", "", "3"], "{name}: {table}");
    }
    let bytes = |name: &str| fs::read(here.path().join(name)).expect("written");
    refused(&[("a.graphml", &bytes("inf.graphml"))], &["convert", "a.graphml", "b.csv"], &["a.graphml:", "label inf", "finite"]);
    // What is not written in digits is packed, and not by zlib.
    refused(
        &[("a.vtp", &bytes("Binary.vtp"))],
        &["convert", "a.vtp", "b.csv"],
        &["vtkLZ4DataCompressor", "SetCompressorTypeToZLib()"],
    );
}

#[test]
fn swc_of_other_programs() {
    let here = folder();
    let plain = "1 0 0 0 0 1 -1\n2 0 5 0 0 0 1\n3 0 10 0 0 2 2\n";
    let read = |name: &str, text: &str| {
        fs::write(here.path().join(name), text).expect("written");
        let done = willis(here.path(), &["convert", name, "out.csv", "--to", "points", "--force"]);
        assert!(done.status.success(), "{name}: {}", stderr(&done));
        fs::read_to_string(here.path().join("out.csv")).expect("a table")
    };
    let wanted = read("plain.swc", plain);
    for (name, text) in [
        ("nan.swc", plain.replace(" 0 1\n", " nan 1\n")),
        ("root.swc", plain.replace("-1", "0")),
        ("cr.swc", plain.replace('\n', "\r")),
        ("crlf.swc", plain.replace('\n', "\r\n")),
    ] {
        assert_eq!(read(name, &text), wanted, "{name}");
    }
    refused(&[("a.swc", b"1 0 0 0 0 1 -1\n2 0 1 0 0 1 7\n")], &["convert", "a.swc", "b.vtp"], &["a.swc:2", "parent 7"]);
}

/// The folder of a run is its plausible topology; the over-connected graph has a name of its own.
#[test]
fn the_folder_of_a_run_is_its_topology() {
    let here = folder();
    let done = willis(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "run", "--quiet"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let convert = |input: &str| {
        let done = willis(here.path(), &["convert", input, "out.csv", "--force"]);
        assert!(done.status.success(), "{}", stderr(&done));
        (fs::read_to_string(here.path().join("out.csv")).expect("a table"), stderr(&done))
    };
    let (folder, said) = convert("run");
    assert_eq!(folder, convert("run/topology.graphml").0);
    assert!(said.contains("the plausible topology of a run; run/candidates.graphml has all candidates"), "{said}");
    let all = convert("run/candidates.graphml").0;
    assert!(all.lines().count() > folder.lines().count());
    let simulate = |input: &str| {
        let done = willis(here.path(), &["simulate", input, "-o", "flow", "--force", "--quiet"]);
        assert!(done.status.success(), "{}", stderr(&done));
        fs::read_to_string(here.path().join("flow/edges.csv")).expect("a table")
    };
    assert_eq!(simulate("run"), simulate("run/topology.graphml"));
    // The table of edges says which of them were pruned.
    let edges = fs::read_to_string(here.path().join("run/edges.csv")).expect("a table");
    let column = edges.lines().next().and_then(|header| header.split(',').position(|name| name == "kept")).expect("a column");
    let pruned = edges.lines().filter(|line| line.split(',').nth(column) == Some("0")).count();
    let (kept, said) = convert("run/edges.csv");
    assert!(pruned > 0 && said.contains(&format!("{pruned} edges that a run pruned (kept is 0), left out")), "{said}");
    assert_eq!(kept.lines().count(), edges.lines().count() - pruned);
}

#[test]
fn openbf_joins_three_vessels_at_most() {
    let table = "node_a,node_b,length_mm,radius_mm\n0,1,9,1\n1,2,9,1\n1,3,9,1\n1,4,9,1\n";
    let nodes = "node,role,pressure_mmHg\n0,inlet,90\n1,inner,\n2,outlet,0\n3,outlet,0\n4,outlet,0\n";
    let here = folder();
    fs::write(here.path().join("a.csv"), table).expect("written");
    fs::write(here.path().join("a.nodes.csv"), nodes).expect("written");
    let done = willis(here.path(), &["convert", "a.csv", "a.yaml"]);
    let said = stderr(&done);
    assert!(done.status.success() && said.contains("the pressure or flow of 1 inlet,"), "{said}");
    assert!(said.contains("1 node of more than 3 vessels divided, by 1 vessel one radius long"), "{said}");
    let model = fs::read_to_string(here.path().join("a.yaml")).expect("a model");
    let of = |key: &str| -> Vec<&str> { model.lines().filter_map(|line| line.trim().strip_prefix(key)).collect() };
    let mut at: std::collections::BTreeMap<&str, usize> = std::collections::BTreeMap::new();
    of("sn: ").into_iter().chain(of("tn: ")).for_each(|node| *at.entry(node).or_default() += 1);
    assert_eq!((of("L: "), at.values().copied().max()), (vec!["0.009", "0.009", "0.009", "0.009", "0.001"], Some(3)));
}

/// A loop of one vessel and a part that no blood enters reach both solvers; openBF's tubes are as long in all.
#[test]
fn what_no_blood_enters_is_left_out_for_a_solver() {
    let here = folder();
    let table = "node_a,node_b,length_mm,radius_mm\n0,2,9,1\n2,2,6,1\n3,4,7,1\n";
    fs::write(here.path().join("a.csv"), table).expect("written");
    let nodes = "node,role,pressure_mmHg\n0,inlet,90\n1,outlet,0\n2,inner,\n3,outlet,0\n4,outlet,0\n";
    fs::write(here.path().join("a.nodes.csv"), nodes).expect("written");
    for output in ["a.yaml", "a.json"] {
        let done =
            willis(here.path(), &["convert", "a.csv", output, "--to", if output == "a.json" { "svzerod" } else { "openbf" }]);
        let said = stderr(&done);
        assert!(done.status.success(), "{said}");
        assert!(said.contains("1 vessel in parts that no blood enters, left out") && said.contains("divided in two"), "{said}");
    }
    let model = fs::read_to_string(here.path().join("a.yaml")).expect("a model");
    let lengths: Vec<f64> = model.lines().filter_map(|line| line.trim().strip_prefix("L: ")?.parse().ok()).collect();
    assert_eq!(lengths.len(), 3);
    assert!((lengths.iter().sum::<f64>() - 0.015).abs() < 1e-9, "{lengths:?}");
}

#[test]
fn metaimage_as_its_writers_vary() {
    let here = folder();
    let classes = tube(|_| 1).classes;
    let head = "ObjectType = Image\nNDims = 3\nDimSize = 16 16 40\nElementSpacing = 0.5 0.5 0.5\n";
    let tags = (0..3000).map(|n| format!("Tag{n:04} = a value of a header that lists a tag for each slice\n"));
    let long = tags.collect::<Vec<_>>().concat();
    let wide: Vec<u8> = classes.iter().flat_map(|class| u32::from(*class).to_le_bytes()).collect();
    let lines = |name: &str, header: &str, voxels: &[u8]| {
        fs::write(here.path().join(name), [header.as_bytes(), voxels].concat()).expect("written");
        let done = willis(here.path(), &["skeleton", name, "-o", "out.csv", "--force"]);
        assert!(done.status.success(), "{name}: {}", stderr(&done));
        fs::read_to_string(here.path().join("out.csv")).expect("a table")
    };
    let plain = lines("a.mha", &format!("{head}ElementType = MET_UCHAR\nElementDataFile = LOCAL\n"), &classes);
    for (name, header, voxels) in [
        ("case.mha", format!("{head}ElementType = MET_UCHAR\nElementDataFile = Local\n"), &classes),
        ("blank.mha", format!("{head}\nElementType = MET_UCHAR\n\nElementDataFile = LOCAL\n"), &classes),
        ("long.mha", format!("{head}{long}ElementType = MET_UCHAR\nElementDataFile = LOCAL\n"), &classes),
        ("wide.mha", format!("{head}ElementType = MET_ULONG\nElementDataFile = LOCAL\n"), &wide),
        ("signed.mha", format!("{head}ElementType = MET_LONG\nElementDataFile = LOCAL\n"), &wide),
    ] {
        assert_eq!(lines(name, &header, voxels), plain, "{name}");
    }
}

#[test]
fn advice_can_be_followed() {
    let points = b"x,y,z,distance_to_wall_mm\n0.1,-1.9,-1.1,0.5\n0.1,-2.4,-0.6,0.6\n";
    refused(&[("p.csv", points)], &["infer", "p.csv", "-o", "out"], &["p.csv:1", "fragment,x,y,z,radius"]);
    let here = folder();
    let far = (0..20)
        .map(|n| format!("{} 0 {}.3 {}.2 {}.1 1.{n} {}\n", n + 1, 10 * n, 11 * n, 11 * n, if n == 0 { -1 } else { n }))
        .collect::<Vec<_>>()
        .concat();
    fs::write(here.path().join("far.swc"), far).expect("written");
    let done = willis(here.path(), &["convert", "far.swc", "far.vtp"]);
    assert!(stderr(&done).contains("more than a head has") && stderr(&done).contains("voxel"), "{}", stderr(&done));
    // A mask states its spacing: nothing asks for units.
    let mut bytes = Vec::new();
    let drawn = tube(|_| 1);
    let coarse = Mask::new(drawn.shape, drawn.classes, AFFINE.map(|row| row.map(|x| 8.0 * x)));
    write_nifti(&mut bytes, &coarse, false).expect("written");
    fs::write(here.path().join("coarse.nii"), bytes).expect("written");
    let done = willis(here.path(), &["skeleton", "coarse.nii", "-o", "coarse.vtp"]);
    let said = stderr(&done);
    assert!(done.status.success() && said.contains("is the size of its voxels in mm?") && !said.contains("--units"), "{said}");
}

/// Masks of the TopCoW challenge are known by their classes, which iCafe has too.
#[test]
fn a_mask_of_topcow_is_known_as_one() {
    let here = folder();
    let said_of = |classes: [u8; 12]| {
        let drawn = tube(|z| classes[(z.max(4) - 4) * 12 / 36]);
        let mut bytes = Vec::new();
        write_nifti(&mut bytes, &drawn, false).expect("written");
        fs::write(here.path().join("a.nii"), bytes).expect("written");
        let done = willis(here.path(), &["classify", "a.nii", "-o", "out", "--force"]);
        (done.status.success(), stderr(&done))
    };
    // All arteries, and those of a patient without the right middle cerebral and both posterior communicating ones.
    for classes in [[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], [1, 1, 2, 3, 4, 6, 7, 7, 10, 10, 11, 12]] {
        let (is_done, said) = said_of(classes);
        assert!(said.contains("classes are those of the TopCoW challenge") && !said.contains("iCafe"), "{said}");
        assert!(is_done, "{said}");
    }
    // Four numbers may be anything.
    let (is_done, said) = said_of([1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4]);
    assert!(!is_done && said.contains("codes that iCafe and TopCoW both have"), "{said}");
}
