//! The output folder as the programs read it that it is for: NumPy, SciPy, NetworkX, VTK. Needs `WILLIS_PYTHON`.

use std::path::Path;
use std::process::Command;

const SCRIPT: &str = r#"
import csv, sys
import networkx as nx, numpy as np, scipy.sparse as sp
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

out = sys.argv[1]
edges = list(csv.DictReader(open(f"{out}/edges.csv")))
nodes = list(csv.DictReader(open(f"{out}/nodes.csv")))
n = len(nodes)

# The matrix is the column, summed over parallel vessels.
L = np.zeros((n, n))
for e in edges:
    a, b = int(e["node_a"]), int(e["node_b"])
    if a != b:
        L[a, b] += float(e["likelihood"])
        L[b, a] += float(e["likelihood"])
dense, sparse = np.load(f"{out}/likelihood.npy"), sp.load_npz(f"{out}/likelihood.npz")
assert dense.dtype == np.float64 and dense.flags["C_CONTIGUOUS"] and dense.shape == (n, n)
assert (dense == dense.T).all() and (dense == L).all() and (sparse.toarray() == L).all() and L.max() > 0

# The median is that of the candidates with L > 0.
uncertain = np.array([float(e["likelihood"]) for e in edges if e["origin"] == "candidate"])
median = np.median(uncertain[uncertain > 0])
for e in edges:
    above = e["origin"] == "observed" or float(e["likelihood"]) > median
    assert above == (e["above_median"] == "1"), e
    assert e["kept"] == "1" or e["origin"] == "candidate", e
    assert (e["probability"] == "") == (e["origin"] == "observed") and 0 <= float(e["probability"] or 0) <= 1, e

# The topologies hold the kept vessels, those that go on without a junction as one.
for name, column in (("topology", "kept"), ("topology-median", "above_median")):
    rows = {e["edge"]: e for e in edges if e[column] == "1"}
    graph = nx.read_graphml(f"{out}/{name}.graphml", force_multigraph=True)
    vessels = [d for *_, d in graph.edges(data=True)]
    parts = [d["edges"].split("+") for d in vessels]
    assert sorted(row for of in parts for row in of) == sorted(rows)
    merged = sum(len(of) - 1 for of in parts)
    assert graph.number_of_nodes() == n - merged and any(len(of) > 1 for of in parts)
    for d, of in zip(vessels, parts):
        assert d["edge"] == min(map(int, of))
        assert np.isclose(d["length_mm"], sum(float(rows[row]["length_mm"]) for row in of), rtol=1e-12)
        # Poiseuille's resistance is that of the parts in a row.
        narrow = sum(float(rows[row]["length_mm"]) / float(rows[row]["radius_mm"]) ** 4 for row in of)
        assert np.isclose(d["length_mm"] / d["radius_mm"] ** 4, narrow, rtol=1e-12)
        if any(rows[row]["origin"] != "observed" for row in of):
            assert len(of) == 1
    degree = graph.degree()
    apart = {id for id, d in graph.nodes(data=True) if degree[id] == 2 and d["role"] == "inner"}
    for id in apart:
        (a, b) = [d["origin"] for *_, d in graph.edges(id, data=True)]
        assert (a, b) != ("observed", "observed") or len(set(graph.neighbors(id))) == 1, id
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(f"{out}/{name}.vtp")
    reader.Update()
    poly = reader.GetOutput()
    assert poly.GetNumberOfLines() == len(vessels)
    assert poly.GetPointData().HasArray("MaximumInscribedSphereRadius")
    array = poly.GetCellData().GetArray("likelihood")
    names = poly.GetCellData().GetAbstractArray("edges")
    whole = [i for i in range(len(vessels)) if "+" not in names.GetValue(i)]
    assert all(array.GetValue(i) == float(rows[names.GetValue(i)]["likelihood"]) for i in whole)
parts = {r["component"] for r in nodes}
assert len(parts) == nx.number_connected_components(nx.Graph(nx.read_graphml(f"{out}/topology.graphml", force_multigraph=True)))
"#;

#[test]
fn every_file_of_the_folder_says_the_same() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return;
    };
    let here = tempfile::tempdir().expect("a temporary folder");
    let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/broken-circle-of-willis.swc");
    let run = |command: &mut Command| {
        let output = command.current_dir(here.path()).output().expect("runs");
        assert!(
            output.status.success(),
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
    };
    run(Command::new(env!("CARGO_BIN_EXE_willis")).arg("infer").arg(input).args(["-o", "out", "-q"]));
    run(Command::new(python).args(["-c", SCRIPT, "out"]));
}
