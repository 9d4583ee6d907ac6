"""The module against the command and against other readers. Run from the root of the project, with `willis` installed."""

import copy
import csv
import filecmp
import json
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import willis
from willis._review import Review

BROKEN = "data/broken-circle-of-willis.swc"


def command(*words):
    subprocess.run([sys.executable, "-c", "import sys; from willis._command import main; sys.exit(main())", *words], check=True)


def same_folders(a, b):
    """Every file alike; of run.json all but the time."""
    names = sorted(path.name for path in a.iterdir())
    assert names == sorted(path.name for path in b.iterdir())
    plain = [name for name in names if name != "run.json"]
    assert filecmp.cmpfiles(a, b, plain, shallow=False) == (plain, [], [])
    records = [json.loads((folder / "run.json").read_text()) for folder in (a, b)]
    for record in records:
        del record["time"]
    assert records[0] == records[1]


@pytest.mark.parametrize(
    ("options", "given"),
    [
        ({}, []),
        ({"epsilon": 0.25, "samples": 128, "seed": 7}, ["--epsilon", "0.25", "--samples", "128", "--seed", "7"]),
        ({"keep": "median"}, ["--keep", "median"]),
        ({"preset": "paper", "max_gap": 3}, ["--preset", "paper", "--max-gap", "3"]),
        ({"outlets": "ground"}, ["--outlets", "ground"]),
    ],
)
def test_a_run_is_that_of_the_command(tmp_path, options, given):
    willis.infer(BROKEN, **options).save(tmp_path / "module")
    command("infer", BROKEN, "-o", str(tmp_path / "command"), "--quiet", *given)
    same_folders(tmp_path / "module", tmp_path / "command")


@pytest.mark.parametrize("name", ["a.swc", "a.vtp", "a.vtk", "a.npz", "a.mrk.json", "a.tre", "a.csv", "scan.nii.gz", "complete.graphml", "without-L-P1.graphml"])
def test_every_input_is_that_of_the_command(tmp_path, name):
    data = Path("data")
    source = next((path for path in (data / name, data / "circle-of-willis" / name) if path.exists()), tmp_path / name)
    if not source.exists():
        command("convert", BROKEN, str(source), "--quiet")
    options = {"samples": 128, "uncertain": "all" if name.endswith("graphml") else None}
    willis.infer(source, **options).save(tmp_path / "module")
    given = ["--samples", "128", *(["--uncertain", "all"] if options["uncertain"] else [])]
    command("infer", str(source), "-o", str(tmp_path / "command"), "--quiet", *given)
    same_folders(tmp_path / "module", tmp_path / "command")


def test_arrays_are_the_npz_of_them(tmp_path):
    arrays = willis.read(BROKEN).to_arrays()
    labels = arrays.get("labels")
    scan = willis.centerlines(arrays["coords"], arrays["edges"], arrays["radii"], labels=labels)
    np.savez(tmp_path / "arrays.npz", **{name: arrays[name] for name in ("coords", "edges", "radii", "labels") if name in arrays})
    a, b = willis.infer(scan, samples=64), willis.infer(tmp_path / "arrays.npz", samples=64)
    for name, values in a.edges.items():
        np.testing.assert_array_equal(values, b.edges[name])


def test_likelihood_is_that_of_the_file(tmp_path):
    scipy = pytest.importorskip("scipy.sparse")
    run = willis.infer(BROKEN)
    run.save(tmp_path / "out")
    saved = scipy.load_npz(tmp_path / "out" / "likelihood.npz")
    assert abs(run.likelihood - saved).max() == 0
    assert (run.likelihood != run.likelihood.T).nnz == 0


def test_a_refused_edit_leaves_the_review_as_it_was():
    run = willis.infer(BROKEN, samples=64)
    review = Review(run)
    row = int(np.flatnonzero((run.edges["origin"] == "candidate") & ~run.kept)[0])
    review.decide(row, "accept")
    assert review.run.kept[row]
    with pytest.raises(willis.WillisError):
        review.edit("join", [[(0, 0, 0), (1000, 1000, 1000)]])
    assert review.run.kept[row] and [made.word for made in review.made] == ["accept"]


def test_an_argument_that_is_missing_has_its_name():
    with pytest.raises(willis.WillisError, match="INPUT: is needed") as raised:
        willis.measure([])
    assert raised.value.item == "INPUT"
    with pytest.raises(willis.WillisError, match="compare=?: is needed"):
        willis.measure(BROKEN, measures=["length_mm"])


def test_a_cohort_has_rows_of_what_failed_and_may_have_one(tmp_path):
    (tmp_path / "bad.swc").write_text("1 0 a b c d -1\n")
    with pytest.warns(willis.Note, match="1 of 2 subjects failed"):
        two = willis.cohort([tmp_path / "bad.swc", BROKEN], samples=64)
    assert two.subjects["status"].tolist() == ["failed", "ok"]
    run = two.run("broken-circle-of-willis")
    assert np.isnan(two.subjects["kept"][0])
    assert two.subjects["kept"][1] == (run.kept & (run.edges["origin"] != "observed")).sum()
    one = willis.cohort([BROKEN], samples=64)
    assert one.subjects["input"].tolist() == [BROKEN] and len(one) == 1


def test_numbers_of_numpy_are_numbers(tmp_path):
    circle = "data/circle-of-willis/complete.graphml"
    longer = [willis.simulate(circle, tortuosity={"edge:0": factor}) for factor in (1.3, np.float64(1.3))]
    assert str(longer[0]) == str(longer[1])
    run = willis.modulate(circle, classes=np.array([[0, 0.2], [0.2, 0.3]]), samples=8, progress=False)
    assert run.record["parameters"]["classes"] == ["0:0.2", "0.2:0.3"]
    # What cannot be written leaves nothing behind.
    with pytest.raises(willis.WillisError, match="dpi"):
        run.save(tmp_path / "out", dpi=5)
    assert not (tmp_path / "out").exists()
    run.save(tmp_path / "out", dpi=36)
    with pytest.raises(willis.WillisError, match="exists"):
        run.save(tmp_path / "out")


def test_a_run_from_its_folder_has_the_graph_that_was_sampled(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    run.save(tmp_path / "out")
    saved = willis.load(tmp_path / "out")
    assert saved.graph.n_edges == len(saved.kept) == run.graph.n_edges
    np.testing.assert_allclose(saved.graph.edges["radius_mm"], saved.edges["radius_mm"], rtol=1e-12)
    assert saved.topology.n_edges == run.topology.n_edges < saved.graph.n_edges


def test_rekeep_and_pickle():
    run = willis.infer(BROKEN, samples=256)
    median = run.rekeep("median")
    assert (median.kept != run.kept).any()
    np.testing.assert_array_equal(median.kept, willis.infer(BROKEN, samples=256, keep="median").kept)
    again = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(again.edges["likelihood"], run.edges["likelihood"])
    assert str(again) == str(run)


def test_decisions(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    rows = run.undecided
    accepted, rejected = int(rows[0]), int(rows[-1])
    again = run.decide(accept=[accepted], reject=[rejected], who="A. Reader")
    assert again.kept[accepted] and not again.kept[rejected]
    assert again.edges["probability"][accepted] == 1 and again.edges["probability"][rejected] == 0
    # The list of a page does the same.
    ids = [list(run.nodes["id"][run.edges[end][[accepted, rejected]]]) for end in ("node_a", "node_b")]
    lines = [f"{row},{a},{b},{word}" for row, a, b, word in zip((accepted, rejected), *ids, ("accept", "reject"))]
    (tmp_path / "decisions.csv").write_text("edge,id_a,id_b,decision\n" + "\n".join(lines) + "\n")
    read = willis.infer(BROKEN, samples=64, decisions=tmp_path / "decisions.csv")
    np.testing.assert_array_equal(read.edges["likelihood"], again.edges["likelihood"])
    np.testing.assert_array_equal(read.kept, again.kept)
    with pytest.raises(willis.WillisError, match="decided on before"):
        again.decide(accept=[rejected])
    with pytest.raises(willis.WillisError, match="each row once"):
        run.decide(accept=[1], reject=[1])


def test_the_review_is_that_of_the_folder_and_stands_in_the_gaps(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    run.save(tmp_path / "out")
    saved = willis.load(tmp_path / "out").review
    assert list(saved) == list(run.review) and set(run.undecided) <= set(saved["edge"])
    for name, values in run.review.items():
        np.testing.assert_array_equal(values, saved[name])
        assert values.dtype.kind == saved[name].dtype.kind, name
    lines = run.graph.lines()[1]
    straight = [at for at, row in enumerate(saved["edge"]) if len(lines[row]) == 2 and saved["kind"][at] != "part"]
    assert straight
    for at in straight:
        place = [saved[axis][at] for axis in ("x_mm", "y_mm", "z_mm")]
        np.testing.assert_allclose(place, lines[saved["edge"][at]].mean(axis=0), atol=1e-9)


def test_edits(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    nodes, edges = run.nodes, run.edges
    at = np.column_stack([nodes[axis] for axis in ("x_mm", "y_mm", "z_mm")])
    gap = next(row for row, kept in enumerate(run.kept) if not kept)
    ends = [at[int(edges[end][gap])] for end in ("node_a", "node_b")]
    again = run.decide(join=[ends], who="A. Reader")
    assert len(again.kept) == len(run.kept) + 1 and again.kept[-1] and again.edges["probability"][-1] == 1
    # A list of the same does the same.
    places = " + ".join(" ".join(map(repr, map(float, place))) for place in ends)
    (tmp_path / "decisions.csv").write_text(f"edge,id_a,id_b,decision,places\n,,,join,{places}\n")
    read = willis.infer(BROKEN, samples=64, decisions=tmp_path / "decisions.csv")
    np.testing.assert_array_equal(read.edges["likelihood"], again.edges["likelihood"])
    with pytest.raises(willis.WillisError, match="from the nearest vessel"):
        run.decide(delete=[(900, 900, 900)])
    with pytest.raises(willis.WillisError, match="two or more groups"):
        run.decide(part=[[ends]])


@pytest.mark.parametrize("more", [{}, {"landmarks": "auto"}, {"preset": "paper"}, {"uncertain": "all"}])
def test_decisions_in_a_program_are_those_of_a_list(tmp_path, more):
    """All at once, one after the other, and after pickling: the graph, its arteries, its inlets and the answer."""
    options = {"samples": 64, **more}
    run = willis.infer(BROKEN, **options)
    lines, edges = run.graph.lines()[1], run.edges
    inlet = int(np.flatnonzero(run.nodes["role"] == "inlet")[0])
    at_inlet = next(row for row, a, b, of in zip(range(len(lines)), edges["node_a"], edges["node_b"], edges["origin"]) if of == "observed" and inlet in (a, b))
    long = [row for row in np.flatnonzero(edges["origin"] == "observed") if len(lines[row]) > 8 and row != at_inlet][0]
    accepted, rejected = (int(row) for row in np.flatnonzero(edges["origin"] == "candidate")[[0, -1]])
    middle = len(lines[at_inlet]) // 2
    review = Review(run, who="A. Reader")
    review.decide(accepted, "accept")
    review.edit("delete", [[lines[at_inlet][middle]]])
    review.edit("part", [[lines[long][2]], [lines[long][-3]]])
    review.decide(rejected, "reject")
    review.save(tmp_path, "list")
    first = run.decide(accept=[accepted], delete=[lines[at_inlet][middle]], who="A. Reader")
    then = pickle.loads(pickle.dumps(first)).decide(reject=[rejected], part=[[[lines[long][2]], [lines[long][-3]]]], who="A. Reader")
    given = [text for name, value in options.items() for text in (f"--{name}", str(value))]
    command("infer", BROKEN, "-o", str(tmp_path / "command"), "--quiet", "--decisions", str(tmp_path / "list-decisions.csv"), *given)
    for name, made in (("at-once", review.run), ("in-turn", then)):
        if "landmarks" not in more:
            assert made.nodes["role"][inlet] != "inlet", "it is found anew: nothing enters by a vessel that was deleted"
        made.save(tmp_path / name)
        names = sorted(path.name for path in (tmp_path / "command").iterdir())
        assert names == sorted(path.name for path in (tmp_path / name).iterdir())
        # The pages and the record say by which list and when.
        plain = [file for file in names if file not in ("run.json", "report.html")]
        assert filecmp.cmpfiles(tmp_path / "command", tmp_path / name, plain, shallow=False) == (plain, [], [])


def test_errors_say_what_where_and_what_else(tmp_path):
    path = tmp_path / "bad.swc"
    path.write_text("1 0 0 0 0 1 -1\n2 0 1 0 x 1 1\n")
    with pytest.raises(willis.WillisError) as caught:
        willis.read(path)
    assert caught.value.file == str(path) and caught.value.line == 2 and caught.value.expected
    assert isinstance(caught.value, ValueError)
    assert pickle.loads(pickle.dumps(caught.value)).line == 2
    with pytest.raises(willis.WillisError, match="epsilon 2: expected"):
        willis.infer(BROKEN, epsilon=2)
    with pytest.raises(willis.WillisError, match="max_gap") as caught:
        willis.infer(BROKEN, max_gap=-3)
    assert caught.value.item == "max_gap" and "positive" in caught.value.expected
    with pytest.raises(willis.WillisError, match="^edges") as caught:
        willis.centerlines([[0, 0, 0], [1, 0, 0]], [[0, 5]], [1, 1])
    assert caught.value.item.startswith("edges")
    with pytest.raises(willis.WillisError, match="^points"):
        willis.centerlines(np.zeros((5, 2)), [[0, 1]], np.ones(5))
    with pytest.raises(willis.WillisError):
        willis.centerlines([[0, 0, 0], [np.nan, 0, 0]], [[0, 1]], [1, 1])
    with pytest.raises(willis.WillisError):
        willis.infer(tmp_path / "not-there.swc")


def test_simulate_narrows_what_is_named():
    circle = willis.phantom("circle-of-willis")
    label = next(label for label in circle.edges["label"] if label)
    rest = willis.simulate(circle)
    narrowed = willis.simulate(circle, stenosis={label: 0.7})
    row = list(circle.edges["label"]).index(label)
    before, after = (abs(run[row]) for run in (rest.edges["flow_mL_per_min"], narrowed.edges["flow_mL_per_min_perturbed"]))
    assert after < before


def test_networkx_has_every_vessel():
    pytest.importorskip("networkx")
    run = willis.infer(BROKEN, samples=64)
    graph = run.topology.to_networkx()
    assert graph.number_of_edges() == run.topology.n_edges < int(run.kept.sum())
    lengths = sum(length for *_, length in graph.edges(data="length_mm"))
    assert lengths == pytest.approx(run.edges["length_mm"][run.kept].sum(), rel=1e-9)


def test_progress_is_told_and_may_stop():
    heard = []
    willis.infer(BROKEN, samples=2_000_000, progress=lambda done, total: heard.append((done, total)))
    assert all(done <= total == 2_000_000 for done, total in heard)

    def stop(done, total):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        willis.infer(BROKEN, samples=10**9, progress=stop)


def test_ctrl_c_stops_a_long_run():
    # A program in the background starts with the signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    sent = []

    def press():
        time.sleep(0.5)
        sent.append(time.monotonic())
        signal.raise_signal(signal.SIGINT)

    threading.Thread(target=press).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            willis.infer(BROKEN, samples=10**9)
    finally:
        signal.signal(signal.SIGINT, before)
    assert sent


def test_two_threads_give_the_serial_answer():
    alone = willis.infer(BROKEN, samples=20_000).edges["likelihood"]
    found = {}

    def work(number):
        found[number] = willis.infer(BROKEN, samples=20_000, threads=1 + number, progress=False).edges["likelihood"]

    threads = [threading.Thread(target=work, args=(number,)) for number in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for likelihood in found.values():
        np.testing.assert_array_equal(likelihood, alone)


def test_notes_are_warnings(tmp_path):
    path = tmp_path / "mask.npy"
    mask = np.zeros((40, 12, 12), dtype=np.uint8)
    mask[2:38, 4:8, 4:8] = 1
    np.save(path, mask)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        willis.read(path, spacing=0.5)
    assert any(issubclass(one.category, willis.Note) for one in said)


def test_modulation_and_phenotype_are_those_of_the_command(tmp_path):
    path = str(tmp_path / "circle.graphml")
    willis.phantom("circle-of-willis").save(path)
    stated = {"inlets": ["1=90mmHg"], "outlets": {"9": "ground"}}
    willis.modulate(path, samples=20, seed=3, **stated).save(tmp_path / "module")
    conditions = ["--inlet", "1=90mmHg", "--outlet", "9=ground"]
    command("modulate", path, "-o", str(tmp_path / "command"), "--samples", "20", "--seed", "3", *conditions, "--quiet")
    names = [p.name for p in (tmp_path / "command").iterdir() if p.suffix == ".csv"]
    assert names and filecmp.cmpfiles(tmp_path / "module", tmp_path / "command", names, shallow=False)[0] == names
    command("classify", path, "-o", str(tmp_path / "classified"), "--quiet")
    classified = json.loads((tmp_path / "classified" / "phenotype.json").read_text())
    found = willis.classify(path)
    assert found.record == classified and found.probabilities is None


def test_training_names_what_is_wrong(tmp_path):
    with pytest.raises(willis.WillisError) as caught:
        willis.train([tmp_path / "nowhere"], tmp_path / "weights.toml")
    assert str(tmp_path / "nowhere") in str(caught.value) and not (tmp_path / "weights.toml").exists()


def test_a_run_in_the_background():
    alone = willis.infer(BROKEN, progress=False)
    handle = willis.infer(BROKEN, background=True)
    assert np.array_equal(handle.wait(60).edges["likelihood"], alone.edges["likelihood"])
    assert handle.done and handle.result_so_far() is handle.wait()

    handle = willis.infer(BROKEN, samples=10**9, background=True)
    with pytest.raises(TimeoutError):
        handle.wait(0.3)
    look = handle.result_so_far()
    assert look is not None
    # Millions of samples say the same as a thousand, within four standard errors of a share of those.
    many, few = look.edges["frequency"], alone.edges["frequency"]
    assert np.mean(np.abs(many - few) <= 4 * np.sqrt(many * (1 - many) / 1000)) > 0.95
    handle.cancel()
    assert handle.done
    done, total = handle.samples
    assert 0 < done < total
    with pytest.raises(willis.WillisError, match="stopped"):
        handle.wait()
    assert handle.result_so_far() is not None


@pytest.mark.parametrize("make", [
    lambda: willis.read(BROKEN),
    lambda: willis.phantom("arterial", edges=100, seed=3),
    lambda: willis.infer(BROKEN, progress=False).topology,
    lambda: willis.candidates(BROKEN),
    lambda: willis.centerlines([[0, 0, 0], [5, 0, 0]], [[0, 1]], [1, 1]),
])
def test_networks_pickle_and_copy(make):
    network = make()
    for again in (pickle.loads(pickle.dumps(network)), copy.deepcopy(network)):
        for mine, its in ((network.edges, again.edges), (network.nodes, again.nodes)):
            assert list(mine) == list(its)
            assert all(np.array_equal(mine[name], its[name], equal_nan=mine[name].dtype.kind == "f") for name in mine)


def test_candidates_are_those_of_the_command(tmp_path):
    command("candidates", BROKEN, "-o", tmp_path / "theirs.graphml")
    willis.candidates(BROKEN).save(tmp_path / "mine.graphml")
    theirs, mine = (willis.read(tmp_path / name) for name in ("theirs.graphml", "mine.graphml"))
    assert theirs.n_edges == mine.n_edges
    for name, values in theirs.edges.items():
        assert np.array_equal(values, mine.edges[name], equal_nan=values.dtype.kind == "f"), name


def test_transport_is_that_of_the_command(tmp_path):
    circle = "data/circle-of-willis/complete.graphml"
    found = willis.simulate(circle, occlude=["L-ICA I"], transport=True)
    command("simulate", circle, "-o", str(tmp_path / "out"), "--occlude", "L-ICA I", "--transport", "--quiet")
    assert found.occlusions is None
    lost = willis.simulate(circle, occlude_each=True).occlusions
    assert lost["lost_share"].shape == found.edges["edge"].shape and lost["lost_share"].max() <= 1
    for name, table in (("territories", found.territories), ("transit", found.transit)):
        with open(tmp_path / "out" / f"{name}.csv", newline="") as file:
            header, *rows = csv.reader(file)
        assert header == list(table)
        assert len(rows) == len(next(iter(table.values())))
    at = found.territories
    shares = at["supply"][(at["kind"] == "outlet") & (at["label"] == "L-P2")]
    assert shares.sum() == pytest.approx(1)
    assert willis.simulate(circle).territories is None


def test_pulse_is_that_of_the_command(tmp_path):
    circle = "data/circle-of-willis/complete.graphml"
    wave = tmp_path / "wave.csv"
    wave.write_text("time_s,pressure_mmHg\n0,80\n0.2,125\n0.45,100\n0.9,80\n")
    found = willis.simulate(circle, pulse=wave, harmonics=12, wall="pwv=9m/s", times=50)
    words = ["--pulse", str(wave), "--harmonics", "12", "--wall", "pwv=9m/s", "--times", "50", "--quiet"]
    command("simulate", circle, "-o", str(tmp_path / "out"), *words)
    theirs = np.load(tmp_path / "out" / "waveforms.npz")
    assert set(theirs) == set(found.waveforms)
    for name, values in found.waveforms.items():
        assert np.array_equal(values, theirs[name]), name
    flow = found.waveforms["flow_mL_per_min"]
    assert flow.shape == (len(found.edges["edge"]), 50)
    assert np.allclose(flow.mean(axis=1), found.edges["flow_mean_mL_per_min"])
    assert willis.simulate(circle).waveforms is None
    assert "pulsatility_index" in willis.simulate(circle, pulse=True).edges


def test_measures_are_those_of_the_command(tmp_path):
    circle = "data/circle-of-willis/complete.graphml"
    of_file = willis.measure(circle)
    of_network = willis.measure(willis.read(circle))
    assert np.array_equal(of_file.vessels["length_mm"], of_network.vessels["length_mm"])
    assert of_file.vessels["length_mm"].sum() == pytest.approx(willis.read(circle).edges["length_mm"].sum())
    assert len(of_file.intervals["figure"]) == 0
    # A tree that narrows from its root says where blood comes from, by the file; another end would be found to be an inlet as well.
    tree = tmp_path / "tree.swc"
    tree.write_text("1 0 0 0 0 2 -1\n2 0 10 0 0 2 1\n3 0 20 5 0 1.2 2\n4 0 20 -5 0 1 2\n5 0 40 8 0 0.8 3\n6 0 40 2 0 .7 3\n7 0 10 0 60 1 4\n")
    for reading in ({}, {"units": "cm"}):
        of_tree = willis.measure(willis.read(tree, **reading))
        assert of_tree.ends["role"].tolist() == ["inlet"] + 3 * ["outlet"] and of_tree.subjects["subject"].tolist() == ["tree"]
        assert of_tree.vessels["generation"].tolist() == [0, 1, 1, 2, 2]
    assert of_tree.subjects["length_mm"] == pytest.approx(10 * willis.measure(str(tree)).subjects["length_mm"])
    # What was read stays what it is where the file becomes another.
    network = willis.read(tree)
    tree.write_text("1 0 0 0 0 2 -1\n2 0 10 0 0 2 1\n")
    assert willis.measure(network).vessels["length_mm"].sum() == pytest.approx(network.edges["length_mm"].sum())
    run = willis.infer(BROKEN, samples=10, progress=False)
    measured = willis.measure(run)
    assert measured.subjects["length_mm"][0] == pytest.approx(run.topology.edges["length_mm"].sum())
    assert measured.intervals["low"].shape == (17,)
    assert willis.measure(circle, hypoplastic=1.47).subjects["circle_L-PComm_hypoplastic"][0] == 1
    assert willis.measure([circle, BROKEN]).subjects["status"].tolist() == ["ok", "ok"]


def test_texts_that_no_row_has_are_texts(tmp_path):
    circle = "data/circle-of-willis/complete.graphml"
    assert set(willis.measure(BROKEN).vessels["territory"]) == {""}
    assert set(willis.cohort([circle], tmp_path / "sure", samples=10).subjects["needs_person"]) == {""}
    # Groups that are called by numbers.
    inputs = [tmp_path / f"{name}.swc" for name in "abcd"]
    for row, path in enumerate(inputs):
        path.write_text(f"1 0 0 0 0 2 -1\n2 0 {10 + row} 0 0 2 1\n")
    (tmp_path / "people.csv").write_text("subject,group\na,1\nb,1\nc,2\nd,2\n")
    compared = willis.measure(inputs, participants=tmp_path / "people.csv", compare="group", measures=["length_mm"]).comparison
    assert compared["group_a"].tolist() == ["1"] and compared["group_b"].tolist() == ["2"]


def test_texts_name_arguments_as_python_has_them(tmp_path):
    """The command has options in their place: tests/command_line/refusals.rs has the same cases."""
    (tmp_path / "a.csv").write_text("fragment,x,y,z\n1,0,0,0\n1,1,0,0\n")
    with pytest.raises(willis.WillisError, match="or give default_radius=$") as caught:
        willis.read(tmp_path / "a.csv")
    assert caught.value.expected.endswith("default_radius=")
    lines = [f"{i} 3 0.1 0.2 {12.01 * i} 2 {i - 1 if i > 1 else -1}" for i in range(1, 31)]
    (tmp_path / "far.swc").write_text("\n".join(lines))
    with pytest.warns(willis.Note, match="if lengths are in voxels, give units=voxel spacing=S"):
        far = willis.read(tmp_path / "far.swc")
    with pytest.raises(willis.WillisError, match="give one at a time: inlets=1 inlets=2"):
        willis.simulate(far, inlets=["1,2"])


def test_vessels_that_no_inlet_feeds_stay_or_go(tmp_path):
    lines = [[0, 0, 0], [10, 0, 0], [0, 50, 0], [10, 50, 0]]
    both = willis.centerlines(lines, [[0, 1], [2, 3]], [1, 1, 1, 1])
    kept = willis.simulate(both, inlets=["0"], outlets=["1"])
    dropped = willis.simulate(both, inlets=["0"], outlets=["1"], unfed="drop")
    assert kept.edges["diffused"].tolist() == [1, 0]
    assert dropped.edges["flow_mL_per_min"].tolist() == kept.edges["flow_mL_per_min"][:1].tolist()
    with pytest.raises(willis.WillisError, match="needs a node that states where blood enters"):
        both.save(tmp_path / "a.graphml", unfed="drop")
    with pytest.raises(willis.WillisError, match="expected drop or keep"):
        both.save(tmp_path / "a.graphml", unfed="neither")


def test_a_network_stays_that_of_its_file_in_another_folder(tmp_path, monkeypatch):
    for name, y in (("a", 10), ("b", 99)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "x.swc").write_text(f"1 0 0 0 0 1 -1\n2 0 {y} 0 0 1 1\n")
    monkeypatch.chdir(tmp_path / "a")
    network = willis.read("x.swc")
    packed = pickle.dumps(network)
    monkeypatch.chdir(tmp_path / "b")
    for again in (copy.copy(network), copy.deepcopy(network), pickle.loads(packed)):
        assert again.edges["length_mm"] == pytest.approx([10])


def test_what_commands_say_is_a_note(tmp_path):
    far = tmp_path / "far.swc"
    far.write_text("\n".join(f"{i} 3 0.1 0.2 {12.01 * i} 2 {i - 1 if i > 1 else -1}" for i in range(1, 31)))
    for function in (willis.measure, willis.label):
        with pytest.warns(willis.Note, match="more than a head has"):
            function(far)


def test_a_run_that_no_command_makes_names_none(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    row = int(np.flatnonzero(run.edges["origin"] == "candidate")[0])
    for name, one, has in (("run", run, True), ("other", run.rekeep("probability=0.7"), False), ("decided", run.decide(accept=[row]), False)):
        one.save(tmp_path / name, dpi=36)
        assert bool(json.loads((tmp_path / name / "run.json").read_text())["command"]) == has


def test_a_folder_is_replaced_where_that_is_asked_for(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    run.save(tmp_path / "out", dpi=36)
    with pytest.raises(willis.WillisError, match="choose another place or give force="):
        run.save(tmp_path / "out")
    run.save(tmp_path / "out", force=True, dpi=36)
    for dpi in (-5, 2.5, 2**40):
        with pytest.raises(willis.WillisError) as caught:
            run.save(tmp_path / "again", dpi=dpi)
        assert caught.value.item == "dpi"


def test_texts_come_back_from_a_folder_as_they_were(tmp_path):
    nx = pytest.importorskip("networkx")
    graph = nx.Graph()
    for name, x in (("-5", 0), ("=b", 10), ("c", 20)):
        graph.add_node(name, pos=(x, 0, 0))
    graph.add_edge("-5", "=b", radius_mm=1.0, label="=1+1")
    graph.add_edge("=b", "c", radius_mm=0.8, label="'q", origin="candidate")
    run = willis.infer(willis.from_networkx(graph), samples=50, inlets=["-5"], outlets=["c"])
    run.save(tmp_path / "out", dpi=36)
    saved = willis.load(tmp_path / "out")
    assert saved.edges["label"].tolist() == run.edges["label"].tolist() == ["=1+1", "'q"]
    assert saved.nodes["id"].tolist() == run.nodes["id"].tolist()


def test_folders_of_other_commands_are_refused(tmp_path):
    circle = "data/circle-of-willis/complete.graphml"
    willis.simulate(circle).save(tmp_path / "simulated", dpi=36)
    command("measure", circle, "-o", str(tmp_path / "measured"), "--quiet")
    for name in ("simulated", "measured"):
        with pytest.raises(willis.WillisError, match="expected the folder of a run of infer"):
            willis.load(tmp_path / name)


def test_the_topology_of_a_run_knows_what_is_kept(tmp_path):
    run = willis.infer(BROKEN, samples=64)
    landmarks = "data/broken-circle-of-willis.landmarks.csv"
    run.save(tmp_path / "out", dpi=36)
    found, of_file = (willis.classify(one, landmarks=landmarks) for one in (run.topology, tmp_path / "out" / "topology.graphml"))
    assert found.record["segments"] == of_file.record["segments"]
    assert not any("nothing says which were kept" in note for note in found._phenotype.notes)
