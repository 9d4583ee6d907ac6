"""Vessels as Python holds them, and where they come from and go to."""

from __future__ import annotations

import inspect
import io
import re
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, Union
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

from . import _willis
from ._errors import Note, WillisError, library
from ._following import PathLike, say
from ._words import words

Reals = npt.NDArray[np.float64]
Recipe = tuple[Callable[..., "Network"], tuple[Any, ...]]


class Table(dict[str, npt.NDArray[Any]]):
    """Columns by name, as NumPy arrays of one length."""

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` of the same columns."""
        pd = library("pandas", "graph")
        return pd.DataFrame(dict(self))


class Network:
    """Vessels: those of a file, of arrays, or of a topology.

    Made by :func:`read`, :func:`centerlines` and the like; not by itself.
    """

    def __init__(self, scan: _willis.Scan, made: Recipe, reading: Sequence[str] = ()) -> None:
        self._scan, self._made, self._reading = scan, made, list(reading)
        # Of the file that it was read from.
        self._stamp = (0, 0)

    @property
    def nodes(self) -> Table:
        """The nodes as arrays by column, with the names and units of nodes.csv."""
        return Table(self._scan.tables()[0])

    @property
    def edges(self) -> Table:
        """The vessels as arrays by column, with the names and units of edges.csv."""
        return Table(self._scan.tables()[1])

    @property
    def n_nodes(self) -> int:
        """How many nodes there are."""
        return self._scan.node_count

    @property
    def n_edges(self) -> int:
        """How many vessels there are."""
        return self._scan.vessel_count

    def lines(self) -> tuple[npt.NDArray[np.int64], list[Reals], list[Reals]]:
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
            _willis.write(self._scan, path, None, None, False)
            with np.load(path) as arrays:
                return Table({name: arrays[name] for name in arrays.files})

    def to_networkx(self) -> Any:
        """A ``networkx.MultiGraph`` whose nodes and edges have the columns as attributes; nodes are rows. Edges have their course as ``points``,
        as GraphML has it: ``x y z r;x y z r`` in mm.
        """
        nx = library("networkx", "graph")
        graph = nx.MultiGraph()
        nodes, edges = self._attributes()
        for row in range(self.n_nodes):
            graph.add_node(row, **{name: values[row] for name, values in nodes.items()})
        for row, (a, b) in enumerate(self.lines()[0].tolist()):
            graph.add_edge(a, b, key=row, **{name: values[row] for name, values in edges.items()})
        return graph

    def to_igraph(self) -> Any:
        """An ``igraph.Graph`` whose vertices and edges have the columns as attributes, and edges ``points`` as those of :meth:`to_networkx`;
        vertices are rows.
        """
        import igraph

        vertices, edges = self._attributes()
        return igraph.Graph(self.n_nodes, self.lines()[0].tolist(), vertex_attrs=vertices, edge_attrs=edges)

    def _attributes(self) -> list[dict[str, list[Any]]]:
        """The columns of the nodes and of the vessels, and the courses of those whose points are more than their nodes."""
        nodes, edges = ({name: values.tolist() for name, values in table.items()} for table in (self.nodes, self.edges))
        _, points, radii = self.lines()
        has_course = [len(line) > 2 or radius[0] != radius[-1] for line, radius in zip(points, radii)]
        courses = [np.column_stack(course).tolist() if has else [] for has, *course in zip(has_course, points, radii)]
        if any(courses):
            edges["points"] = [";".join(" ".join(map(repr, point)) for point in course) for course in courses]
        return [nodes, edges]

    def to_vtk(self) -> Any:
        """A ``vtkPolyData`` as the file that :meth:`save` writes holds it: a line a vessel, ``MaximumInscribedSphereRadius`` at its points,
        mm, and the columns. Ids of nodes, and nodes that only join two vessels, have no place in it.
        """
        vtk = library("vtkmodules.vtkIOXML", "view")
        with self._as_file("network.vtp", "ignore") as path:
            reader = vtk.vtkXMLPolyDataReader()
            reader.SetFileName(str(path))
            reader.Update()
            return reader.GetOutput()

    def to_navis(self) -> Any:
        """A ``navis.TreeNeuron``, mm, with a root a connected part; connections that close loops are left out, with a note."""
        import navis

        with self._as_file("network.swc") as path:
            return navis.read_swc(path.read_text(encoding="utf-8"), units="mm", name=self._scan.name or "network")

    def to_skan(self) -> Any:
        """A ``skan.csr.PathGraph`` of all points, in mm, with the radii as values; it takes what ``skan.Skeleton`` takes."""
        sparse, skan = library("scipy.sparse", "graph"), library("skan.csr", "image")
        points, radii, edges = self._joined()
        length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
        # Points that lie on each other are as near as numbers allow: a length of zero would be no connection.
        weights = np.maximum(np.tile(length, 2), np.finfo(float).tiny)
        adjacency = sparse.coo_array((weights, (rows, columns)), shape=(len(points), len(points))).tocsr()
        return skan.PathGraph.from_graph(adj=adjacency, node_coordinates=points, node_values=radii)

    def _joined(self) -> tuple[Reals, Reals, npt.NDArray[np.int64]]:
        """All points once, the nodes first, their radii, and the rows that are joined."""
        ends, lines, thickness = self.lines()
        points: list[Reals] = [np.full((self.n_nodes, 3), np.nan)]
        radii: list[Reals] = [np.zeros(self.n_nodes)]
        joined = []
        first = self.n_nodes
        for (a, b), line, radius in zip(ends, lines, thickness):
            points[0][[a, b]] = line[[0, -1]]
            radii[0][[a, b]] = np.maximum(radii[0][[a, b]], radius[[0, -1]])
            inner = len(line) - 2
            row = np.concatenate([[a], np.arange(first, first + inner), [b]])
            joined.append(np.column_stack([row[:-1], row[1:]]))
            points.append(line[1:-1])
            radii.append(radius[1:-1])
            first += inner
        edges = np.concatenate(joined) if joined else np.empty((0, 2), dtype=np.int64)
        return np.concatenate(points), np.concatenate(radii), edges.astype(np.int64)

    @contextmanager
    def _as_file(self, name: str, notes: Literal["ignore", "default"] = "default") -> Iterator[Path]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, name)
            with warnings.catch_warnings():
                if notes == "ignore":
                    warnings.simplefilter("ignore", Note)
                self.save(path)
            yield path

    def save(
        self, path: PathLike, *, to: str | None = None, unfed: Literal["drop", "keep"] | None = None, force: bool = False
    ) -> None:
        """Writes a file; its ending says the format, as for ``willis convert``, unless ``to`` does. ``unfed`` says whether vessels that no
        inlet feeds are left out; by default they are for svzerod and openbf.
        """
        for note in _willis.write(self._scan, Path(path), to, unfed, force):
            warnings.warn(note, Note, stacklevel=3)

    def __repr__(self) -> str:
        name = f" of {self._scan.name}" if self._scan.name else ""
        return f"<willis.Network{name}: {self.n_nodes} nodes, {self.n_edges} vessels>"



    def __reduce__(self) -> Recipe:
        """It pickles as how it was made: a file by its path, arrays by their bytes, what a run found by the run."""
        return self._made


Source = Union[Network, PathLike]
_Axes = Union[Literal["RAS"], Literal["LPS"]]


def read(
    path: PathLike,
    *,
    units: Literal["mm", "um", "cm", "m", "voxel"] = "mm",
    spacing: float | Sequence[float] | Literal["auto"] | None = None,
    radius_array: str | None = None,
    radius: Literal["mean", "effective"] = "mean",
    default_radius: float | str | None = None,
    loops: PathLike | None = None,
    observed: bool = False,
    level: float | None = None,
    radius_from: Literal["area", "distance", "inscribed"] = "area",
    cavities: Literal["fill", "keep"] = "fill",
    box: Sequence[float] | None = None,
    frame: _Axes | None = None,
    max_input: int | str = "2GiB",
) -> Network:
    """Reads centerlines, a mask or a graph in any format that the command reads, or the folder of a run.

    The options are those of ``willis infer``; lengths are in mm, unless they say otherwise (``"500um"``). ``spacing="auto"`` is the one
    that iCafe's Image_info.txt beside the file, or a mask itself, states.

    Raises
    ------
    WillisError
        With file, line or item, value, and what is accepted.
    """
    given = {name: value for name, value in locals().items() if name != "path"}
    return _read(Path(path).absolute(), Path(path), words(given, defaults_of(read)))


def _stamp(place: Path) -> tuple[int, int]:
    """When a file was written last, and its size: another one, or a changed one, has others."""
    found = place.stat() if place.exists() else None
    return (found.st_mtime_ns, found.st_size) if found else (0, 0)


def _read(place: Path, name: Path, reading: list[str], run: bool = False) -> Network:
    stamp = _stamp(place)
    # By the name that was given, unless that leads elsewhere by now.
    scan = _willis.read(name if name.absolute() == place else place, reading, run)
    network = Network(scan, (_read, (place, name, reading, run)), reading)
    network._stamp = stamp
    _tell_of(network)
    return network


def read_run(folder: PathLike) -> Network:
    """The over-connected graph of a run in a folder, which knows what was found by sampling it."""
    return _read(Path(folder).absolute(), Path(folder), [], run=True)


def read_packed(name: str, packed: bytes, reading: list[str]) -> Network:
    """Reads the bytes of a file that would be called so."""
    network = Network(_willis.read_bytes(name, packed, reading), (read_packed, (name, packed, reading)), reading)
    _tell_of(network)
    return network


def file_of(network: Network, folder: Path) -> tuple[Path, list[str]]:
    """The file that a network was read from, if it is as it was, which may say by its lines where blood enters, and how; else a new one in a folder."""
    made, of = network._made
    if "--observed" not in network._reading:
        if made is _read and of[0].is_file() and network._stamp == _stamp(of[0]):
            return of[0], network._reading
        if made is read_packed:
            (folder / of[0]).write_bytes(of[1])
            return folder / of[0], network._reading
    network.save(folder / "network.graphml")
    return folder / "network.graphml", []


def defaults_of(function: Callable[..., Any]) -> dict[str, Any]:
    parameters = inspect.signature(function).parameters.items()
    return {name: one.default for name, one in parameters if one.default is not inspect.Parameter.empty}


def _tell_of(network: Network) -> None:
    for heading, fact in network._scan.said():
        say(heading, fact)


def numbers(name: str, values: npt.ArrayLike, kinds: str = "biufO") -> npt.NDArray[Any]:
    """An array of numbers of these kinds: none that NumPy would make of a date, of text or of half a complex number, and none that is masked."""
    expected = "numbers or text" if "U" in kinds else "numbers" if "f" in kinds else "whole numbers"
    try:
        array = np.asarray(values)
        if array.dtype == object and "O" in kinds:
            array = array.astype(np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise WillisError(f"{name}: {error}; expected {expected}".replace("\n", " "), item=name, expected=expected) from None
    if array.dtype.kind not in kinds:
        found = "Python objects" if array.dtype == object else f"values of type {array.dtype}"
        raise WillisError(f"{name}: {found}; expected {expected}", item=name, expected=expected)
    if isinstance(values, np.ma.MaskedArray) and np.ma.getmaskarray(values).any():
        expected = "an array without, as filled() gives it"
        raise WillisError(f"{name}: masked values; expected {expected}", item=name, expected=expected)
    return array


def place(name: str, value: npt.ArrayLike) -> npt.NDArray[Any]:
    """Three numbers of mm."""
    array = numbers(name, value, "iufO")
    if array.shape != (3,):
        expected = "three numbers of mm"
        raise WillisError(f"{name}: an array of shape {array.shape}; expected {expected}", item=name, expected=expected)
    return array


def _check_size(name: str, arrays: Iterable[npt.NDArray[Any]], max_input: int | str = "2GiB") -> None:
    """Refuses arrays that are larger than a file may be before they are packed as one. A size that is none is refused later."""
    most = _willis.byte_count(str(max_input))
    size = sum(array.nbytes for array in arrays)
    if most is not None and size > most:
        expected = f"at most {most} bytes"
        raise WillisError(f"{name}: {size} bytes; expected {expected}; max_input= allows more", item=name, expected=expected)


def centerlines(
    points: npt.ArrayLike,
    edges: npt.ArrayLike,
    radii: npt.ArrayLike,
    *,
    labels: npt.ArrayLike | None = None,
    lengths: npt.ArrayLike | None = None,
    frame: _Axes | None = None,
) -> Network:
    """Centerlines of arrays: points (N, 3) and their radii (N), mm, and edges (M, 2), rows of the points.

    ``radii`` (M) with ``lengths`` (M) are those of the edges, each of which is one vessel then. ``labels`` (M) name the edges, ``labels``
    (N) the points; ``frame`` says which way the axes point. The same as reading the NPZ of these arrays.
    """
    arrays: dict[str, Any] = {"coords": numbers("points", points), "edges": numbers("edges", edges if np.size(edges) else np.empty((0, 2), dtype=np.int64), "biu"), "radii": numbers("radii", radii)}
    if labels is not None:
        arrays["labels"] = numbers("labels", labels, "biufSU")
    if lengths is not None:
        arrays["lengths"] = numbers("lengths", lengths)
    _check_size("arrays", arrays.values())
    for name in {"coords", "radii", "lengths"} & set(arrays):
        arrays[name] = np.asarray(arrays[name], dtype=np.float64)
    packed = io.BytesIO()
    np.savez(packed, **arrays)
    try:
        return read_packed("arrays.npz", packed.getvalue(), words({"frame": frame}, {}))
    except WillisError as error:
        # Where there is no file, its arrays are arguments.
        message, item = (re.sub(r"\barray ", "", text).replace("coords", "points") for text in (str(error), error.item or ""))
        message = message.removeprefix("arrays.npz: ")
        raise WillisError(message, item=item or None, value=error.value, expected=error.expected) from None


def from_networkx(graph: Any, *, observed: bool = False, frame: _Axes | None = None) -> Network:
    """The vessels of a ``networkx`` graph, by the attributes that its GraphML would have.

    Nodes have a position: ``x_mm y_mm z_mm``, ``x y z`` or ``pos``, mm. Edges have ``radius_mm`` and ``length_mm``, and may have ``label``,
    ``origin``, ``prior``, ``certain`` and whatever else the page on inputs names. It is a ready candidate graph, as a file of
    GraphML is; with ``observed``, its edges are what was seen, and candidates are built between them. What other attributes there are is
    left out. Of a directed graph it is ``graph.to_undirected()``, with a note.
    """
    if graph.is_directed():
        warnings.warn("the graph is directed: its edges are taken as undirected, those in both directions as one vessel", Note, stacklevel=2)
        graph = graph.to_undirected(as_view=True)
    nodes = [(node, _plain(values)) for node, values in graph.nodes(data=True)]
    edges = [(a, b, _plain(values)) for a, b, values in graph.edges(data=True)]
    if all(isinstance(values.get("edge"), int) for *_, values in edges):
        edges.sort(key=lambda edge: edge[2]["edge"])
    ids = {node: str(values.get("id", node)) for node, values in nodes}
    if len(set(ids.values())) < len(ids):
        ids = {node: str(node) for node, _ in nodes}
    root = ElementTree.Element("graphml", xmlns="http://graphml.graphdrawing.org/xmlns")
    drawn = ElementTree.Element("graph", edgedefault="undirected")
    keys: dict[tuple[str, str], str] = {}

    def add(kind: str, values: dict[str, Any], **attributes: str) -> None:
        element = ElementTree.SubElement(drawn, kind, attributes)
        for name, value in values.items():
            key = keys.setdefault((kind, name), f"{kind}{len(keys)}")
            ElementTree.SubElement(element, "data", key=key).text = repr(value) if isinstance(value, float) else str(value)

    for node, values in nodes:
        add("node", values, id=ids[node])
    for a, b, values in edges:
        add("edge", values, source=ids[a], target=ids[b])
    for (kind, name), key in keys.items():
        given = [one[-1][name] for one in (nodes if kind == "node" else edges) if name in one[-1]]
        number = "double" if all(isinstance(value, (int, float)) for value in given) else "string"
        ElementTree.SubElement(root, "key", {"id": key, "for": kind, "attr.name": name, "attr.type": number})
    root.append(drawn)
    return read_packed("graph.graphml", ElementTree.tostring(root), words({"observed": observed, "frame": frame}, defaults_of(from_networkx)))


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes that are numbers or text; a position becomes three, and what is not known is left out."""
    out: dict[str, Any] = {}
    for name, value in values.items():
        value = value.item() if isinstance(value, np.generic) else value
        if name == "pos" and not isinstance(value, str):
            if value is not None:
                out.update(zip(("x_mm", "y_mm", "z_mm"), map(float, place("pos", value))))
        elif isinstance(value, (bool, int, float, str)) and value == value and value != "":
            out[str(name)] = int(value) if isinstance(value, bool) else value
    return out


def from_skan(skeleton: Any, radii: npt.ArrayLike | None = None, *, frame: _Axes | None = None) -> Network:
    """Centerlines of a ``skan.Skeleton`` in three dimensions, whose spacing is in mm.

    ``radii`` (N), mm, are those of ``skeleton.coordinates``; without them, the values of the skeleton's image are the radii, as where it
    was multiplied by the distance transform of the mask.
    """
    points = np.asarray(skeleton.coordinates, dtype=np.float64) * np.asarray(skeleton.spacing, dtype=np.float64)
    values = skeleton.pixel_values if radii is None else radii
    if radii is None and (values is None or np.asarray(values).dtype == bool):
        raise WillisError("radii: the skeleton's image has no values; expected the radius of each point", item="radii")
    paths = skeleton.paths.tocsr()
    rows = np.split(paths.indices, paths.indptr[1:-1])
    edges = [np.column_stack([row[:-1], row[1:]]) for row in rows]
    pairs = np.concatenate(edges) if edges else np.empty((0, 2), dtype=np.int64)
    return centerlines(points, pairs, np.asarray(values), frame=frame)


def from_vtk(
    polydata: Any, *, radius_array: str | None = None, default_radius: float | str | None = None, frame: _Axes | None = None
) -> Network:
    """Centerlines of a ``vtkPolyData``, whose lines are in mm; as reading the VTK file of it.

    ``radius_array`` is the point array that holds the radii, when it has an unusual name; ``default_radius`` is for lines without any.
    """
    # The writer of VTP does not escape the names of arrays.
    writer = library("vtkmodules.vtkIOLegacy", "view").vtkPolyDataWriter()
    writer.SetInputData(polydata)
    writer.SetFileTypeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    packed = writer.GetOutputStdString()
    return read_packed("lines.vtk", packed, words({"radius_array": radius_array, "default_radius": default_radius, "frame": frame}, {}))


def from_mask(
    mask: npt.ArrayLike,
    *,
    spacing: float | Sequence[float] | None = None,
    affine: npt.ArrayLike | None = None,
    frame: _Axes | None = None,
    level: float | None = None,
    radius_from: Literal["area", "distance", "inscribed"] = "area",
    cavities: Literal["fill", "keep"] = "fill",
    max_input: int | str = "2GiB",
) -> Network:
    """Centerlines of a segmentation: an array of x, y, z, where 0 is background and other whole numbers are classes.

    ``affine`` (4, 4) is that of nibabel, from voxels to the scanner's frame in mm. Without it ``spacing`` is the size of a voxel in mm,
    along each axis, and ``frame`` says which way the axes point; without that too, left and right are not known. ``level`` takes
    probabilities, in which what is at least as large is inside.
    """
    given = {name: value for name, value in locals().items() if name not in ("mask", "affine")}
    if (affine is None) == (spacing is None):
        accepted = "spacing, or affine"
        raise WillisError(f"mask: {'no frame' if affine is None else 'two'}; expected {accepted}", item="mask", expected=accepted)
    array = numbers("mask", mask, "biuf")
    _check_size("mask", [array], max_input)
    if array.dtype == bool:
        array = array.view(np.uint8) if array.flags.c_contiguous else array.astype(np.uint8)
    packed = io.BytesIO()
    name = "mask.npy"
    if affine is None:
        np.save(packed, array, allow_pickle=False)
    else:
        name = "mask.npz"
        np.savez(packed, mask=array, affine=np.asarray(numbers("affine", affine, "biuf"), dtype=float))
    return read_packed(name, packed.getvalue(), words(given, defaults_of(from_mask)))


def network_of(source: Source) -> Network:
    return source if isinstance(source, Network) else read(source)


