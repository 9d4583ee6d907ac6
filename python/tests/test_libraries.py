"""Round trips with the libraries of the field, each read back by that library or compared with its own arithmetic."""

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import willis

BROKEN = "data/broken-circle-of-willis.swc"


@pytest.fixture(scope="module")
def run():
    return willis.infer(BROKEN, progress=False)


def same(a, b):
    return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def test_networkx_there_and_back(run):
    back = willis.from_networkx(run.graph.to_networkx())
    before, after = run.graph.edges, back.edges
    for name in ("label", "origin", "length_mm", "radius_mm", "prior", "probability"):
        assert same(before[name], after[name]), name
    # An edge of an undirected graph may come back with its ends exchanged.
    ends = lambda table: np.sort(np.stack([table["node_a"], table["node_b"]]), axis=0)  # noqa: E731
    assert np.array_equal(ends(before), ends(after))
    for name, values in run.graph.nodes.items():
        assert same(values, back.nodes[name]), name
    again, once = willis.infer(back, progress=False), willis.infer(run.graph, progress=False)
    assert np.allclose(again.edges["likelihood"], once.edges["likelihood"], rtol=1e-12)


def test_a_graph_of_somebody_else():
    nx = pytest.importorskip("networkx")
    graph = nx.Graph()
    for name, x in (("in", 0), ("a<b", 10), ("out", 20)):
        graph.add_node(name, pos=(x, 0, 0))
    graph.add_edge("in", "a<b", radius_mm=np.float32(1), length_mm=10)
    graph.add_edge("a<b", "out", radius_mm=1.0, length_mm=10.0, weight=[1, 2])
    flow = willis.simulate(willis.from_networkx(graph), inlets=["in=100"], outlets=["out"])
    # Poiseuille, by hand: Q = pi r^4 dP / (8 mu l), mL/min.
    by_hand = np.pi * 1e-12 * 100 * 133.322387415 / (8 * 3.5e-3 * 20e-3) * 6e7
    assert flow.edges["flow_mL_per_min"] == pytest.approx([by_hand, by_hand], rel=1e-9)


def test_networkx_has_the_courses(run):
    nx = pytest.importorskip("networkx")
    network = willis.read(BROKEN)
    back = willis.from_networkx(network.to_networkx(), observed=True)
    for mine, its in zip(network.lines()[1], back.lines()[1]):
        assert mine == pytest.approx(its, abs=1e-12) or mine == pytest.approx(its[::-1], abs=1e-12)
    assert len(run.topology.to_igraph().es["points"]) == run.topology.n_edges
    bent = nx.read_graphml("data/circle-of-willis/complete.graphml", force_multigraph=True)
    assert same(willis.from_networkx(bent).edges["length_mm"], willis.read("data/circle-of-willis/complete.graphml").edges["length_mm"])


@pytest.mark.parametrize("kind", ["DiGraph", "MultiDiGraph"])
def test_a_directed_graph_has_each_vessel_once(kind):
    nx = pytest.importorskip("networkx")
    graph = nx.Graph()
    for name, x in (("a", 0), ("b", 10), ("c", 20)):
        graph.add_node(name, pos=(x, 0, 0))
    graph.add_edge("a", "b", radius_mm=1.0)
    graph.add_edge("b", "c", radius_mm=0.8)
    flow = [willis.simulate(willis.from_networkx(graph), inlets=["a"], outlets=["c"]).edges["flow_mL_per_min"]]
    with pytest.warns(willis.Note, match="the graph is directed"):
        twice = willis.from_networkx(getattr(nx, kind)(graph))
    flow.append(willis.simulate(twice, inlets=["a"], outlets=["c"]).edges["flow_mL_per_min"])
    assert same(*flow)


def test_a_position_is_three_numbers():
    nx = pytest.importorskip("networkx")

    def at(pos):
        graph = nx.Graph()
        graph.add_node("a", pos=pos)
        graph.add_node("b", pos=(9, 0, 0))
        graph.add_edge("a", "b", radius_mm=1.0, length_mm=9.0)
        return willis.from_networkx(graph)

    assert at(np.zeros(3, np.float32)).nodes["x_mm"].tolist() == [0, 9]
    for wrong in (5, (0, 0), (0, 0, 0, 7), ("a", 0, 0), {"x": 1}):
        with pytest.raises(willis.WillisError, match="^pos"):
            at(wrong)


def test_igraph_has_every_vessel(run):
    pytest.importorskip("igraph")
    graph = run.graph.to_igraph()
    assert (graph.vcount(), graph.ecount()) == (run.graph.n_nodes, run.graph.n_edges)
    assert graph.es["radius_mm"] == run.graph.edges["radius_mm"].tolist()
    assert [set(edge.tuple) for edge in graph.es] == list(map(set, run.graph.lines()[0].tolist()))


def test_pandas_has_every_column(run):
    pytest.importorskip("pandas")
    frame = run.edges.to_pandas()
    assert list(frame.columns) == list(run.edges)
    assert frame["kept"].sum() == run.kept.sum()


def test_vtk_has_every_line(run):
    pytest.importorskip("vtkmodules")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    lines, radii = run.topology.lines()[1:]
    drawn = run.topology.to_vtk()
    assert drawn.GetNumberOfLines() == len(lines)
    points, radius = vtk_to_numpy(drawn.GetPoints().GetData()), vtk_to_numpy(drawn.GetPointData().GetArray("MaximumInscribedSphereRadius"))
    for cell, (line, thickness) in enumerate(zip(lines, radii)):
        ids = drawn.GetCell(cell).GetPointIds()
        rows = [ids.GetId(at) for at in range(ids.GetNumberOfIds())]
        assert points[rows] == pytest.approx(line, abs=1e-5)
        # A node is one point of several vessels, and has one radius.
        assert radius[rows[1:-1]] == pytest.approx(thickness[1:-1], rel=1e-6)


def test_vtk_comes_in(run):
    pytest.importorskip("vtkmodules")
    network = willis.read(BROKEN)
    back = willis.from_vtk(network.to_vtk())
    for name in ("length_mm", "radius_mm"):
        assert back.edges[name] == pytest.approx(network.edges[name], rel=1e-6)


def test_vtk_has_any_names():
    pytest.importorskip("vtkmodules")
    from vtkmodules.util.numpy_support import numpy_to_vtk

    for name in ("Größe", "半径", 'r "in" <mm> & %'):
        lines = willis.read(BROKEN).to_vtk()
        radii = numpy_to_vtk(np.full(lines.GetNumberOfPoints(), 0.7), deep=1)
        radii.SetName(name)
        lines.GetPointData().AddArray(radii)
        assert willis.from_vtk(lines, radius_array=name).edges["radius_mm"] == pytest.approx(0.7)


def test_skan_measures_the_same_lengths(run):
    skan = pytest.importorskip("skan")
    pytest.importorskip("scipy")
    network = willis.read(BROKEN)
    by_hand = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in network.lines()[1])
    paths = network.to_skan()
    assert skan.summarize(paths, separator="_")["branch_distance"].sum() == pytest.approx(by_hand, rel=1e-9)


def test_skan_skeletons_come_in():
    skan = pytest.importorskip("skan")
    image = np.zeros((5, 30, 5), dtype=np.float32)
    image[2, 2:28, 2] = 1.5
    network = willis.from_skan(skan.Skeleton(image, spacing=(0.4, 0.5, 0.6)))
    assert network.edges["length_mm"] == pytest.approx([25 * 0.5])
    assert network.edges["radius_mm"] == pytest.approx([1.5])
    with pytest.raises(willis.WillisError, match="radii"):
        willis.from_skan(skan.Skeleton(image > 0, spacing=(0.4, 0.5, 0.6)))


def test_navis_measures_the_same_cable(run):
    navis = pytest.importorskip("navis")
    network = willis.read(BROKEN)
    by_hand = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in network.lines()[1])
    neuron = network.to_navis()
    assert isinstance(neuron, navis.TreeNeuron)
    assert neuron.cable_length == pytest.approx(by_hand, rel=1e-5)
    nodes = neuron.nodes.set_index("node_id")
    rows = {node: row for row, node in enumerate(nodes.index)}
    edges = [(rows[node], rows[parent]) for node, parent in nodes["parent_id"].items() if parent in rows]
    back = willis.centerlines(nodes[["x", "y", "z"]].to_numpy(), edges, nodes["radius"].to_numpy())
    assert back.edges["length_mm"].sum() == pytest.approx(by_hand, rel=1e-5)


def test_a_mask_comes_in(tmp_path):
    mask = np.zeros((20, 60, 20), dtype=bool)
    mask[8:12, 4:56, 8:12] = True
    network = willis.from_mask(mask, spacing=(0.5, 1.0, 0.5))
    assert network.n_edges == 1
    # Thinning takes up to a diameter, four voxels, off each end.
    assert 52 - 8 <= network.edges["length_mm"][0] <= 52
    # The radius of the circle with the area of the square, by its definition.
    assert network.edges["radius_mm"] == pytest.approx([np.sqrt(4 / np.pi)], rel=0.03)
    np.save(tmp_path / "mask.npy", mask)
    assert same(willis.read(tmp_path / "mask.npy", spacing=(0.5, 1.0, 0.5)).edges["length_mm"], network.edges["length_mm"])
    turned = willis.from_mask(np.asfortranarray(mask), spacing=(0.5, 1.0, 0.5))
    assert same(turned.edges["length_mm"], network.edges["length_mm"])


def test_back_from_its_folder(run, tmp_path):
    run.save(tmp_path / "run")
    loaded = willis.load(tmp_path / "run")
    for mine, its in ((run.edges, loaded.edges), (run.nodes, loaded.nodes)):
        assert list(mine) == list(its)
        for name, values in mine.items():
            assert values.dtype.kind == its[name].dtype.kind, name
            assert same(values, its[name]), name
    assert abs(run.likelihood - loaded.likelihood).max() == 0
    assert (loaded.expected_wrong, loaded.expected_missed) == (run.expected_wrong, run.expected_missed)
    assert same(loaded.undecided, run.undecided)
    assert loaded.topology.n_edges == run.topology.n_edges < run.kept.sum()
    assert loaded.topology.edges["length_mm"].sum() == pytest.approx(run.edges["length_mm"][run.kept].sum(), rel=1e-12)
    with pytest.raises(willis.WillisError) as wrong:
        willis.load(tmp_path)
    assert wrong.value.file == str(tmp_path)


def test_many_subjects_are_those_of_the_command(tmp_path):
    inputs = [BROKEN, "data/circle-of-willis/complete.graphml"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", willis.Note)
        study = willis.cohort(inputs, tmp_path / "study", samples=128)
        alone = willis.infer(BROKEN, samples=128, landmarks="auto")
    assert len(study) == 2 and set(study.subjects["status"]) == {"ok"}
    assert same(study.run(study.subjects["subject"][0]).edges["likelihood"], alone.edges["likelihood"])
    with pytest.raises(willis.WillisError, match="epsilom"):
        willis.cohort(inputs, epsilom=0.1)


def test_many_labels_are_those_of_each(tmp_path):
    with pytest.warns(willis.Note, match="1 of 2 subjects failed"):
        names = willis.label_cohort([BROKEN, tmp_path / "absent.swc"])
    assert list(names.subjects["status"]) == ["ok", "failed"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", willis.Note)
        alone = willis.label(BROKEN)
    of = names.labelled(names.subjects["subject"][0])
    assert len(of.landmarks["label"]) > 5 and same(of.landmarks["probability"], alone.landmarks["probability"])
    # Options of read and of candidates: the same lengths in another unit, and no condition, as nothing flows.
    micro = tmp_path / "micro.swc"
    lines = [line.split() for line in Path(BROKEN).read_text().splitlines() if line and not line.startswith("#")]
    micro.write_text("".join(" ".join([*one[:2], *(repr(1000 * float(x)) for x in one[2:6]), one[6]]) + "\n" for one in lines))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", willis.Note)
        scaled = willis.label(micro, units="um", k=5, frame="RAS")
    assert same(scaled.landmarks["label"], alone.landmarks["label"])
    with pytest.raises(willis.WillisError, match="inlets: no option of label"):
        willis.label(BROKEN, inlets=["1"])


@pytest.mark.filterwarnings("ignore::willis.Note")
def test_names_of_a_network_are_those_of_its_file(run, tmp_path):
    """What a program holds is named as what the command reads: a file, its points as arrays, a graph of NetworkX, a run."""
    def names(source, **options):
        return willis.label(source, **options).names

    def said(*sources):
        return {(tuple(of["label"]), tuple(of["probability"])) for of in map(names, sources)}

    network = willis.read(BROKEN)
    run.save(tmp_path / "run", dpi=36)
    assert len(said(BROKEN, network)) == 1
    assert len(said(tmp_path / "run", run)) == 1
    with pytest.raises(willis.WillisError, match="units: no option of label; expected those of candidates"):
        willis.label(network, units="um")
    # Candidates are built between what a graph observed.
    observed = willis.from_networkx(network.to_networkx(), observed=True)
    network.save(tmp_path / "observed.graphml")
    by_file = names(tmp_path / "observed.graphml", observed=True)
    assert same(names(observed)["probability"], by_file["probability"])


def test_two_readers_are_compared(run, tmp_path):
    run.save(tmp_path / "run", dpi=36)
    edges, nodes = run.graph.edges, run.graph.nodes
    rows = [row for row in range(len(edges["origin"])) if edges["origin"][row] == "candidate"][:4]
    for reader, words in (("a", "accept accept reject reject"), ("b", "accept reject reject reject")):
        lines = [f"{r},{nodes['id'][edges['node_a'][r]]},{nodes['id'][edges['node_b'][r]]},{w}" for r, w in zip(rows, words.split())]
        (tmp_path / f"{reader}.csv").write_text("\n".join(["edge,id_a,id_b,decision", *lines]) + "\n")
    found = willis.measure(tmp_path / "run", readers=(tmp_path / "a.csv", tmp_path / "b.csv"))
    # p_o = 3/4, p_e = 1/8 + 3/8.
    assert found.readers["kappa"][-1] == pytest.approx(0.5)
    assert list(found.differences["edge"]) == [rows[1]] and list(found.differences["decision_b"]) == ["reject"]


def test_the_page_is_shown_in_a_notebook(run):
    page = run._repr_html_()
    assert page.startswith("<iframe") and "&lt;html" in page


def test_the_affine_of_nibabel_states_the_sides(tmp_path):
    def frame(network):
        network.save(tmp_path / "a.graphml", force=True)
        written = (tmp_path / "a.graphml").read_text()
        return next((word for word in ("RAS", "LPS") if f">{word}<" in written), None)

    mask = np.zeros((40, 12, 14), np.uint8)
    mask[4:36, 4:7, 5:8] = 1
    affine = np.array([[-0.5, 0, 0, 20], [0, 1, 0, -6], [0, 0, 0.5, 3], [0, 0, 0, 1]])
    network = willis.from_mask(mask, affine=affine)
    assert frame(network) == "RAS"
    corners = np.array([[4, 4, 5, 1], [35, 6, 7, 1]]) @ affine.T
    for axis, column in enumerate(("x_mm", "y_mm", "z_mm")):
        values = np.asarray(network.nodes[column])
        assert values.min() >= corners[:, axis].min() - 0.5 and values.max() <= corners[:, axis].max() + 0.5
    assert frame(willis.from_mask(mask, spacing=0.5)) is None
    assert frame(willis.from_mask(mask, spacing=0.5, frame="LPS")) == "LPS"
    lines = willis.centerlines([[0, 0, 0], [9, 0, 0]], [[0, 1]], [1, 1], frame="LPS")
    assert frame(lines) == "LPS"
    graph = pytest.importorskip("networkx").Graph()
    graph.add_edge(0, 1, radius_mm=1.0, length_mm=9.0)
    assert frame(willis.from_networkx(graph, frame="RAS")) == "RAS"
    batch, alone = (willis.from_mask(one, spacing=0.5) for one in (mask[None], mask))
    assert same(batch.nodes["x_mm"], alone.nodes["x_mm"])
    for wrong in ({}, {"spacing": 1, "affine": affine}):
        with pytest.raises(willis.WillisError, match="expected spacing, or affine"):
            willis.from_mask(mask, **wrong)
    with pytest.raises(willis.WillisError, match="affine"):
        willis.from_mask(mask, affine=np.eye(3))


def test_a_library_that_is_not_there_is_named_with_its_extra(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.sparse", None)
    with pytest.raises(ImportError, match=r"scipy is not installed; pip install 'willis\[graph\]'"):
        run.likelihood  # noqa: B018
