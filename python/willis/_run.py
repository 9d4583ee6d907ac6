"""A run of infer: in the foreground, in the background, and back from its folder."""

from __future__ import annotations

import atexit
import csv
import html
import json
import re
import tempfile
import threading
import warnings
import weakref
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _willis
from ._errors import Note, WillisError, library
from ._following import PathLike, Progress, followed, say, threads_of
from ._network import Network, Source, Table, defaults_of, network_of, numbers, place, read, read_run
from ._words import Nodes, conditions, whole, words

Place = Sequence[float]
"""Three numbers of mm."""


class Run:
    """What :func:`infer` found: likelihoods, decisions, and the plausible topology."""

    def __init__(self, run: _willis.Run) -> None:
        self._run = run
        self._tables: list[Table] | None = None

    def _of(self, row: int) -> Table:
        if self._tables is None:
            self._tables = [Table(columns) for columns in self._run.tables()]
        return self._tables[row]

    @property
    def nodes(self) -> Table:
        """The nodes of the graph that was sampled, with the columns of nodes.csv."""
        return self._of(0)

    @property
    def edges(self) -> Table:
        """Every vessel of the graph that was sampled, with the columns of edges.csv."""
        return self._of(1)

    @property
    def likelihood(self) -> Any:
        """The matrix L as ``scipy.sparse.csr_array`` (nodes x nodes), W/m3; symmetric."""
        sparse = library("scipy.sparse", "graph")
        rows, columns, values = self._run.matrix()
        n = self.graph.n_nodes
        upper = sparse.coo_array((values, (rows, columns)), shape=(n, n))
        return (upper + upper.T).tocsr()

    @property
    def kept(self) -> npt.NDArray[np.bool_]:
        """Per vessel whether it belongs to the plausible topology."""
        return self._run.kept()

    @property
    def probability(self) -> npt.NDArray[np.float64]:
        """Per vessel its probability by the evidence; NaN where there is none."""
        return self.edges["probability"]

    @property
    def undecided(self) -> npt.NDArray[np.int64]:
        """The rows of the vessels whose decision is not sure: their probability is near the cut, or L within two standard errors of its threshold."""
        return self._run.undecided()

    @property
    def review(self) -> Table | None:
        """What a person is asked, in order, with the columns of review.csv; None where ``keep`` does not go by probabilities, or nothing is asked."""
        columns = self._run.review()
        return None if columns is None else Table(columns)

    @property
    def expected_wrong(self) -> float | None:
        """How many of the kept connections are expected to be wrong; None without evidence."""
        expected = self._run.expected()
        return None if expected is None else expected[0]

    @property
    def expected_missed(self) -> float | None:
        """How many true connections are expected to be missed; None without evidence."""
        expected = self._run.expected()
        return None if expected is None else expected[1]

    @property
    def graph(self) -> Network:
        """The over-connected graph that was sampled."""
        return _graph_of(self)

    @property
    def topology(self) -> Network:
        """The plausible topology: the vessels that are kept, those that candidates divided in vain as one again."""
        return _topology_of(self)

    def rekeep(self, keep: str) -> Run:
        """The same samples decided on by another rule, as ``keep`` of :func:`infer`."""
        return Run(self._run.decided_by(keep))

    def decide(
        self,
        accept: Sequence[int] = (),
        reject: Sequence[int] = (),
        *,
        join: Sequence[Sequence[Place]] = (),
        part: Sequence[Sequence[Sequence[Place]]] = (),
        delete: Sequence[Place] = (),
        who: str = "",
    ) -> Run:
        """The run again with decisions of a person on rows of :attr:`edges`: accepted connections are certain, rejected ones are gone,
        and the probabilities of those beside them follow. ``decisions`` of :func:`infer` takes the list that a page saves.

        Places are three numbers of mm. Each of ``join`` is a pair of places that a vessel connects, each of ``part`` groups of places whose
        vessels go together while those of different groups only touch, and each of ``delete`` a place on a vessel that is none. A part
        doubles what two groups share, and a group of one place is cut off. Joins come first, then parts, then what is deleted.
        """
        accepted, rejected = _rows("accept", accept), _rows("reject", reject)
        if min([*accepted, *rejected, 0]) < 0 or len({*accepted, *rejected}) < len(accepted) + len(rejected):
            raise WillisError("decisions: a row that is negative or comes twice; expected each row once", item="decisions")
        edits = [f"join {places_of(pair)}" for pair in join]
        edits += ["part " + " | ".join(places_of(group) for group in groups) for groups in part]
        edits += [f"delete {places_of([place])}" for place in delete]
        return Run(self._run.decide(accepted, rejected, edits, who, now()))

    def save(self, folder: PathLike, *, force: bool = False, dpi: int = 150) -> None:
        """Writes the folder that ``willis infer`` writes, byte for byte but for the times in run.json; ``force`` replaces the one of an earlier run."""
        for note in self._run.save(Path(folder), force, whole("dpi", dpi)):
            warnings.warn(note, Note, stacklevel=2)

    def __str__(self) -> str:
        return "\n".join(f"{heading:>10}  {fact}" for heading, fact in self._run.said())

    def __repr__(self) -> str:
        kept = self.kept
        return f"<willis.Run: {int(kept.sum())} of {len(kept)} vessels kept>"

    def _repr_html_(self) -> str:
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore", Note)
            self.save(Path(folder, "run"), dpi=36)
            return page_of(Path(folder, "run"))

    def __reduce__(self) -> tuple[object, ...]:
        return (_run_from_bytes, (self._run.to_bytes(),))


def _rows(name: str, rows: Sequence[int]) -> list[int]:
    """Rows, which are whole numbers."""
    array = numbers(name, rows, "iuf")
    # An empty list is one of real numbers.
    if array.ndim != 1 or array.size and array.dtype.kind == "f":
        raise WillisError(f"{name}: {array.dtype} in {array.ndim} dimensions; expected a list of whole numbers", item=name, expected="a list of whole numbers")
    return [int(row) for row in array]


def now() -> str:
    """The time as decisions have it."""
    return datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def places_of(places: Iterable[Place]) -> str:
    """Places as decisions have them."""
    return " + ".join(" ".join(repr(float(x)) for x in place("place", one)) for one in places)


def _run_from_bytes(stored: bytes) -> Run:
    return Run(_willis.run_from_bytes(stored))


def _graph_of(run: Run) -> Network:
    return Network(run._run.graph(), (_graph_of, (run,)))


def _topology_of(run: Run) -> Network:
    return Network(run._run.topology(), (_topology_of, (run,)))


class Handle:
    """A run in the background, as :func:`infer` starts it with ``background=True``."""

    def __init__(self, prepared: _willis.Prepared, threads: int | None, progress: Progress) -> None:
        self._prepared, self._watch = prepared, _willis.Watch(keep=True)
        self._run: Run | None = None
        self._error: BaseException | None = None

        def work(told: Callable[[int, int], object] | None) -> Run:
            return Run(prepared.sample(self._watch, threads, told, say))

        def try_work() -> None:
            try:
                self._run = followed(progress, work)
            except BaseException as error:  # it is raised where somebody waits
                self._error = error

        self._thread = threading.Thread(target=try_work, name="willis", daemon=True)
        _at_work.add(self)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether the run has ended: with a result, with an error, or cancelled."""
        return not self._thread.is_alive()

    @property
    def samples(self) -> tuple[int, int]:
        """How many samples are finished, and of how many; (0, 0) before the first."""
        return self._watch.samples()

    def wait(self, timeout: float | None = None) -> Run:
        """The result, when it is there. Ctrl-C ends the waiting, not the run.

        Raises
        ------
        TimeoutError
            It is not there within so many seconds.
        WillisError
            What went wrong; that it was cancelled.
        """
        self._thread.join(timeout)
        if self._thread.is_alive():
            raise TimeoutError(f"the run is at {self.samples[0]:,} of {self.samples[1]:,} samples after {timeout} s")
        if self._error is not None:
            raise self._error
        assert self._run is not None
        return self._run

    def result_so_far(self) -> Run | None:
        """What the samples say that are finished by now, as if they were all; None where none is within 5 s.

        Which samples these are depends on the threads: it is a look, not a result to keep. After :meth:`cancel` it is what was finished.
        """
        if self._run is not None:
            return self._run
        found = self._prepared.so_far(self._watch)
        return None if found is None else Run(found)

    def cancel(self) -> None:
        """Stops the run, and returns when it has stopped."""
        self._watch.stop()
        self._thread.join()

    def __repr__(self) -> str:
        done, total = self.samples
        return f"<willis.Handle: {'ended' if self.done else 'at work'}, {done:,} of {total:,} samples>"


_at_work: weakref.WeakSet[Handle] = weakref.WeakSet()


@atexit.register
def _stop_all() -> None:
    for handle in list(_at_work):
        handle.cancel()


def infer(
    source: Source,
    *,
    epsilon: float = 0.5,
    samples: int = 1000,
    until: Literal["stable"] | None = None,
    exact: bool = False,
    preset: Literal["paper"] | None = None,
    seed: int = 0,
    uncertain: Literal["candidates", "all"] | None = None,
    weight: Literal["resilience", "count", "global"] = "resilience",
    viscosity: str = "3.5cP",
    solver: Literal["auto", "lanes", "gradients", "reference"] = "auto",
    keep: str | None = None,
    decisions: PathLike | None = None,
    prior: PathLike | None = None,
    cut: PathLike | None = None,
    mask: PathLike | None = None,
    image: PathLike | None = None,
    probability: PathLike | None = None,
    vessels: Literal["auto", "bright", "dark"] | None = None,
    image_places: int | None = None,
    k: int | None = None,
    max_gap: float | str | None = None,
    attach: Literal["centerline", "ends"] | None = None,
    candidate_radius: Literal["min", "mean"] | None = None,
    max_candidate_radius: float | str | None = None,
    inlets: Nodes | None = None,
    outlets: str | Nodes | None = None,
    flows: Nodes | None = None,
    bc: PathLike | None = None,
    landmarks: PathLike | None = None,
    labels: Literal["names", "icafe", "topcow"] | None = None,
    variant_prior: PathLike | None = None,
    unseen: float | None = None,
    arteries: PathLike | None = None,
    hypoplastic: str | float | None = None,
    threads: int | None = None,
    background: bool = False,
    progress: Progress = True,
) -> Any:
    """Finds the plausible topology of centerlines, of a mask or of a candidate graph: what ``willis infer`` does, with its options.

    Lengths are in mm unless they say otherwise. ``inlets`` and ``outlets`` are lists of ``NODE`` or ``NODE=VALUE``, or values by node; ``outlets`` as one text
    is the rule for those that willis finds (``"ground"``, ``"murray=700mL/min"``).

    Parameters
    ----------
    source
        A :class:`Network`, or the path of a file.
    background
        Return a :class:`Handle` at once, by which to wait, look and cancel.
    threads
        Worker threads; the results do not depend on it.
    progress
        Whether to show progress on a terminal or in a notebook, or a function of the samples done and their total.

    Returns
    -------
    Run
        Or :class:`Handle`, with ``background``.

    Raises
    ------
    WillisError
        What is wrong, and what is accepted.
    KeyboardInterrupt
        Ctrl-C, within 0.2 s while samples are taken.
    """
    given = dict(locals())
    for name in ("source", "background", "threads", "progress"):
        del given[name]
    watch, threads = _willis.Watch(), threads_of(threads)
    prepared = _prepared(network_of(source), given, defaults_of(infer), watch, threads)
    if background:
        return Handle(prepared, threads, progress)

    def work(told: Callable[[int, int], object] | None) -> Any:
        return Run(prepared.sample(watch, threads, told, say))

    return followed(progress, work)


def _prepared(
    network: Network, given: dict[str, Any], defaults: dict[str, Any], watch: _willis.Watch, threads: int | None
) -> _willis.Prepared:
    given |= conditions(*(given.pop(name) for name in ("inlets", "outlets", "flows")))
    return _willis.prepare(network._scan, network._reading + words(given, defaults), watch, threads, say)


def candidates(
    source: Source,
    *,
    prior: PathLike | None = None,
    cut: PathLike | None = None,
    mask: PathLike | None = None,
    image: PathLike | None = None,
    probability: PathLike | None = None,
    vessels: Literal["auto", "bright", "dark"] | None = None,
    k: int | None = None,
    max_gap: float | str | None = None,
    attach: Literal["centerline", "ends"] | None = None,
    candidate_radius: Literal["min", "mean"] | None = None,
    max_candidate_radius: float | str | None = None,
    inlets: Nodes | None = None,
    outlets: str | Nodes | None = None,
    flows: Nodes | None = None,
    bc: PathLike | None = None,
) -> Network:
    """Builds the over-connected graph and stops: what ``willis candidates`` does; the options are those of :func:`infer`."""
    given = dict(locals())
    return _candidates_of(network_of(given.pop("source")), given)


def _candidates_of(network: Network, given: dict[str, Any]) -> Network:
    prepared = _prepared(network, dict(given), defaults_of(candidates), _willis.Watch(), None)
    return Network(prepared.graph(), (_candidates_of, (network, given)))


class SavedRun:
    """A run back from its folder, as :func:`load` reads it. The sums of its samples are not there, so it cannot be decided on again."""

    def __init__(self, folder: PathLike) -> None:
        self.folder = Path(folder)
        named = str(self.folder)
        try:
            #: What run.json holds.
            self.record: dict[str, Any] = json.loads((self.folder / "run.json").read_text(encoding="utf-8"))
            #: The nodes of the graph that was sampled, with the columns of nodes.csv.
            self.nodes = table_of(self.folder / "nodes.csv")
            #: Every vessel of the graph that was sampled, with the columns of edges.csv.
            self.edges = table_of(self.folder / "edges.csv")
            if "kept" not in self.edges:
                raise ValueError("edges.csv says of no vessel whether it is kept")
        except (OSError, ValueError) as error:
            expected = "the folder of a run of infer"
            raise WillisError(f"{named}: {error}; expected {expected}", file=named, expected=expected) from None

    @property
    def likelihood(self) -> Any:
        """The matrix L as ``scipy.sparse.csr_array`` (nodes x nodes), W/m3; symmetric."""
        sparse = library("scipy.sparse", "graph")
        return sparse.csr_array(sparse.load_npz(self.folder / "likelihood.npz"))

    @property
    def kept(self) -> npt.NDArray[np.bool_]:
        """Per vessel whether it belongs to the plausible topology."""
        return self.edges["kept"].astype(bool)

    @property
    def probability(self) -> npt.NDArray[np.float64]:
        """Per vessel its probability by the evidence; NaN where there is none."""
        return self.edges["probability"]

    @property
    def undecided(self) -> npt.NDArray[np.int64]:
        """The rows of the vessels whose decision is not sure: their probability is near the cut, or L within two standard errors of its threshold."""
        return np.asarray(self.record["convergence"]["undecided_edges"], dtype=np.int64)

    @property
    def review(self) -> Table | None:
        """What a person is asked, in order, with the columns of review.csv; None where ``keep`` does not go by probabilities, or nothing is asked."""
        path = self.folder / "review.csv"
        return table_of(path) if path.exists() else None

    @property
    def expected_wrong(self) -> float | None:
        """How many of the kept connections are expected to be wrong; None without evidence."""
        return (self.record["expected_errors"] or {}).get("wrong")

    @property
    def expected_missed(self) -> float | None:
        """How many true connections are expected to be missed; None without evidence."""
        return (self.record["expected_errors"] or {}).get("missed")

    @property
    def graph(self) -> Network:
        """The over-connected graph that was sampled."""
        return read_run(self.folder)

    @property
    def topology(self) -> Network:
        """The plausible topology: the vessels that are kept, those that candidates divided in vain as one again."""
        return read(self.folder / "topology.graphml")

    def __repr__(self) -> str:
        kept = self.kept
        return f"<willis.SavedRun of {self.folder}: {int(kept.sum())} of {len(kept)} vessels kept>"

    def _repr_html_(self) -> str:
        return page_of(self.folder)


def load(folder: PathLike) -> SavedRun:
    """A run from the folder that ``willis infer`` or :meth:`Run.save` wrote.

    Raises
    ------
    WillisError
        A folder of something else.
    """
    return SavedRun(folder)


def page_of(folder: Path) -> str:
    """The page of a folder, to be shown in a notebook."""
    page = html.escape((folder / "report.html").read_text(encoding="utf-8"))
    return f'<iframe srcdoc="{page}" style="width: 100%; height: 720px; border: 0"></iframe>'


# Also where no row has any: NaN is unlike every text.
_TEXT = frozenset({"id", "id_a", "id_b", "figure", "label", "role", "origin", "subject", "input", "sha256", "status", "error", "variant", "kind", "question"})
_TEXT |= {"completeness", "hypoplastic", "needs_person", "frame", "territory", "measure", "group_a", "group_b"}
_TEXT |= {f"{name}_{reader}" for name in ("decision", "who", "comment") for reader in "ab"}
_WHOLE = frozenset({"rank", "node", "component", "edge", "node_a", "node_b", "above_median", "kept"})


# The apostrophe before what a spreadsheet would take for a formula.
_GUARD = re.compile(r"^'(?='*[=+\-@\t\r＝＋－＠])")


def table_of(path: Path) -> Table:
    """The columns of a table that willis wrote; a number that is missing is NaN."""
    with path.open(newline="", encoding="utf-8") as file:
        names, *rows = [[_GUARD.sub("", cell) for cell in row] for row in csv.reader(file)]
    out = Table()
    for name, values in zip(names, zip(*rows) if rows else [()] * len(names)):
        # A subject that failed has none.
        if name in _WHOLE and all(values):
            out[name] = np.array(values, dtype=np.int64)
        elif name in _TEXT:
            out[name] = np.array(values, dtype=str)
        else:
            try:
                out[name] = np.array([float(value) if value else np.nan for value in values])
            except ValueError:
                out[name] = np.array(values, dtype=str)
    return out
