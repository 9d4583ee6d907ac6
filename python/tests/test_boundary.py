"""Whatever is handed over: a right answer or one clear error, never a panic."""

import subprocess
import sys
import warnings

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis.extra import numpy as arrays

import willis

LINE = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]])
PAIRS = np.array([[0, 1], [1, 2], [2, 3]])
RADII = np.ones(4)


def answered(call):
    """Whether a call answers or says what is wrong; anything else is raised."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call()
    except willis.WillisError as error:
        assert str(error) and "\n" not in str(error)


@pytest.mark.parametrize(
    "points",
    [
        LINE.astype(np.float32),
        np.asfortranarray(LINE),
        LINE[::-1][::-1],
        LINE.tolist(),
        np.concatenate([LINE, LINE])[:4],
        LINE.astype(int),
        LINE.astype(">f8"),
    ],
)
@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint8, np.uint64])
def test_arrays_of_any_layout_are_the_same(points, kind):
    pairs = PAIRS.astype(kind)
    pairs.flags.writeable = False
    network = willis.centerlines(points, pairs, RADII)
    assert network.edges["length_mm"] == pytest.approx([3.0])


@pytest.mark.parametrize(
    ("points", "pairs", "radii"),
    [
        (LINE[:, :2], PAIRS, RADII),
        (LINE.ravel(), PAIRS, RADII),
        (LINE, PAIRS.ravel(), RADII),
        (LINE, PAIRS - 1, RADII),
        (LINE, PAIRS + 1, RADII),
        (LINE, PAIRS + 0.5, RADII),
        (LINE, PAIRS, RADII[:2]),
        (LINE, PAIRS, -RADII),
        (LINE * np.nan, PAIRS, RADII),
        (LINE * np.inf, PAIRS, RADII),
        (LINE, PAIRS, RADII * np.nan),
        (LINE[:0], PAIRS[:0], RADII[:0]),
        (LINE.astype(object), PAIRS.astype(object), RADII),
    ],
)
def test_arrays_that_are_wrong_say_so(points, pairs, radii):
    answered(lambda: willis.centerlines(points, pairs, radii))


def test_what_must_be_refused_is():
    for points, pairs, radii in [(LINE[:, :2], PAIRS, RADII), (LINE, PAIRS + 1, RADII), (LINE, PAIRS, RADII[:2]), (LINE * np.nan, PAIRS, RADII)]:
        with pytest.raises(willis.WillisError):
            willis.centerlines(points, pairs, radii)
    with pytest.raises(willis.WillisError):
        willis.from_mask(np.zeros((4, 4)), spacing=1)
    with pytest.raises(willis.WillisError):
        willis.set_num_threads(0)


def test_decisions_that_are_none_are_refused():
    run = willis.infer("data/broken-circle-of-willis.swc", samples=64, progress=False)
    row = int(np.flatnonzero(run.edges["origin"] == "candidate")[0])
    for rows in (["x"], [1.5], [True], [None], [10**30], [[row]], [[row], [row, row]], np.ma.array([row], mask=[True]), 5, "ab"):
        with pytest.raises(willis.WillisError):
            run.decide(accept=rows)
    for place in ("abc", (1, 2), (1, 2, "x"), (10**400, 1, 2), (float("nan"), 1, 2), ((1, 2, 3),), (1, 2, [3, 4]), (1j, 2, 3), None):
        with pytest.raises(willis.WillisError):
            run.decide(delete=[place])
    with pytest.raises(willis.WillisError):
        willis.from_mask(np.ones((4, 4, 4)), affine="x")
    assert run.decide(accept=np.array([row], np.uint8), reject=()).kept[row]


CIRCLE = "data/circle-of-willis/complete.graphml"


@pytest.mark.parametrize(
    ("item", "call"),
    [
        ("samples", lambda: willis.infer(CIRCLE, samples=False)),
        ("cut", lambda: willis.infer(CIRCLE, cut=False)),
        ("seed", lambda: willis.infer(CIRCLE, seed=np.True_)),
        ("exact", lambda: willis.infer(CIRCLE, exact="no")),
        ("exact", lambda: willis.infer(CIRCLE, exact=2.5)),
        ("exact", lambda: willis.cohort([CIRCLE], exact="no")),
        ("threads", lambda: willis.infer(CIRCLE, threads=-1)),
        ("threads", lambda: willis.infer(CIRCLE, threads=2.0)),
        ("threads", lambda: willis.infer(CIRCLE, threads=True)),
        ("threads", lambda: willis.modulate(CIRCLE, threads=-1)),
        ("threads", lambda: willis.set_num_threads(-1)),
        ("classes", lambda: willis.modulate(CIRCLE, classes=[(0,)])),
        ("classes", lambda: willis.modulate(CIRCLE, classes=[5])),
        ("stenosis", lambda: willis.simulate(CIRCLE, stenosis={"L-PComm": None})),
        ("edges", lambda: willis.centerlines(LINE, [[0, 9]], RADII)),
        ("edges", lambda: willis.centerlines(LINE, [], RADII)),
        ("points", lambda: willis.centerlines(LINE[:, :2], PAIRS, RADII)),
    ],
)
def test_what_is_wrong_has_the_name_of_its_argument(item, call):
    with pytest.raises(willis.WillisError, match=f"^{item}") as caught:
        call()
    assert caught.value.item.startswith(item)


def test_options_of_numpy_and_by_name_are_those_of_python():
    assert willis.simulate(CIRCLE, transport=np.True_).transit is not None
    assert willis.simulate(CIRCLE, transport=np.False_).transit is None
    given = [willis.infer("data/broken-circle-of-willis.swc", samples=10, inlets=inlets) for inlets in ({"1": "60mmHg"}, {1: 60}, ["1=60mmHg"])]
    assert all(run.nodes["pressure_mmHg"][0] == 60 for run in given)


any_array = arrays.arrays(
    dtype=st.one_of(arrays.floating_dtypes(sizes=(32, 64)), arrays.integer_dtypes(), st.just(np.dtype(bool))),
    shape=arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=6),
)
coordinates = arrays.arrays(np.float64, st.tuples(st.integers(0, 8), st.just(3)), elements=st.floats(-100, 100, width=32))
rows = arrays.arrays(np.int64, st.tuples(st.integers(0, 10), st.just(2)), elements=st.integers(-2, 9))
relaxed = settings(max_examples=2500, deadline=None, suppress_health_check=list(HealthCheck))


@relaxed
@given(any_array, any_array, any_array)
def test_any_arrays(points, pairs, radii):
    answered(lambda: willis.centerlines(points, pairs, radii))


@relaxed
@given(coordinates, rows, st.data())
def test_arrays_that_nearly_fit(points, pairs, data):
    count = data.draw(st.sampled_from([len(points), len(pairs)]))
    radii = data.draw(arrays.arrays(np.float64, count, elements=st.floats(allow_nan=True, allow_infinity=True)))
    answered(lambda: willis.infer(willis.centerlines(points, pairs, radii), samples=64, progress=False))


@relaxed
@given(any_array, st.one_of(st.floats(), st.lists(st.floats(), max_size=4)))
def test_any_mask(mask, spacing):
    answered(lambda: willis.from_mask(mask, spacing=spacing))


@relaxed
@given(
    st.dictionaries(
        st.sampled_from(["epsilon", "samples", "seed", "keep", "k", "max_gap", "attach", "weight", "viscosity", "inlets", "outlets", "until"]),
        st.one_of(st.none(), st.booleans(), st.integers(-(10**20), 300), st.floats(), st.text(max_size=8), st.lists(st.text(max_size=4), max_size=2)),
        max_size=3,
    )
)
def test_any_options(options):
    samples = options.get("samples")
    # So many are no mistake, and take years.
    assume(not isinstance(samples, (int, float)) or not 1e5 < samples <= 2**50)
    network = willis.centerlines(LINE, PAIRS, RADII)
    answered(lambda: willis.infer(network, progress=False, **options))


@pytest.mark.parametrize("spoil", [lambda a: a.astype("M8[s]"), lambda a: a + 1j, lambda a: a.astype("U5"), lambda a: np.ma.masked_equal(a, 2)])
def test_what_is_no_plain_number_is_refused(spoil):
    points, edges = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float), np.array([[0, 1], [1, 2]])
    with pytest.raises(willis.WillisError, match="points: "):
        willis.centerlines(spoil(points), edges, np.ones(3))


def test_a_mask_larger_than_a_file_is_refused_before_it_is_packed():
    with pytest.raises(willis.WillisError, match="8000000000 bytes"):
        willis.from_mask(np.broadcast_to(np.zeros((1, 1, 1), bool), (2000, 2000, 2000)), spacing=1.0)


def test_a_fork_after_use_works():
    """A child that waits for threads of its parent waits for ever; the alarm ends it."""
    code = """
import os, signal, sys, willis
network = willis.phantom("circle-of-willis")
willis.infer(network, samples=64, progress=False)
child = os.fork()
if child == 0:
    signal.alarm(120)
    willis.infer(network, samples=64, progress=False)
    os._exit(0)
sys.exit(os.waitpid(child, 0)[1] != 0)
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
