"""The Circle of Willis of one subject and of many, training, and test anatomy."""

from __future__ import annotations

import glob
import json
import os
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from . import _willis
from ._errors import Note, WillisError
from ._following import PathLike, say
from ._network import Network, Source, Table, defaults_of, file_of, network_of, read, read_run
from ._run import Run, SavedRun, candidates, infer, table_of
from ._words import Nodes, Repeated, conditions, words


class Phenotype:
    """The variant of a Circle of Willis, with probabilities where the topology is uncertain."""

    def __init__(self, phenotype: _willis.Phenotype) -> None:
        self._phenotype = phenotype

    @property
    def record(self) -> dict[str, Any]:
        """What phenotype.json of the command holds."""
        record: dict[str, Any] = json.loads(self._phenotype.json)
        return record

    @property
    def probabilities(self) -> dict[str, float] | None:
        """The probability of each segment; None for vessels that are taken as they are."""
        found = self.record.get("probabilities")
        return None if found is None else found["segments"]


def classify(
    source: Source | Run | SavedRun,
    *,
    landmarks: PathLike | None = None,
    labels: Literal["names", "icafe", "topcow"] | None = None,
    variant_prior: PathLike | None = None,
    unseen: float | None = None,
    arteries: PathLike | None = None,
    hypoplastic: str | float | None = None,
) -> Phenotype:
    """Classifies the Circle of Willis of vessels as they are, or of a run with probabilities: what ``willis classify`` does."""
    options = {"landmarks": landmarks, "labels": labels, "variant_prior": variant_prior, "unseen": unseen, "arteries": arteries}
    options["hypoplastic"] = hypoplastic
    made = words(options, {})
    with _with_folder(source) as given, warnings.catch_warnings():
        if isinstance(source, Run):
            # What is to be said of its input was said.
            warnings.simplefilter("ignore", Note)
        is_folder = isinstance(given, (str, os.PathLike)) and Path(given).is_dir()
        network = read_run(given) if is_folder else network_of(given)
        found = _willis.classify(network._scan, network._reading + made)
    for note in found.notes:
        say("note", note)
    return Phenotype(found)


@contextmanager
def _with_folder(source: Any) -> Iterator[Any]:
    """A run as its folder, which stands for so long; anything else as it is."""
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(source, Run):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", Note)
                source.save(Path(folder, "run"), dpi=36)
            source = Path(folder, "run")
        yield source.folder if isinstance(source, SavedRun) else source


@contextmanager
def _as_files(source: Any) -> Iterator[tuple[Any, list[str], Path]]:
    """A network or a run as its file or folder, with how it is read; anything else as it is; and a folder for what is made of it."""
    with tempfile.TemporaryDirectory() as folder, _with_folder(source) as given:
        yield (*(file_of(given, Path(folder)) if isinstance(given, Network) else (given, [])), Path(folder))


class Labelled:
    """Arteries of a Circle of Willis with their names."""

    def __init__(self, folder: Path) -> None:
        at = folder / "labelled.graphml"
        #: The vessels, divided where the name changes, with their labels.
        self.network: Network = read(at)
        #: A row for about every millimetre, with the probability of each name.
        self.names: Table = table_of(at.with_suffix(".names.csv"))
        #: Bifurcations and ends, with probabilities.
        self.landmarks: Table = table_of(at.with_suffix(".landmarks.csv"))
        #: The seven segments of the circle, with the probability that each is there.
        self.segments: Table = table_of(at.with_suffix(".segments.csv"))

    def __repr__(self) -> str:
        return f"<willis.Labelled: {len(self.landmarks['label'])} landmarks>"


def label(source: Source | Run | SavedRun, *, model: PathLike | None = None, **options: Any) -> Labelled:
    """Names the arteries of a network, a file or a run from their geometry alone: what ``willis label`` does; ``options`` are those of
    :func:`read`, where it is a file, and, but for boundary conditions, of :func:`candidates`.
    """
    with _as_files(source) as (given, reading, folder):
        made = reading + _label_words(model, options, isinstance(source, (str, os.PathLike)))
        if isinstance(source, Network) and "--observed" in source._reading:
            made.append("--observed")
        out = folder / "labelled.graphml"
        _willis.call(["label", os.fspath(given), "-o", str(out), *made], say)
        return Labelled(folder)


class Measured:
    """What is measured of vessels: a table each of vessels, bifurcations, ends, subjects, and of how far figures of the whole may lie apart."""

    def __init__(self, folder: Path) -> None:
        #: The columns of vessels.csv.
        self.vessels: Table = table_of(folder / "vessels.csv")
        #: The columns of bifurcations.csv.
        self.bifurcations: Table = table_of(folder / "bifurcations.csv")
        #: The columns of ends.csv.
        self.ends: Table = table_of(folder / "ends.csv")
        #: The columns of subjects.csv.
        self.subjects: Table = table_of(folder / "subjects.csv")
        #: The columns of intervals.csv; without rows where nothing is a run.
        self.intervals: Table = table_of(folder / "intervals.csv")
        compared = folder / "comparison.csv"
        #: The columns of comparison.csv; None without ``compare``.
        self.comparison: Table | None = table_of(compared) if compared.exists() else None
        agreed = folder / "readers.csv"
        #: The columns of readers.csv and of differences.csv; None without ``readers``.
        self.readers: Table | None = table_of(agreed) if agreed.exists() else None
        self.differences: Table | None = table_of(folder / "differences.csv") if agreed.exists() else None

    def __repr__(self) -> str:
        return f"<willis.Measured: {len(self.vessels['vessel'])} vessels, {len(self.bifurcations['degree'])} bifurcations>"


def measure(
    source: Source | Run | SavedRun | Sequence[PathLike],
    *,
    smoothing: str | float | None = None,
    inlets: Nodes | None = None,
    brain: PathLike | None = None,
    hypoplastic: str | float | None = None,
    participants: PathLike | None = None,
    compare: str | None = None,
    measures: Sequence[str] | None = None,
    seed: int = 0,
    readers: tuple[PathLike, PathLike] | None = None,
) -> Measured:
    """Measures the vessels of a network, of a run, or of many files: what ``willis measure`` does.

    ``smoothing`` is the length over which courses are smoothed before bends are measured, in mm; by default six radii of each vessel. ``brain`` is a
    mask in which densities are told, with ``{}`` for an input without its ending; ``hypoplastic`` the diameter below which a segment of the circle is
    thin, in mm.

    ``participants`` is a table with a row for each subject, ``compare`` the column of it that makes two groups, which then are compared in all
    ``measures``, columns of ``subjects``. ``readers`` are the decisions of two readers on the connections of runs, with ``{}`` for the input.
    """
    with _as_files(source) as (given, reading, folder):
        made = words(
            {
                "smoothing": smoothing,
                "inlet": Repeated(inlets),
                "brain": brain,
                "hypoplastic": hypoplastic,
                "participants": participants,
                "compare": compare,
                "measures": None if measures is None else ",".join(Repeated(measures).values),
                "seed": seed or None,
                "reader": Repeated(readers),
            },
            {},
        )
        _willis.call(["measure", *_inputs(given), "-o", str(folder / "measured"), *reading, *made], say)
        return Measured(folder / "measured")


class Cohort:
    """Many subjects: the folder that ``willis infer`` or ``willis label`` makes of several inputs."""

    def __init__(self, folder: Path, kept: tempfile.TemporaryDirectory[str] | None) -> None:
        self.folder, self._kept = folder, kept
        #: A row a subject, with the columns of cohort.csv.
        self.subjects: Table = table_of(folder / "cohort.csv")

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with a row a subject."""
        return self.subjects.to_pandas()

    def run(self, subject: str) -> SavedRun:
        """The run of a subject."""
        return SavedRun(self.folder / subject)

    def labelled(self, subject: str) -> Labelled:
        """The names of a subject, where :func:`label_cohort` made them."""
        return Labelled(self.folder / subject)

    def __len__(self) -> int:
        return len(self.subjects["subject"])

    def __repr__(self) -> str:
        return f"<willis.Cohort: {len(self)} subjects>"


def cohort(paths: Sequence[PathLike] | PathLike, output: PathLike | None = None, **options: Any) -> Cohort:
    """Infers the topology of many inputs: what ``willis infer`` does with several, a pattern (``"scans/*.swc"``) or a manifest.

    ``options`` are those of :func:`read` and :func:`infer`; in ``landmarks`` and the like, ``{}`` is an input without its ending. Without
    ``output``, the folder is a temporary one, which goes with what is returned. Inputs that fail are rows that say so, and a note.

    Raises
    ------
    WillisError
        Nothing was made: what is wrong, and what is accepted.
    """
    inputs = _inputs(paths)
    defaults = {**defaults_of(read), **defaults_of(infer)}
    _check_known("a cohort", "read and infer", options, defaults, {"background", "threads", "progress"})
    options |= conditions(*(options.pop(name, None) for name in ("inlets", "outlets", "flows")))
    return _made("infer", inputs, output, words(options, defaults))


def label_cohort(
    paths: Sequence[PathLike] | PathLike, output: PathLike | None = None, *, model: PathLike | None = None, **options: Any
) -> Cohort:
    """Names the arteries of many inputs: what ``willis label`` does with several, a pattern or a manifest; as :func:`cohort`, with the
    ``options`` of :func:`label`.
    """
    return _made("label", _inputs(paths), output, _label_words(model, options))


def _label_words(model: PathLike | None, options: dict[str, Any], is_file: bool = True) -> list[str]:
    defaults = {**(defaults_of(read) if is_file else {}), **defaults_of(candidates)}
    _check_known("label", "read and candidates" if is_file else "candidates", options, defaults, {"inlets", "outlets", "flows", "bc"})
    return words({"model": model, **options}, defaults)


def _check_known(of: str, others: str, options: dict[str, Any], known: dict[str, Any], but: set[str]) -> None:
    unknown = sorted(set(options) - set(known) | set(options) & but)
    if unknown:
        raise WillisError(f"{unknown[0]}: no option of {of}; expected those of {others}", item=unknown[0])


def _inputs(paths: Sequence[PathLike] | PathLike) -> list[str]:
    return [os.fspath(paths)] if isinstance(paths, (str, os.PathLike)) else [os.fspath(path) for path in paths]


def _made(command: str, inputs: list[str], output: PathLike | None, made: list[str]) -> Cohort:
    kept = tempfile.TemporaryDirectory() if output is None else None
    folder = Path(output) if output is not None else Path(kept.name if kept else "", "cohort")
    if len(inputs) == 1 and Path(inputs[0]).is_file() and not inputs[0].lower().endswith((".csv", ".tsv")):
        # A pattern that finds one file makes a cohort of one; a table may be a manifest.
        inputs = [f"{glob.escape(inputs[0][:-1])}[{inputs[0][-1]}]"]
    try:
        _willis.call([command, *inputs, "-o", str(folder), *made], say)
    except WillisError as error:
        if not (folder / "cohort.csv").exists():
            raise
        say("note", str(error))
    return Cohort(folder, kept)


def train(
    cases: Sequence[PathLike],
    output: PathLike,
    *,
    model: Literal["tracing", "skeleton", "contacts", "labels"] = "tracing",
    folds: int = 3,
    l2: float = 0.002,
    passes: int = 3,
    save_folds: bool = False,
    images_onto: PathLike | None = None,
    calibrate_onto: PathLike | None = None,
    calibrate_with: Sequence[PathLike] | None = None,
    force: bool = False,
) -> None:
    """Fits a model to cases whose true connections are known, and writes it: what ``willis train`` does."""
    onto = {"images_onto": images_onto, "calibrate_onto": calibrate_onto, "calibrate_with": Repeated(calibrate_with)}
    given = {"model": model, "folds": folds, "l2": l2, "passes": passes, "save_folds": save_folds, **onto, "force": force}
    _willis.call(["train", *[os.fspath(case) for case in cases], "-o", os.fspath(output), *words(given, defaults_of(train))], say)


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
    return _phantom(kind, words(given, {}))


def _phantom(kind: str, made: list[str]) -> Network:
    return Network(_willis.phantom(kind, made), (_phantom, (kind, made)))
