"""The commands as functions, and what they return."""

from __future__ import annotations

import inspect
import io
import json
import logging
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt

from . import _willis
from ._errors import Note, WillisError
from ._words import Repeated, words

PathLike = Union[str, "os.PathLike[str]"]
Progress = Union[bool, Callable[[int, int], object]]
Table = dict[str, npt.NDArray[Any]]

_LOG = logging.getLogger("willis")


def _say(heading: str, fact: str) -> None:
    """A note is a warning, everything else goes to the log."""
    if heading == "note":
        warnings.warn(fact, Note, stacklevel=4)
    else:
        _LOG.info("%s: %s", heading, fact)


class _Bar:
    """Progress on a terminal or in a notebook: tqdm's, or a plain line."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm

            self._tqdm: Any = tqdm(unit="samples", leave=False)
        except ImportError:
            self._tqdm = None

    def __call__(self, done: int, total: int) -> None:
        if self._tqdm is not None:
            self._tqdm.total = total
            self._tqdm.update(done - self._tqdm.n)
        else:
            sys.stderr.write(f"\rwillis: {done:,} of {total:,} samples")
            sys.stderr.flush()

    def close(self) -> None:
        if self._tqdm is not None:
            self._tqdm.close()
        else:
            sys.stderr.write("\n")


def _is_watched() -> bool:
    return sys.stderr.isatty() or "ipykernel" in sys.modules


def _followed(progress: Progress, work: Callable[[Callable[[int, int], object] | None], Any]) -> Any:
    if callable(progress):
        return work(progress)
    if not (progress and _is_watched()):
        return work(None)
    bar = _Bar()
    try:
        return work(bar)
    finally:
        bar.close()


class Network:
    """Vessels: those of a file, of arrays, or of a topology.

    Made by :func:`read`, :func:`centerlines` and the like; not by itself.
    """

    def __init__(self, scan: _willis.Scan, reading: Sequence[str] = ()) -> None:
        self._scan, self._reading = scan, list(reading)

    @property
    def nodes(self) -> Table:
        """The nodes as arrays by column, with the names and units of nodes.csv."""
        return self._scan.tables()[0]

    @property
    def edges(self) -> Table:
        """The vessels as arrays by column, with the names and units of edges.csv."""
        return self._scan.tables()[1]

    @property
    def n_nodes(self) -> int:
        """How many nodes there are."""
        return self._scan.node_count

    @property
    def n_edges(self) -> int:
        """How many vessels there are."""
        return self._scan.vessel_count

    def lines(self) -> tuple[npt.NDArray[np.int64], list[npt.NDArray[np.float64]], list[npt.NDArray[np.float64]]]:
        """The two nodes of each vessel (M, 2), and for each vessel its points (P, 3) and their radii (P), mm."""
        ends, points, radii, first = self._scan.lines()
        return ends, np.split(points, first[1:-1]), np.split(radii, first[1:-1])

    def to_arrays(self) -> Table:
        """The centerlines as ``coords`` (N, 3) and ``radii``, mm, ``edges`` (M, 2), and ``labels`` where there are any.

        :func:`centerlines` takes them again. Where no vessel has points between its nodes, ``radii`` and ``lengths`` are those of the
        edges.
        """
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "network.npz")
            _willis.write(self._scan, path, None, False)
            with np.load(path) as arrays:
                return {name: arrays[name] for name in arrays.files}

    def to_networkx(self) -> Any:
        """A ``networkx.MultiGraph`` whose nodes and edges have the columns as attributes; nodes are rows."""
        import networkx as nx

        graph = nx.MultiGraph()
        nodes, edges = self.nodes, self.edges
        ends = self.lines()[0]
        for row in range(self.n_nodes):
            graph.add_node(row, **{name: values[row].item() for name, values in nodes.items()})
        for row, (a, b) in enumerate(ends.tolist()):
            graph.add_edge(a, b, key=row, **{name: values[row].item() for name, values in edges.items()})
        return graph

    def save(self, path: PathLike, *, to: str | None = None, force: bool = False) -> None:
        """Writes a file; its ending says the format, as for ``willis convert``, unless ``to`` does."""
        for note in _willis.write(self._scan, Path(path), to, force):
            warnings.warn(note, Note, stacklevel=2)

    def __repr__(self) -> str:
        name = f" of {self._scan.name}" if self._scan.name else ""
        return f"<willis.Network{name}: {self.n_nodes} nodes, {self.n_edges} vessels>"


Source = Union[Network, PathLike]


class Run:
    """What :func:`infer` found: likelihoods, decisions, and the plausible topology."""

    def __init__(self, run: _willis.Run) -> None:
        self._run = run
        self._tables: list[Table] | None = None

    def _of(self, row: int) -> Table:
        if self._tables is None:
            self._tables = list(self._run.tables())
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
        from scipy.sparse import coo_array

        rows, columns, values = self._run.matrix()
        n = self.graph.n_nodes
        upper = coo_array((values, (rows, columns)), shape=(n, n))
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
        """The rows of the vessels whose decision two standard errors could flip."""
        return self._run.undecided()

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
        return Network(self._run.graph())

    @property
    def topology(self) -> Network:
        """The plausible topology: the vessels that are kept, with all nodes."""
        return Network(self._run.topology())

    def rekeep(self, keep: str) -> Run:
        """The same samples decided on by another rule, as ``keep`` of :func:`infer`."""
        return Run(self._run.decided_by(keep))

    def save(self, folder: PathLike, *, dpi: int = 150) -> None:
        """Writes the folder that ``willis infer`` writes, byte for byte but for the times in run.json."""
        for note in self._run.save(Path(folder), dpi):
            warnings.warn(note, Note, stacklevel=2)

    def __str__(self) -> str:
        return "\n".join(f"{heading:>10}  {fact}" for heading, fact in self._run.said())

    def __repr__(self) -> str:
        kept = self.kept
        return f"<willis.Run: {int(kept.sum())} of {len(kept)} vessels kept>"

    def __reduce__(self) -> tuple[object, ...]:
        return (_run_from_bytes, (self._run.to_bytes(),))


def _run_from_bytes(stored: bytes) -> Run:
    return Run(_willis.run_from_bytes(stored))


class Shard:
    """Some of the samples of a run, for :func:`merge`; it pickles."""

    def __init__(self, record: bytes, sums: bytes) -> None:
        self.record, self.sums = record, sums

    @property
    def samples(self) -> tuple[int, int]:
        """The first sample, and the first after the last."""
        first, last = json.loads(self.record)["range"]
        return first, last

    def __repr__(self) -> str:
        return "<willis.Shard: samples {}..{}>".format(*self.samples)


def read(
    path: PathLike,
    *,
    units: Literal["mm", "um", "cm", "m", "voxel"] = "mm",
    spacing: float | Sequence[float] | None = None,
    radius_array: str | None = None,
    radius: Literal["mean", "effective"] = "mean",
    default_radius: float | str | None = None,
    loops: PathLike | None = None,
    observed: bool = False,
    level: float | None = None,
    radius_from: Literal["area", "distance", "inscribed"] = "area",
    box: Sequence[float] | None = None,
    max_input: int | str = "2GiB",
) -> Network:
    """Reads centerlines, a mask or a graph in any format that the command reads, or the folder of a run.

    The options are those of ``willis infer``; lengths are in mm, unless they say otherwise (``"500um"``).

    Raises
    ------
    WillisError
        With file, line or item, value, and what is accepted.
    """
    reading = _reading(read, locals())
    network = Network(_willis.read(Path(path), reading), reading)
    _tell_of(network)
    return network


def _reading(function: Callable[..., Any], given: dict[str, Any]) -> list[str]:
    return words({name: given[name] for name in inspect.signature(function).parameters if name != "path"}, _defaults(function))


def _defaults(function: Callable[..., Any]) -> dict[str, Any]:
    parameters = inspect.signature(function).parameters.items()
    return {name: one.default for name, one in parameters if one.default is not inspect.Parameter.empty}


def _tell_of(network: Network) -> None:
    for heading, fact in network._scan.said():
        _say(heading, fact)


def centerlines(
    points: npt.ArrayLike,
    edges: npt.ArrayLike,
    radii: npt.ArrayLike,
    *,
    labels: npt.ArrayLike | None = None,
    lengths: npt.ArrayLike | None = None,
) -> Network:
    """Centerlines of arrays: points (N, 3) and their radii (N), mm, and edges (M, 2), rows of the points.

    ``radii`` (M) with ``lengths`` (M) are those of the edges, each of which is one vessel then. ``labels`` (M) name the edges, ``labels``
    (N) the points. The same as reading the NPZ of these arrays.
    """
    arrays: dict[str, Any] = {
        "coords": np.asarray(points, dtype=np.float64),
        "edges": np.asarray(edges),
        "radii": np.asarray(radii, dtype=np.float64),
    }
    if labels is not None:
        arrays["labels"] = np.asarray(labels)
    if lengths is not None:
        arrays["lengths"] = np.asarray(lengths, dtype=np.float64)
    for name, array in arrays.items():
        if array.dtype == object:
            raise WillisError(f"{name}: Python objects; expected numbers or text", item=name, expected="numbers or text")
    packed = io.BytesIO()
    np.savez(packed, **arrays)
    network = Network(_willis.read_bytes("arrays.npz", packed.getvalue(), []))
    _tell_of(network)
    return network


def _network(source: Source) -> Network:
    return source if isinstance(source, Network) else read(source)


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
    inlets: Sequence[str | int] | None = None,
    outlets: str | Sequence[str | int] | None = None,
    flows: Sequence[str] | None = None,
    bc: PathLike | None = None,
    landmarks: PathLike | None = None,
    labels: Literal["names", "icafe", "topcow"] | None = None,
    part: tuple[int, int] | None = None,
    threads: int | None = None,
    progress: Progress = True,
) -> Any:
    """Finds the plausible topology of centerlines, of a mask or of a candidate graph: what ``willis infer`` does, with its options.

    Lengths are in mm unless they say otherwise. ``inlets`` and ``outlets`` are lists of ``NODE`` or ``NODE=VALUE``; ``outlets`` as one text
    is the rule for those that willis finds (``"ground"``, ``"murray=700mL/min"``).

    Parameters
    ----------
    source
        A :class:`Network`, or the path of a file.
    part
        ``(a, b)``: samples a up to b alone, each a multiple of 64 or the last, as a :class:`Shard`.
    threads
        Worker threads; the results do not depend on it.
    progress
        Whether to show progress on a terminal or in a notebook, or a function of the samples done and their total.

    Returns
    -------
    Run
        Or :class:`Shard`, with ``part``.

    Raises
    ------
    WillisError
        What is wrong, and what is accepted.
    KeyboardInterrupt
        Ctrl-C, within 0.2 s.
    """
    given = dict(locals())
    for name in ("source", "part", "threads", "progress", "inlets", "outlets", "flows"):
        del given[name]
    rule = outlets if isinstance(outlets, str) else None
    given["inlet"], given["outlet"], given["flow"] = Repeated(inlets), Repeated(None if rule else outlets), Repeated(flows)
    given["outlets"] = rule
    network = _network(source)
    all_words = network._reading + words(given, _defaults(infer))
    watch = _willis.Watch()

    def work(progress: Callable[[int, int], object] | None) -> Any:
        if part is None:
            return Run(_willis.infer(network._scan, all_words, watch, threads, progress, _say))
        first, last = part
        return Shard(*_willis.infer_part(network._scan, all_words, f"{first}..{last}", watch, threads, progress, _say))

    return _followed(progress, work)


def merge(shards: Sequence[Shard]) -> Run:
    """A run put together from all its shards, in whatever order: the same bytes as one run."""
    return Run(_willis.merge([(shard.record, shard.sums) for shard in shards]))


class Simulation:
    """The flow in a network as it is, and beside it with its changes."""

    def __init__(self, simulation: _willis.Simulation) -> None:
        self._simulation = simulation
        self.nodes: Table
        self.edges: Table
        self.nodes, self.edges = simulation.tables()

    def save(self, folder: PathLike, *, force: bool = False, dpi: int = 150) -> None:
        """Writes the folder that ``willis simulate`` writes."""
        for note in self._simulation.save(Path(folder), force, dpi):
            warnings.warn(note, Note, stacklevel=2)

    def __str__(self) -> str:
        return "\n".join(f"{heading:>10}  {fact}" for heading, fact in self._simulation.said())


def simulate(
    source: Source,
    *,
    stenosis: Mapping[str, float | str] | None = None,
    occlude: Sequence[str] | None = None,
    tortuosity: Mapping[str, float] | None = None,
    viscosity: str = "3.5cP",
    inlets: Sequence[str | int] | None = None,
    outlets: str | Sequence[str | int] | None = None,
    flows: Sequence[str] | None = None,
    bc: PathLike | None = None,
) -> Simulation:
    """Solves the flow in a network, and beside it with all changes at once: what ``willis simulate`` does.

    ``stenosis`` is the share of the diameter by which vessels, by label or ``edge:ROW``, are narrowed (0.7), or a text of the command
    (``"area:70%"``, ``"70%@mid:10mm"``); ``tortuosity`` the factor by which they are lengthened.
    """
    rule = outlets if isinstance(outlets, str) else None
    narrowed = {name: by if isinstance(by, str) else f"{100 * by:.15g}%" for name, by in (stenosis or {}).items()}
    given = {
        "stenosis": Repeated([f"{name}={by}" for name, by in narrowed.items()]),
        "occlude": Repeated(occlude),
        "tortuosity": Repeated([f"{name}={factor!r}" for name, factor in (tortuosity or {}).items()]),
        "viscosity": viscosity,
        "inlet": Repeated(inlets),
        "outlet": Repeated(None if rule else outlets),
        "flow": Repeated(flows),
        "bc": bc,
        "outlets": rule,
    }
    network = _network(source)
    made = words(given, _defaults(simulate))
    return Simulation(_willis.simulate(network._scan, network._reading + made, ""))


class Modulation:
    """How a network responds to resistances that vary at random."""

    def __init__(self, modulation: _willis.Modulation) -> None:
        self._modulation = modulation

    @property
    def record(self) -> dict[str, Any]:
        """What run.json of the command holds."""
        return json.loads(self._modulation.record)

    def save(self, folder: PathLike, *, save_samples: bool = False, dpi: int = 150) -> None:
        """Writes the files of ``willis modulate`` into a new folder."""
        Path(folder).mkdir()
        self._modulation.write(Path(folder), save_samples, dpi)


def modulate(
    source: Source,
    *,
    classes: Sequence[tuple[float, float]] = ((0, 0.2), (0.2, 0.3), (0.3, 0.5)),
    samples: int = 1000,
    seed: int = 0,
    reading: Literal["increment", "conductance", "literal", "geometry"] = "increment",
    vessels: Sequence[str] | None = None,
    viscosity: str = "3.5cP",
    threshold: float | None = None,
    threads: int | None = None,
    progress: Progress = True,
) -> Modulation:
    """Modulates the resistances of a network at random: what ``willis modulate`` does.

    ``classes`` are pairs, low and high, of u; ``threshold`` is in mmHg/mm2.
    """
    given = {
        "classes": ",".join(f"{low!r}:{high!r}" for low, high in classes),
        "samples": samples,
        "seed": seed,
        "reading": reading,
        "vessels": vessels,
        "viscosity": viscosity,
        "threshold": threshold,
    }
    network = _network(source)
    defaults = {**_defaults(modulate), "classes": "0:0.2,0.2:0.3,0.3:0.5"}
    all_words = network._reading + words(given, defaults)
    watch = _willis.Watch()
    work = lambda told: _willis.modulate(network._scan, all_words, "", watch, threads, told, _say)  # noqa: E731
    return Modulation(_followed(progress, work))


class Phenotype:
    """The variant of a Circle of Willis, with probabilities where the topology is uncertain."""

    def __init__(self, phenotype: _willis.Phenotype) -> None:
        self._phenotype = phenotype

    @property
    def record(self) -> dict[str, Any]:
        """What phenotype.json of the command holds."""
        return json.loads(self._phenotype.json)

    @property
    def probabilities(self) -> dict[str, float] | None:
        """The probability of each segment; None for vessels that are taken as they are."""
        found = self.record.get("probabilities")
        return None if found is None else found["segments"]


def classify(
    source: Source | Run,
    *,
    landmarks: PathLike | None = None,
    labels: Literal["names", "icafe", "topcow"] | None = None,
) -> Phenotype:
    """Classifies the Circle of Willis of vessels as they are, or of a run with probabilities: what ``willis classify`` does."""
    made = words({"landmarks": landmarks, "labels": labels}, {})
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(source, Run):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", Note)
                source.save(Path(folder, "run"), dpi=36)
                network = read(Path(folder, "run"))
        else:
            network = _network(source)
        found = _willis.classify(network._scan, network._reading + made, "")
    for note in found.notes:
        _say("note", note)
    return Phenotype(found)


def train(
    cases: Sequence[PathLike],
    output: PathLike,
    *,
    model: Literal["tracing", "skeleton", "contacts"] = "tracing",
    folds: int = 3,
    save_folds: bool = False,
    images_onto: PathLike | None = None,
    force: bool = False,
) -> None:
    """Fits a model to cases whose true connections are known, and writes it: what ``willis train`` does."""
    given = {"model": model, "folds": folds, "save_folds": save_folds, "images_onto": images_onto, "force": force}
    _willis.call(["train", *map(os.fspath, cases), "-o", os.fspath(output), *words(given, _defaults(train))])


def phantom(
    kind: Literal["circle-of-willis", "cerebral", "tree", "arterial", "capillary"],
    *,
    without: Sequence[str] | None = None,
    edges: int | None = None,
    seed: int | None = None,
    spacing: float | str | None = None,
) -> Network:
    """Test anatomy with a known answer, whole; ``willis phantom --break`` makes files of broken ones."""
    given = {"without": Repeated(without), "edges": edges, "seed": seed, "spacing": spacing}
    return Network(_willis.phantom(kind, words(given, {})))


def set_num_threads(threads: int) -> None:
    """So many threads from now on, where a call does not say otherwise; at first as many as ``RAYON_NUM_THREADS`` says, or processors."""
    _willis.set_num_threads(threads)
