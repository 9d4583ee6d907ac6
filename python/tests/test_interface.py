"""Names, defaults and types: those of the command, and those that were promised."""

import doctest
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys

import numpy as np
import pytest

import willis

BROKEN = "data/broken-circle-of-willis.swc"
# What Python says in another way: arguments, methods of what is returned, keywords of all calls.
ELSEWHERE = {"help", "version", "output", "json", "quiet", "verbose", "force", "dpi", "checkpoint", "record-failure", "save-samples"}
# An option that is given again and again is a list.
LISTS = {"inlet": "inlets", "outlet": "outlets", "flow": "flows", "reader": "readers"}
OURS = {"progress", "background"}
# One `read` serves all commands.
OF_INFER = {"observed"}


def options_of(command):
    """The long options of a command by name, each with the default that its help states."""
    said = subprocess.run(
        [sys.executable, "-c", "import sys; from willis._command import main; sys.exit(main())", command, "--help"],
        check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    found = {}
    for part in re.split(r"\n(?=  -|      --)", said)[1:]:
        name = re.match(r"\s*(?:-\w, )?--([\w-]+)|\s*-(\w) <", part)
        default = re.search(r"\[default: ([^]]*)\]", part)
        if name:
            found[name[1] or name[2]] = default and default[1].strip()
    return found


def parameters_of(*functions):
    return {
        name: one.default
        for function in functions
        for name, one in inspect.signature(function).parameters.items()
        if one.kind is inspect.Parameter.KEYWORD_ONLY
    }


@pytest.mark.parametrize(
    ("command", "functions", "but"),
    [
        ("infer", (willis.read, willis.infer), set()),
        ("candidates", (willis.read, willis.candidates), {"threads"}),
        ("simulate", (willis.read, willis.simulate), {"threads"}),
        ("modulate", (willis.read, willis.modulate), set()),
        ("classify", (willis.read, willis.classify), {"threads", "truth"}),
        ("measure", (willis.read, willis.measure), {"threads", "outlet", "flow", "bc", "outlets"}),
        ("train", (willis.train,), {"threads"}),
    ],
)
def test_options_and_defaults_are_those_of_the_command(command, functions, but):
    theirs, mine = options_of(command), parameters_of(*functions)
    named = {LISTS.get(name, name).replace("-", "_") for name in theirs if name not in ELSEWHERE | but}
    assert named - set(mine) == set(), "options that Python lacks"
    assert set(mine) - named - OURS - {"force"} - OF_INFER - {name.replace("-", "_") for name in but} == set(), "parameters that the command lacks"
    for name, default in theirs.items():
        given = mine.get(name.replace("-", "_"))
        if name in LISTS or given is None or default is None:
            continue
        if name == "classes":
            assert ",".join(f"{low}:{high}" for low, high in given) == default
        elif isinstance(given, float):
            assert given == float(default), name
        else:
            assert str(given) == default, name


def test_names_that_were_promised():
    promised = """Cohort Handle Labelled Measured Modulation Network Note Phenotype Run SavedRun Simulation Table WillisError __version__ candidates
    centerlines classify cohort from_mask from_networkx from_skan from_vtk infer label label_cohort load measure modulate phantom read set_num_threads simulate train"""
    assert sorted(willis.__all__) == sorted(promised.split())
    for name in willis.__all__:
        assert getattr(willis, name).__doc__ or name == "__version__", name


def test_everything_public_is_documented():
    for name in willis.__all__:
        one = getattr(willis, name)
        if inspect.isclass(one):
            for member, value in vars(one).items():
                assert member.startswith("_") or value.__doc__, f"{name}.{member}"


def test_types_of_the_columns():
    run = willis.infer(BROKEN, progress=False)
    assert run.kept.dtype == np.bool_
    assert run.undecided.dtype == np.int64
    whole = {"edge", "node_a", "node_b", "above_median", "kept"}
    text = {"label", "origin"}
    for name, values in run.edges.items():
        kind = "i" if name in whole else "U" if name in text else "f"
        assert values.dtype.kind == kind and values.shape == (run.graph.n_edges,), name
    ends, points, radii = run.graph.lines()
    assert ends.shape == (run.graph.n_edges, 2) and ends.dtype == np.int64
    assert all(line.shape == (len(radius), 3) and line.dtype == radius.dtype == np.float64 for line, radius in zip(points, radii))


@pytest.mark.parametrize("name", [one.name for one in pkgutil.iter_modules(willis.__path__)] + ["__init__"])
def test_examples_in_the_docstrings(name):
    module = willis if name == "__init__" else importlib.import_module(f"willis.{name}")
    assert doctest.testmod(module).failed == 0


def test_a_second_interpreter_cannot_import_it():
    interpreters = pytest.importorskip("_xxsubinterpreters")
    other = interpreters.create()
    script = "try:\n  import willis._willis\nexcept ImportError:\n  pass\nelse:\n  raise AssertionError"
    try:
        interpreters.run_string(other, script)
    finally:
        interpreters.destroy(other)
