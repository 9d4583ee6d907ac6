"""A run under review: what a person decides on it, in order, and the verdicts on the circle. Viewers show it; it knows none of them."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import Note, WillisError
from ._following import PathLike
from ._run import Place, Run, now, places_of
from ._study import Labelled, label

SEGMENTS = ("L-A1", "R-A1", "AComm", "L-P1", "R-P1", "L-PComm", "R-PComm")
VERDICTS = ("present", "hypoplastic", "absent", "unsure")
_ON_ROWS = ("accept", "reject", "unsure")
_DECISIONS = "edge id_a id_b decision probability who when comment input_sha256 places".split()
_VERDICTS = "segment verdict probability who when comment input_sha256".split()


@dataclass(frozen=True)
class Made:
    """What was decided: on a row of the edges, or, with places, an edit; or the verdict on a segment."""

    word: str
    row: int | None = None
    places: str = ""
    who: str = ""
    when: str = ""
    comment: str = ""


class Review:
    """A run, and what a person says of it."""

    def __init__(self, run: Run, *, who: str = "", input_sha256: str | None = None) -> None:
        #: That of the file that the run's input was made of, where it is known.
        self.input_sha256 = input_sha256 or run._run.input_sha256()
        #: The run before anybody decided, and with the decisions.
        self.first, self.run, self.who = run, run, who
        #: The decisions in their order, and the verdict on each segment that has one.
        self.made: list[Made] = []
        self.verdicts: dict[str, Made] = {}
        #: Names of the vessels, once :meth:`name` has found them.
        self.named: Labelled | None = None
        self._before: list[tuple[list[Made], dict[str, Made]]] = []
        self._files: set[Path] = set()
        self.lines: list[npt.NDArray[np.float64]] = []
        self._follow([])

    @property
    def questions(self) -> list[int]:
        """The rows that a person is asked about, in order: those of the first run, then those that became doubtful by decisions."""
        asked = [run.review for run in (self.first, self.run)]
        rows = [int(row) for table in asked if table is not None for row in table["edge"]]
        return [row for row in dict.fromkeys(rows) if row < len(self.first.kept)]

    @property
    def open(self) -> list[int]:
        """The questions that have no decision, and that no other decision answered."""
        asked = set() if self.run.review is None else set(self.run.review["edge"].tolist())
        return [row for row in self.questions if row in asked and self.decided(row) is None]

    def decided(self, row: int) -> str | None:
        """What was decided on a row."""
        return next((made.word for made in self.made if made.row == row), None)

    def asks(self, row: int) -> str:
        """The question of a row in words."""
        if asked := self._question(row):
            chance = "" if np.isnan(asked["probability"]) else f"P {asked['probability']:.2f}, "
            return f"{asked['question']} {chance}{asked['hangs_mm']:.0f} mm hang on it"
        a, b = self.ids(row)
        return f"Does a vessel go on from {a} to {b}?"

    def place(self, row: int) -> npt.NDArray[np.float64]:
        """Where a row is in question, mm: the place of its question, else the middle of its line."""
        if asked := self._question(row):
            return np.array([asked[axis] for axis in ("x_mm", "y_mm", "z_mm")])
        line = self.lines[row]
        return np.asarray((line[(len(line) - 1) // 2] + line[len(line) // 2]) / 2)

    def _question(self, row: int) -> dict[str, Any] | None:
        """The line of review.csv about a row."""
        for table in (self.first.review, self.run.review):
            if table is not None and row in table["edge"]:
                at = int(np.flatnonzero(table["edge"] == row)[0])
                return {name: column[at] for name, column in table.items()}
        return None

    def beside(self, row: int) -> list[int]:
        """The other connections that leave the free ends of one."""
        edges = self.first.edges
        ends = np.stack([edges["node_a"], edges["node_b"]])
        observed = edges["origin"] == "observed"
        free = [end for end in ends[:, row] if (ends[:, observed] == end).sum() <= 1]
        return [int(other) for other in np.flatnonzero(np.isin(ends, free).any(axis=0) & ~observed) if other != row]

    def ids(self, row: int) -> tuple[str, str]:
        """The ids of the nodes of a row."""
        a, b = (str(self.first.nodes["id"][self.first.edges[end][row]]) for end in ("node_a", "node_b"))
        return a, b

    def decide(self, row: int, word: str, comment: str = "") -> None:
        """Accepts or rejects a connection, or is unsure of it, and lets the run follow."""
        if self.first.edges["origin"][row] == "observed":
            raise WillisError(f"edge {row}: an observed vessel; expected a candidate or a contact", item="edge", value=str(row))
        self._step([*(made for made in self.made if made.row != row), self._by(Made(word, row, comment=comment))])

    def edit(self, word: str, groups: Sequence[Sequence[Place]], comment: str = "") -> None:
        """Edits the graph: join and delete take one group of places, part takes several; the run follows."""
        made = Made(word, places=" | ".join(places_of(group) for group in groups), comment=comment)
        self._step([*self.made, self._by(made)])

    def judge(self, segment: str, verdict: str, comment: str = "") -> None:
        """The verdict of a person on a segment of the circle; an empty one takes it back."""
        _one_of("segment", segment, SEGMENTS)
        kept = {name: made for name, made in self.verdicts.items() if name != segment}
        if verdict:
            kept[segment] = self._by(Made(_one_of("verdict", verdict, VERDICTS), comment=comment))
        self._before.append((self.made, self.verdicts))
        self.verdicts = kept

    def undo(self) -> bool:
        """Takes the last step back; whether there was one."""
        if not self._before:
            return False
        made, self.verdicts = self._before.pop()
        if made != self.made:
            self._follow(made)
        return True

    def name(self) -> Labelled:
        """Names the vessels of the plausible topology from their geometry."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Note)
            self.named = label(self.run.topology)
        return self.named

    def found(self, segment: str) -> float:
        """The probability by the names that a segment is there; NaN before there are any, and where too little is seen to say."""
        if self.named is None:
            return float("nan")
        table = self.named.segments
        at = np.flatnonzero(table["segment"] == segment)
        return float("nan") if len(at) == 0 or table["not_seen"][at[0]] else float(table["probability"][at[0]])

    def _by(self, made: Made) -> Made:
        return replace(made, who=self.who, when=now())

    def _step(self, made: list[Made]) -> None:
        before = (self.made, self.verdicts)
        self._follow(made)
        self._before.append(before)

    def _follow(self, made: list[Made]) -> None:
        """The run with decisions; one that is refused changes nothing."""
        rows = {word: [one.row for one in made if one.word == word and one.row is not None] for word in _ON_ROWS}
        edits = [f"{one.word} {one.places}" for one in made if one.row is None]
        run = self.first
        if rows["accept"] or rows["reject"] or edits:
            run = Run(self.first._run.decide(rows["accept"], rows["reject"], edits, self.who, now()))
        self.run, self.made, self.lines = run, made, run.graph.lines()[1]

    def save(self, folder: PathLike, name: str) -> list[Path]:
        """Writes ``NAME-decisions.csv``, as the page of a run does, and ``NAME-verdicts.csv``; none that somebody else wrote is replaced."""
        decisions, verdicts = (Path(folder, f"{name}-{what}.csv") for what in ("decisions", "verdicts"))
        tables = [(path, head, rows) for path, head, rows in (
            (decisions, _DECISIONS, self._decision_rows() if self.made or decisions in self._files else None),
            (verdicts, _VERDICTS, self._verdict_rows() if self.verdicts or verdicts in self._files else None),
        ) if rows is not None]  # fmt: skip
        for path, _, _ in tables:
            if path.exists() and path not in self._files:
                expected = "another folder, or that it is loaded first"
                raise WillisError(f"{path}: it is there; expected {expected}", file=path, expected=expected)
        for path, head, rows in tables:
            _write(path, head, rows)
        self._files.update(path for path, _, _ in tables)
        return [path for path, _, _ in tables]

    def load(self, folder: PathLike, name: str) -> int:
        """Takes up what :meth:`save` or the page of a run wrote; how many decisions and verdicts. A fault in a file changes nothing."""
        decisions, verdicts = (Path(folder, f"{name}-{what}.csv") for what in ("decisions", "verdicts"))
        if not decisions.exists() and not verdicts.exists():
            raise WillisError(f"{decisions}: no such file, nor {verdicts.name}; expected one of them", file=decisions)
        listed = list(self._listed(decisions)) if decisions.exists() else []
        judged = dict(self._judged(verdicts)) if verdicts.exists() else {}
        before = (self.made, self.verdicts)
        self._follow(listed)
        self._before.append(before)
        self.verdicts = judged
        self._files.update(path for path in (decisions, verdicts) if path.exists())
        return len(listed) + len(judged)

    def _decision_rows(self) -> Iterator[list[Any]]:
        nodes = self.first.nodes
        at = np.column_stack([nodes[axis] for axis in ("x_mm", "y_mm", "z_mm")])
        on_rows = sorted((made for made in self.made if made.row is not None), key=lambda made: made.row or 0)
        for made in [*on_rows, *(made for made in self.made if made.row is None)]:
            cells: list[Any] = ["", "", "", made.word, ""]
            places = made.places
            if made.row is not None:
                probability = self.first.probability[made.row]
                cells = [made.row, *self.ids(made.row), made.word, "" if np.isnan(probability) else float(probability)]
                places = places_of(at[int(self.first.edges[end][made.row])] for end in ("node_a", "node_b"))
            yield [*cells, made.who, made.when, made.comment, self.input_sha256, places]

    def _verdict_rows(self) -> Iterator[list[Any]]:
        for segment in SEGMENTS:
            if made := self.verdicts.get(segment):
                found = self.found(segment)
                probability = "" if np.isnan(found) else found
                yield [segment, made.word, probability, made.who, made.when, made.comment, self.input_sha256]

    def _listed(self, path: Path) -> Iterator[Made]:
        for row, word, places, about in self.first._run.listed(path, self.input_sha256):
            yield Made(word, row, places, *about)

    def _judged(self, path: Path) -> Iterator[tuple[str, Made]]:
        for line, cells in self._rows(path, _VERDICTS[:2]):
            segment = _one_of("segment", cells["segment"], SEGMENTS, path, line)
            word = _one_of("verdict", cells["verdict"], VERDICTS, path, line)
            yield segment, Made(word, None, "", *(cells.get(name, "") for name in ("who", "when", "comment")))

    def _rows(self, path: Path, needed: Sequence[str]) -> Iterator[tuple[int, dict[str, str]]]:
        """The rows of a table by column, each with its line; one of another input is refused."""
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            for name in needed:
                if name not in (reader.fieldnames or ()):
                    expected = ",".join(needed)
                    raise WillisError(f"{path}:1: no column {name}; expected {expected}", file=path, line=1, expected=expected)
            for cells in reader:
                row = {name: re.sub(r"^'(?=[=+@\t-])", "", cell or "") for name, cell in cells.items() if name is not None}
                if row.get("input_sha256", "") not in ("", self.input_sha256):
                    expected = f"the input with SHA-256 {self.input_sha256}"
                    message = f"{path}:{reader.line_num}: decided on another input; expected {expected}"
                    raise WillisError(message, file=path, line=reader.line_num, expected=expected)
                yield reader.line_num, row


def _one_of(item: str, value: str, words: Sequence[str], path: Path | None = None, line: int | None = None) -> str:
    if value in words:
        return value
    expected, place = ", ".join(words), "" if path is None else f"{path}:{line}: "
    raise WillisError(f'{place}{item} "{value}"; expected one of {expected}', file=path, line=line, item=item, value=value, expected=expected)


def _write(path: Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """A table that appears whole; what a spreadsheet would take for a formula gets an apostrophe, as everywhere."""
    begun = path.with_name(f".{path.name}.begun")
    with begun.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        for row in rows:
            texts = (re.sub(r"[\r\n]+", " ", repr(cell) if isinstance(cell, float) else str(cell)) for cell in row)
            writer.writerow([re.sub(r"^(?=[=+@\t-])", "'", text) for text in texts])
    begun.replace(path)
