"""The panel of napari, without a screen: where its layers lie, and that what a person does there is what the command makes of the saved list."""

import csv
import time

import numpy as np
import pytest

import willis
from willis._napari import KEYS, Desk, Grid, network_of_layer
from willis._review import Review

napari = pytest.importorskip("napari", reason="napari is not installed: python/tests/napari.txt")
nibabel = pytest.importorskip("nibabel")
SCAN = "data/scan.nii.gz"


@pytest.fixture(scope="module")
def scan():
    image = nibabel.load(SCAN)
    return np.asarray(image.dataobj).astype(np.uint8), image.affine


@pytest.fixture
def viewer():
    made = napari.Viewer(show=False)
    yield made
    made.close()


@pytest.fixture
def desk(viewer, scan, tmp_path):
    """The panel in napari's window, with the run of the scan as an array of which napari knows the file."""
    np.save(tmp_path / "brain.npy", scan[0])
    (layer,) = viewer.open(tmp_path / "brain.npy", plugin="napari", layer_type="labels", scale=(0.6, 0.6, 0.6), units="mm")
    made = Desk(viewer)
    viewer.window.add_dock_widget(made.panel)
    made.mask.value, made.folder.value, made.who.value = layer, tmp_path, "A. Reader"
    made.infer()()()
    return made


def press(desk, key):
    """A key on the slices, as Qt hands it to napari."""
    from qtpy.QtTest import QTest

    QTest.keyClick(desk.viewer.window._qt_viewer.canvas.native, key)


def rows_of(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def of_command(desk):
    """What infer makes of the file and the saved decisions."""
    network = willis.read(desk.folder.value / "brain.npy", spacing=0.6)
    return willis.infer(network, decisions=desk.folder.value / "brain-decisions.csv", progress=False)


def same_runs(a, b):
    assert list(a.edges) == list(b.edges)
    for name, values in a.edges.items():
        np.testing.assert_array_equal(values, b.edges[name], err_msg=name)


def test_the_manifest_is_one_of_napari_and_leads_to_the_panel():
    from npe2 import PluginManifest

    manifest = PluginManifest.from_file("python/willis/napari.yaml")
    manifest.validate_imports()
    (widget,) = manifest.contributions.widgets
    command = next(one for one in manifest.contributions.commands if one.id == widget.command)
    module, name = str(command.python_name).split(":")
    assert (module, name) == ("willis._napari", "panel")


def test_napari_opens_the_panel_of_an_installed_package(viewer):
    from importlib.metadata import entry_points

    if not entry_points(group="napari.manifest", name="willis"):
        pytest.skip("willis runs from its sources, of which napari knows nothing")
    _, panel = viewer.window.add_plugin_dock_widget("willis", "Arteries")
    assert [widget.label for widget in panel][:2] == ["mask", "axes point"]


@pytest.mark.parametrize("axes", ["not known", "RAS", "LPS", "SAR", "SPL"])
def test_vessels_lie_in_the_voxels_of_their_layer(axes):
    mask = np.zeros((12, 14, 40), dtype=np.uint8)
    mask[4:8, 5:9, 4:36] = 1
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    layer = napari.layers.Labels(mask, scale=(500, 400, 800), translate=(3000, -2000, 700), rotate=turn, units="um")
    grid, network = Grid(layer, axes), network_of_layer(layer, axes)
    world = grid.to_world(np.concatenate(network.lines()[1]))
    voxels = np.round([layer.world_to_data(place) for place in world]).astype(int)
    assert mask[tuple(voxels.T)].all()
    # Along the longest axis, and short of the lumen by three voxels at each end, as thinning is.
    assert 0.8 * 32 - 6 * 0.8 - 1e-9 < network.edges["length_mm"].sum() < 0.8 * 32
    np.testing.assert_allclose(grid.to_mm(world), np.concatenate(network.lines()[1]), atol=1e-9)


def test_the_axes_may_be_turned(scan):
    voxels, affine = scan
    plain = willis.from_mask(voxels, affine=affine)
    # As readers of napari hand images over: the last axis first.
    flip = np.eye(4)[[2, 1, 0, 3]]
    layer = napari.layers.Labels(voxels.transpose(2, 1, 0), affine=flip @ affine @ flip)
    turned = network_of_layer(layer, "SAR")
    for name in ("length_mm", "radius_mm"):
        np.testing.assert_allclose(np.sort(turned.edges[name]), np.sort(plain.edges[name]), rtol=1e-9)
    boxes = [np.concatenate(network.lines()[1]) for network in (turned, plain)]
    np.testing.assert_allclose(boxes[0].min(axis=0), boxes[1].min(axis=0), atol=1e-9)


def test_an_image_needs_a_level():
    mask = np.zeros((12, 14, 40))
    mask[4:8, 5:9, 4:36] = 0.9
    layer = napari.layers.Image(mask)
    assert network_of_layer(layer, level=0.5).n_edges == 1
    with pytest.raises(willis.WillisError, match="expected a level"):
        network_of_layer(layer)
    with pytest.raises(willis.WillisError, match="2 axes"):
        network_of_layer(napari.layers.Labels(np.zeros((3, 3), dtype=int)))


def test_questions_are_points_in_the_order_of_the_review(desk):
    asked = willis.infer(willis.read(desk.folder.value / "brain.npy", spacing=0.6), progress=False).review
    points = desk.layers["questions"]
    assert len(points.data) == len(asked["edge"]) > 3
    assert points.features["edge"].tolist() == asked["edge"].tolist()
    at = np.column_stack([asked[axis] for axis in ("x_mm", "y_mm", "z_mm")])
    # One of them is a place where one line may show two vessels, at an end of its line.
    assert "touch" in asked["kind"].tolist()
    np.testing.assert_allclose(points.data, at, atol=1e-9)
    # The slices go through the first one.
    assert desk.row == asked["edge"][0] and asked["question"][0] in desk.said.value
    np.testing.assert_allclose(desk.viewer.dims.point, points.data[0], atol=0.6)


def test_keys_decide_as_the_command_does(desk):
    first = desk.review.questions[0]
    desk.comment.value = "=seen, on two\nslices"
    press(desk, "a")
    assert desk.review.decided(first) == "accept" and desk.review.run.kept[first]
    here = desk.row
    press(desk, "r")
    assert desk.review.decided(here) == "reject" and not desk.review.run.kept[here]
    last = desk.row
    press(desk, "x")
    assert desk.review.decided(last) == "unsure"
    press(desk, "u")
    assert desk.review.decided(last) is None and desk.row == last
    press(desk, "x")
    desk.save()
    same_runs(desk.review.run, of_command(desk))
    rows = rows_of(desk.folder.value / "brain-decisions.csv")
    assert {row["decision"] for row in rows} == {"accept", "reject", "unsure"} and {row["who"] for row in rows} == {"A. Reader"}
    assert [row["comment"] for row in rows if row["decision"] == "accept"] == ["'=seen, on two slices"] and desk.comment.value == ""
    assert [int(row["edge"]) for row in rows] == sorted(int(row["edge"]) for row in rows)
    # Another session goes on where this one was.
    before = desk.review
    desk.show(desk.grid, Review(before.first, input_sha256=before.input_sha256), "brain")
    desk.load()
    same_runs(desk.review.run, before.run)
    assert [desk.review.decided(row) for row in before.questions] == [before.decided(row) for row in before.questions]


def test_places_edit_as_the_command_does(desk):
    run = desk.review.first
    lines = run.graph.lines()[1]
    gap = next(row for row in np.flatnonzero(~run.kept) if row not in run.undecided)
    places = desk.layers["places"]
    places.data = desk.grid.to_world(lines[gap][[0, -1]])
    press(desk, "j")
    assert len(desk.review.run.kept) > len(run.kept) and len(places.data) == 0
    same_runs(desk.review.run, run.decide(join=[lines[gap][[0, -1]]]))
    observed, other = [row for row in np.flatnonzero(run.edges["origin"] == "observed") if len(lines[row]) > 20][:2]
    places.data = desk.grid.to_world(lines[observed][[5]])
    press(desk, "g")
    places.add(desk.grid.to_world(lines[observed][[-5]]))
    press(desk, "p")
    made = desk.review.made[-1]
    assert made.word == "part" and made.places.count("|") == 1, desk.said.value
    places.data = desk.grid.to_world(lines[other][[10]])
    press(desk, "d")
    assert desk.review.made[-1].word == "delete", desk.said.value
    desk.save()
    same_runs(desk.review.run, of_command(desk))
    for key in "uuu":
        press(desk, key)
    same_runs(desk.review.run, run)
    # What means nothing is said, and changes nothing.
    places.data = [(900, 900, 900)]
    press(desk, "d")
    assert "from the nearest vessel" in desk.said.value and desk.review.made == []


def test_verdicts_are_kept_by_segment(desk):
    desk.verdicts["L-PComm"].value = "hypoplastic"
    desk.verdicts["R-P1"].value = "absent"
    desk.verdicts["AComm"].value = "unsure"
    press(desk, "u")
    desk.save()
    rows = rows_of(desk.folder.value / "brain-verdicts.csv")
    assert [(row["segment"], row["verdict"], row["who"]) for row in rows] == [("R-P1", "absent", "A. Reader"), ("L-PComm", "hypoplastic", "A. Reader")]
    before = desk.review
    desk.show(desk.grid, Review(before.first, input_sha256=before.input_sha256), "brain")
    desk.load()
    assert desk.verdicts["R-P1"].value == "absent" and desk.verdicts["AComm"].value == ""
    desk.verdicts["R-P1"].value = ""
    desk.save()
    assert [row["segment"] for row in rows_of(desk.folder.value / "brain-verdicts.csv")] == ["L-PComm"]
    with pytest.raises(willis.WillisError, match='verdict "gone"; expected one of present, hypoplastic, absent, unsure'):
        desk.review.judge("R-P1", "gone")


def test_files_of_others_are_not_replaced_and_faults_change_nothing(desk):
    folder, review = desk.folder.value, desk.review
    decisions, verdicts = folder / "brain-decisions.csv", folder / "brain-verdicts.csv"
    press(desk, "a")
    decisions.write_text("mine\n")
    desk._try(desk.save)
    assert "expected another folder" in desk.said.value and decisions.read_text() == "mine\n"
    row, made = review.questions[1], list(review.made)
    a, b = review.ids(row)
    for text, wanted in [
        ("mine\n", "brain-decisions.csv:1: columns mine; expected edge,id_a,id_b,decision"),
        (f"edge,id_a,id_b,decision\n{row},{a},{b},maybe\n", 'brain-decisions.csv:2: decision "maybe"; expected accept, reject, unsure'),
        (f"edge,id_a,id_b,decision\n{row},{b},{a},accept\n", f"brain-decisions.csv:2: edge {row} joins {b} to {a} in the list, and {a} to {b} here"),
        (f"edge,id_a,id_b,decision\n9999999,{a},{b},accept\n", f"brain-decisions.csv:2: edge 9999999 ({a} to {b}) is none of the {len(review.first.kept)} vessels"),
        (f"edge,id_a,id_b,decision,input_sha256\n{row},{a},{b},accept,00\n", f"brain-decisions.csv:2: edge {row} was decided on for an input with SHA-256 00"),
        (f"edge,id_a,id_b,decision\n{row},{a},{b},accept\n{row},{a},{b},reject\n", f"brain-decisions.csv:3: edge {row} comes again, after line 2"),
    ]:
        decisions.write_text(text)
        desk._try(desk.load)
        assert wanted in desk.said.value and review.made == made, (text, desk.said.value)
    decisions.unlink()
    verdicts.write_text("segment,verdict\nL-A9,present\n")
    desk._try(desk.load)
    assert 'brain-verdicts.csv:2: segment "L-A9"; expected one of L-A1' in desk.said.value and not review.verdicts


def waited(desk, act):
    """Does as a button does, until it is done."""
    from napari.qt import get_qapp

    desk._work(act)
    until = time.monotonic() + 900
    while desk.said.value == "At work." or desk.worker.is_running:
        assert time.monotonic() < until
        get_qapp().processEvents()
        time.sleep(0.05)


def test_names_are_found_beside_the_window(desk):
    waited(desk, desk.name_vessels)
    assert desk.said.value.endswith("arteries have names.")
    segments = {"L-A1", "R-A1", "AComm", "L-P1", "R-P1", "L-PComm", "R-PComm"}
    assert segments & set(desk.layers["names"].features["name"])
    assert all(np.isnan(desk.review.found(segment)) or 0 <= desk.review.found(segment) <= 1 for segment in segments)


def test_buttons_work_beside_the_window_and_say_what_is_missing(desk):
    waited(desk, desk.skeleton)
    assert len(desk.layers["skeleton"].data) > 100
    desk.mask.value = desk.viewer.add_labels(np.ones((3, 3), dtype=int), name="flat")
    waited(desk, desk.infer)
    assert desk.said.value == "layer flat: 2 axes; expected one of x, y and z alone"
    desk.viewer.layers.remove("flat")
    desk.level.value = "much"
    desk._try(desk.infer)
    assert desk.said.value == 'level "much"; expected a number'
    desk.viewer.layers.remove("brain")
    desk._try(desk.infer)
    assert desk.said.value == "mask: none; expected a layer of labels, or an image"
    # What was inferred stays.
    press(desk, "a")
    assert len(desk.review.made) == 1


def test_every_key_says_what_it_does(desk):
    texts = {button.text for container in desk.panel for button in (container if hasattr(container, "__iter__") else ()) if hasattr(button, "text")}
    for key, name in KEYS.items():
        assert f"{name.replace('_', ' ')} ({key})" in texts
