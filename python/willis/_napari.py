"""The panel in napari: a mask to its vessels, what is undecided as points in order, decisions by keys, and verdicts on the circle."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import WillisError, library
from ._network import Network, from_mask
from ._review import SEGMENTS, VERDICTS, Review
from ._run import infer

AXES = ("not known", "RAS", "LPS", "LAS", "SAR", "SPL", "SAL")
"""Where the three axes of napari's world point, the first one first: R is the patient's right, A anterior, S superior."""
KEYS = {
    "a": "accept",
    "r": "reject",
    "x": "unsure",
    "n": "go_on",
    "u": "undo",
    "g": "begin_group",
    "j": "join",
    "p": "part",
    "d": "delete",
}
_COLOURS = {"observed": "#7f9fc6", "joined": "#4fc17a", "asked": "#ff4b3e", "beside": "#ffa53a"}
_DECIDED = {"open": "#ffd60a", "accept": "#4fc17a", "reject": "#8e8e93", "unsure": "#bf7fff"}

Places = npt.NDArray[np.float64]
Job = Callable[[], Callable[[], None]]


def panel() -> Any:
    """The panel for the viewer that is open, as napari's menu of plugins asks for it."""
    return Desk(library("napari", "napari").current_viewer()).panel


class Grid:
    """Where the voxels of a layer lie: in napari's world, and for willis in mm."""

    def __init__(self, layer: Any, axes: str = AXES[0]) -> None:
        if layer.ndim != 3 or getattr(layer, "rgb", False):
            expected = "one of x, y and z alone"
            raise WillisError(f"layer {layer.name}: {layer.ndim} axes; expected {expected}", item="layer", expected=expected)
        corners = np.array([layer.data_to_world(corner) for corner in np.vstack([np.zeros(3), np.eye(3)])])
        world = np.eye(4)
        world[:3, :3], world[:3, 3] = (corners[1:] - corners[0]).T, corners[0]
        in_mm = [float((1 * unit).to("mm").magnitude) if unit.is_compatible_with("mm") else 1.0 for unit in layer.units]
        real = np.diag([*in_mm, 1.0]) @ world
        self.spacing = np.linalg.norm(real[:3, :3], axis=0)
        #: From voxels to right, anterior, superior in mm; None where it is not known which way the axes point.
        self.affine: Places | None = None if axes == AXES[0] else _turn(axes) @ real
        mm = np.diag([*self.spacing, 1.0]) if self.affine is None else self.affine
        self._to_world, self._to_mm = world @ np.linalg.inv(mm), mm @ np.linalg.inv(world)
        #: How long a mm is in the world, and the units of that.
        self.per_mm, self.units = 1 / in_mm[0], layer.units

    def to_world(self, places: npt.ArrayLike) -> Places:
        """Places of willis, mm, in napari's world."""
        return _moved(self._to_world, places)

    def to_mm(self, places: npt.ArrayLike) -> Places:
        """Places in napari's world for willis, mm."""
        return _moved(self._to_mm, places)


def _moved(by: Places, places: npt.ArrayLike) -> Places:
    moved: Places = np.asarray(places, dtype=float) @ by[:3, :3].T + by[:3, 3]
    return moved


def _turn(axes: str) -> Places:
    """From axes that point so to right, anterior, superior."""
    turn = np.eye(4)
    for column, letter in enumerate(axes):
        row = next(row for row, pair in enumerate(("RL", "AP", "SI")) if letter in pair)
        turn[:3, column] = np.eye(3)[row] * (1 if letter in "RAS" else -1)
    return turn


def network_of_layer(layer: Any, axes: str = AXES[0], level: float | None = None) -> Network:
    """The centerlines of a labels layer, or of an image from a level on."""
    is_labels = type(layer).__name__ == "Labels"
    if not is_labels and level is None:
        raise WillisError(f"layer {layer.name}: an image; expected a level, from which on it is vessel", item="level")
    grid, data = Grid(layer, axes), np.asarray(layer.data)
    given: dict[str, Any] = {"spacing": grid.spacing.tolist()} if grid.affine is None else {"affine": grid.affine}
    return from_mask(data, level=None if is_labels else level, **given)


class Desk:
    """The panel, the layers that it shows, and the review behind them."""

    def __init__(self, viewer: Any) -> None:
        widgets = library("magicgui.widgets", "napari")
        self.viewer, self.name, self.groups = viewer, "brain", [0]
        self.review: Review | None = None
        self.grid: Grid | None = None
        self.row: int | None = None
        self.layers: dict[str, Any] = {}
        self.said = widgets.Label(value="Choose a mask.")
        self.said.native.setWordWrap(True)
        self.mask = widgets.ComboBox(label="mask", choices=self._masks)
        self.axes = widgets.ComboBox(label="axes point", choices=AXES)
        self.level = widgets.LineEdit(label="level of an image")
        self.who = widgets.LineEdit(label="reader")
        self.comment = widgets.LineEdit(label="comment")
        self.folder = widgets.FileEdit(label="folder", mode="d", value=Path.cwd())
        self.verdicts = {name: widgets.ComboBox(label=name, choices=["", *VERDICTS]) for name in SEGMENTS}

        def row_of(*buttons: tuple[str, Callable[[], object]]) -> Any:
            made = [widgets.PushButton(text=text) for text, _ in buttons]
            for button, (_, press) in zip(made, buttons):
                button.changed.connect(lambda *_, press=press: self._try(press))
            return widgets.Container(widgets=made, layout="horizontal", labels=False)

        keyed = {name: (f"{name.replace('_', ' ')} ({key})", getattr(self, name)) for key, name in KEYS.items()}
        self.panel = widgets.Container(
            widgets=[
                *(self.mask, self.axes, self.level, self.who),
                row_of(("Skeleton", lambda: self._work(self.skeleton)), ("Infer", lambda: self._work(self.infer)), ("Names", lambda: self._work(self.name_vessels))),
                self.said,
                *(row_of(*(keyed[name] for name in names)) for names in (["accept", "reject", "unsure"], ["go_on", "undo"], ["join", "delete"], ["begin_group", "part"])),
                self.comment,
                *self.verdicts.values(),
                self.folder,
                row_of(("Load", self.load), ("Save", self.save), ("Save run", self.save_run)),
            ]
        )  # fmt: skip
        for segment, box in self.verdicts.items():
            box.changed.connect(lambda verdict, segment=segment: self._judge(segment, verdict))
        for event in (viewer.layers.events.inserted, viewer.layers.events.removed):
            event.connect(lambda *_: self.mask.reset_choices())
        self._bind(viewer)

    # What takes a while: each looks at the panel, and returns the work beside the window, which returns what to show then.

    def skeleton(self) -> Job:
        """The centerlines of the chosen layer."""
        layer, axes, level = self._given()

        def work() -> Callable[[], None]:
            grid, network = Grid(layer, axes), network_of_layer(layer, axes, level)
            return lambda: self._show_skeleton(grid, network)

        return work

    def infer(self) -> Job:
        """The plausible topology of the chosen layer."""
        layer, axes, level = self._given()

        def work() -> Callable[[], None]:
            grid, network = Grid(layer, axes), network_of_layer(layer, axes, level)
            path = Path(layer.source.path or "")
            sha256 = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
            review = Review(infer(network, progress=False), input_sha256=sha256)
            return lambda: self.show(grid, review, layer.name)

        return work

    def name_vessels(self) -> Job:
        """The names of the vessels, by their geometry."""
        review = self._reviewed()

        def work() -> Callable[[], None]:
            review.name()
            return self._show_names

        return work

    def _given(self) -> tuple[Any, str, float | None]:
        layer, text = self.mask.value, str(self.level.value)
        if layer is None:
            raise WillisError("mask: none; expected a layer of labels, or an image", item="mask")
        try:
            return layer, str(self.axes.value), float(text) if text else None
        except ValueError:
            raise WillisError(f'level "{text}"; expected a number', item="level", value=text) from None

    def show(self, grid: Grid, review: Review, name: str) -> None:
        """Shows a review in the viewer, and its first question."""
        self.grid, self.review, self.name, self.row = grid, review, name, None
        self._follow()
        self._put("places", self.viewer.add_points, np.empty((0, 3)), ndim=3, size=grid.per_mm, face_color="white", symbol="cross")
        self._put("questions", self.viewer.add_points, self._places_of(review.questions), size=2 * grid.per_mm, border_color="black", **self._marks(), out_of_slice_display=True)  # fmt: skip
        for layer in ("places", "questions"):
            self._bind(self.layers[layer])
        self.layers["places"].events.data.connect(self._group_places)
        self.layers["questions"].selected_data.events.items_changed.connect(lambda *_: self._chosen())
        self.go_on()

    # What a person does.

    def accept(self) -> None:
        """Accepts the connection in question, and goes on."""
        self._decide("accept")

    def reject(self) -> None:
        """Rejects it, and goes on."""
        self._decide("reject")

    def unsure(self) -> None:
        """Says that the reader does not know, and goes on."""
        self._decide("unsure")

    def go_on(self) -> None:
        """Goes to the next open question after this one, in their order."""
        review = self._reviewed()
        order, openly = review.questions, set(review.open)
        begin = order.index(self.row) + 1 if self.row in order else 0
        self.go_to(next((row for row in order[begin:] + order[:begin] if row in openly), None))

    def go_to(self, row: int | None) -> None:
        """Turns the slices to where a connection is in question."""
        self.row = row
        if row is not None:
            place = self._places_of([row])[0]
            self.viewer.dims.set_point(range(3), place)
            self.viewer.camera.center = tuple(place)
        self._follow()

    def undo(self) -> None:
        """Takes the last step back."""
        review = self._reviewed()
        before = review.made
        if review.undo():
            gone = next((made.row for made in before if made not in review.made), None)
            self.go_to(self.row if gone is None else gone)

    def begin_group(self) -> None:
        """The places from here on are another group, for a part."""
        self.groups.append(len(self.layers["places"].data))

    def join(self) -> None:
        """Joins the two places that were marked."""
        self._edit("join")

    def part(self) -> None:
        """Parts the vessels of the groups that were marked."""
        self._edit("part")

    def delete(self) -> None:
        """Deletes the vessel at the place that was marked."""
        self._edit("delete")

    def save(self) -> None:
        """Saves decisions and verdicts into the folder, by the name of the mask."""
        paths = self._reviewed().save(self.folder.value, self.name)
        self.said.value = "Saved " + (" and ".join(path.name for path in paths) or "nothing: there is no decision and no verdict") + "."

    def save_run(self) -> None:
        """Saves the run with its decisions: the folder of ``willis infer``."""
        self._reviewed().run.save(Path(self.folder.value, self.name))
        self.said.value = f"Saved the folder {self.name}."

    def load(self) -> None:
        """Takes up decisions and verdicts that were saved before."""
        count = self._reviewed().load(self.folder.value, self.name)
        self.go_on()
        self.said.value = f"Loaded {count} decisions and verdicts. {self.said.value}"

    def _decide(self, word: str) -> None:
        if self.row is None:
            raise WillisError("decision: no connection is chosen; expected a question", item="decision")
        self._reviewed().decide(self.row, word, str(self.comment.value))
        self.comment.value = ""
        self.go_on()

    def _edit(self, word: str) -> None:
        marked = self._reviewed_grid().to_mm(self.layers["places"].data)
        groups = np.split(marked, [at for at in self.groups[1:] if 0 < at < len(marked)])
        self._reviewed().edit(word, [group.tolist() for group in groups], str(self.comment.value))
        self.comment.value = ""
        self.layers["places"].data = np.empty((0, 3))
        self._follow()

    def _judge(self, segment: str, verdict: str) -> None:
        if self.review is not None and self._verdict(segment) != verdict:
            self._reviewed().judge(segment, verdict, str(self.comment.value))
            self.comment.value = ""

    def _verdict(self, segment: str) -> str:
        verdicts = self._reviewed().verdicts
        return verdicts[segment].word if segment in verdicts else ""

    def _chosen(self) -> None:
        chosen = list(self.layers["questions"].selected_data)
        rows = self._reviewed().questions
        if len(chosen) == 1 and chosen[0] < len(rows) and rows[chosen[0]] != self.row:
            self.go_to(rows[chosen[0]])

    def _group_places(self, *_: object) -> None:
        if len(self.layers["places"].data) == 0:
            self.groups = [0]

    # What is shown.

    def _follow(self) -> None:
        """Draws what the decisions made of the run, the connection in question, and what is left."""
        review = self._reviewed()
        origin = review.run.edges["origin"]
        drawn = [(row, "observed" if origin[row] == "observed" else "joined") for row in np.flatnonzero(review.run.kept)]
        self._draw("vessels", [(review.lines[row], state) for row, state in drawn], 0.4)
        asked = [] if self.row is None else [(self.row, "asked"), *((row, "beside") for row in review.beside(self.row))]
        self._draw("connection", [(review.lines[row], state) for row, state in reversed(asked)], 0.8)
        if "questions" in self.layers:
            layer, marks = self.layers["questions"], self._marks()
            if len(layer.data) != len(review.questions):
                layer.data = self._places_of(review.questions)
            layer.features, layer.face_color = marks["features"], marks["face_color"]
            layer.text = marks["text"]
            layer.selected_data = set() if self.row not in review.questions else {review.questions.index(self.row)}
        for segment, box in self.verdicts.items():
            box.value = self._verdict(segment)
        left = f"{len(review.open)} of {len(review.questions)} open."
        self.said.value = left if self.row is None else f"{left} {review.asks(self.row)}"

    def _show_skeleton(self, grid: Grid, network: Network) -> None:
        self.grid = grid
        self._draw("skeleton", [(line, "observed") for line in network.lines()[1]], 0.4)
        self.said.value = f"{network.n_edges} vessels, {network.n_nodes} nodes."

    def _show_names(self) -> None:
        review, grid = self._reviewed(), self._reviewed_grid()
        assert review.named is not None
        names, lines = review.named.network.edges["label"], review.named.network.lines()[1]
        longest: dict[str, Places] = {}
        for name, line in zip(names.tolist(), lines):
            if name and len(line) > len(longest.get(name, ())):
                longest[name] = line
        places = grid.to_world([line[len(line) // 2] for line in longest.values()]) if longest else np.empty((0, 3))
        features = {"name": list(longest)}
        self._put("names", self.viewer.add_points, places, ndim=3, features=features, size=grid.per_mm, face_color="white", text={"string": "{name}", "color": "white", "size": 10, "translation": [0, 0, 2 * grid.per_mm]}, out_of_slice_display=True)  # fmt: skip
        for segment, box in self.verdicts.items():
            found = review.found(segment)
            box.label = segment if np.isnan(found) else f"{segment}, P {found:.2f}"
        self.viewer.layers.selection.active = self.layers.get("questions")
        self.said.value = f"{len(longest)} arteries have names."

    def _draw(self, name: str, lines: list[tuple[Places, str]], width: float) -> None:
        """Lines as a layer of short arrows without heads, which slices and three dimensions show alike."""
        grid = self._reviewed_grid()
        steps, states = [np.empty((0, 2, 3))], []
        for line, state in lines:
            world = grid.to_world(line)
            steps.append(np.stack([world[:-1], np.diff(world, axis=0)], axis=1))
            states += [state] * (len(world) - 1)
        data, colours = np.concatenate(steps), [_COLOURS[state] for state in states] or "white"
        active = self.viewer.layers.selection.active
        self._put(name, self.viewer.add_vectors, data, ndim=3, features={"state": states}, edge_color=colours, edge_width=width * grid.per_mm, vector_style="line", out_of_slice_display=True)  # fmt: skip
        if active in self.viewer.layers:
            self.viewer.layers.selection.active = active

    def _places_of(self, rows: list[int]) -> Places:
        places = [self._reviewed().place(row) for row in rows]
        return self._reviewed_grid().to_world(places) if places else np.empty((0, 3))

    def _marks(self) -> dict[str, Any]:
        review = self._reviewed()
        words = [review.decided(row) or "open" for row in review.questions]
        features = {"rank": [str(rank) for rank in range(1, len(words) + 1)], "edge": review.questions, "decision": words}
        beside = [0.0, *np.full(2, 1.5 * self._reviewed_grid().per_mm)]
        text = {"string": "{rank}", "color": "white", "size": 10, "translation": beside}
        return {"features": features, "face_color": [_DECIDED[word] for word in words] or "white", "text": text}

    def _put(self, name: str, add: Callable[..., Any], data: Places, **options: Any) -> None:
        """A layer in the place of the one that this panel showed under the name before."""
        layers = self.viewer.layers
        at = layers.index(self.layers[name]) if self.layers.get(name) in layers else None
        if at is not None:
            options["visible"] = self.layers[name].visible
            layers.remove(self.layers[name])
        self.layers[name] = add(data, name=name, units=self._reviewed_grid().units, **options)
        if at is not None:
            layers.move(len(layers) - 1, at)

    def _masks(self, *_: object) -> list[Any]:
        return [layer for layer in self.viewer.layers if type(layer).__name__ in ("Labels", "Image")]

    def _bind(self, keyed: Any) -> None:
        for key, name in KEYS.items():
            keyed.bind_key(key, lambda *_, name=name: self._try(getattr(self, name)), overwrite=True)

    def _reviewed(self) -> Review:
        if self.review is None:
            raise WillisError("review: nothing is inferred yet; expected that Infer was pressed", item="review")
        self.review.who = self.who.value
        return self.review

    def _reviewed_grid(self) -> Grid:
        if self.grid is None:
            raise WillisError("review: nothing is drawn yet; expected that Infer was pressed", item="review")
        return self.grid

    def _try(self, act: Callable[[], object]) -> None:
        """Does something, and says what is wrong with it; then nothing has changed."""
        try:
            act()
        except (WillisError, OSError) as error:
            self.said.value = str(error)

    def _work(self, act: Callable[[], Job]) -> None:
        """Does something beside the window, and then shows it, or says what is wrong with it."""
        work = act()

        def safely() -> Callable[[], None]:
            try:
                return work()
            except (WillisError, OSError) as error:
                said = str(error)
                return lambda: setattr(self.said, "value", said)

        worker = library("napari.qt.threading", "napari").create_worker(safely, _start_thread=False)
        worker.returned.connect(lambda show: self._try(show))
        self.said.value, self.worker = "At work.", worker
        worker.start()
