"""The flow in a network: with changes beside it, and with resistances that vary at random."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from . import _willis
from ._errors import Note, WillisError
from ._following import PathLike, Progress, followed, say, threads_of
from ._network import Source, Table, defaults_of, network_of, numbers
from ._words import Nodes, Repeated, conditions, text, whole, words


class Simulation:
    """The flow in a network as it is, and beside it with its changes."""

    def __init__(self, simulation: _willis.Simulation) -> None:
        self._simulation = simulation
        self.nodes: Table
        self.edges: Table
        self.nodes, self.edges = map(Table, simulation.tables())
        transport = simulation.transport()
        #: Who feeds what, with the columns of territories.csv; None without ``transport``.
        self.territories: Table | None = None if transport is None else Table(transport[0])
        #: When blood arrives, with the columns of transit.csv; None without ``transport``.
        self.transit: Table | None = None if transport is None else Table(transport[1])
        occlusions = simulation.occlusions()
        #: What each closed vessel does, with the columns of occlusions.csv; None without ``occlude_each``.
        self.occlusions: Table | None = None if occlusions is None else Table(occlusions)
        waveforms = simulation.waveforms()
        #: Pressures and flows over a cycle, the arrays of waveforms.npz (vessels, times) and ``time_s``; None without ``pulse``.
        self.waveforms: Table | None = None if waveforms is None else Table(waveforms)

    def save(self, folder: PathLike, *, force: bool = False, dpi: int = 150) -> None:
        """Writes the folder that ``willis simulate`` writes."""
        for note in self._simulation.save(Path(folder), force, whole("dpi", dpi)):
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
    inlets: Nodes | None = None,
    outlets: str | Nodes | None = None,
    flows: Nodes | None = None,
    bc: PathLike | None = None,
    transport: bool = False,
    occlude_each: bool = False,
    pulse: bool | PathLike | Mapping[str, PathLike] | None = None,
    period: str | None = None,
    pulse_mean: str | None = None,
    harmonics: int = 40,
    wall: str | None = None,
    wall_viscosity: str | None = None,
    windkessel: str = "rc=0.69s",
    friction: Literal["womersley", "parabolic"] = "womersley",
    density: str | None = None,
    times: int = 100,
    unfed: Literal["drop", "keep"] = "keep",
) -> Simulation:
    """Solves the flow in a network, and beside it with all changes at once: what ``willis simulate`` does.

    ``stenosis`` is the share of the diameter by which vessels, by label or ``edge:ROW``, are narrowed (0.7), or a text of the command
    (``"area:70%"``, ``"70%@mid:10mm"``); ``tortuosity`` the factor by which they are lengthened. With ``transport``, the result has
    ``territories`` and ``transit``: who feeds what, and when blood arrives; with ``occlude_each`` it has ``occlusions``: what each vessel means that is
    closed in turn. Vessels that no inlet feeds have no flow, or are left out with
    ``unfed="drop"``.

    With ``pulse`` the flow pulsates, and the result has ``waveforms``: True for a typical shape at every inlet, the path of a table of
    one period (``time_s``, and ``pressure_mmHg`` or ``flow_mL_per_min``), or a path for each of several inlets by name. The options
    after it go with it, as texts of the command (``wall="pwv=8m/s"``).
    """
    narrowed = {name: by if isinstance(by, str) else _percent(by) for name, by in (stenosis or {}).items()}
    if isinstance(pulse, Mapping):
        waves = [f"{node}={text(file)}" for node, file in pulse.items()]
    else:
        waves = ["typical"] if pulse is True else [] if pulse in (None, False) else [text(pulse)]
    given = {
        "stenosis": Repeated([f"{name}={by}" for name, by in narrowed.items()]),
        "occlude": Repeated(occlude),
        "tortuosity": Repeated([f"{name}={text(factor)}" for name, factor in (tortuosity or {}).items()]),
        "viscosity": viscosity,
        **conditions(inlets, outlets, flows),
        "bc": bc,
        "transport": transport,
        "occlude_each": occlude_each,
        "pulse": Repeated(waves),
        "period": period,
        "pulse_mean": pulse_mean,
        "harmonics": harmonics,
        "wall": wall,
        "wall_viscosity": wall_viscosity,
        "windkessel": windkessel,
        "friction": friction,
        "density": density,
        "times": times,
        "unfed": unfed,
    }
    network = network_of(source)
    made = words(given, defaults_of(simulate))
    return Simulation(_willis.simulate(network._scan, network._reading + made))


def _percent(by: float) -> str:
    return f"{100 * float(numbers('stenosis', [by])[0]):.15g}%"


def _pair(one: Sequence[float]) -> Sequence[float]:
    if np.shape(one) != (2,):
        raise WillisError(f"classes {one!r}: expected pairs, low and high", item="classes", value=repr(one), expected="pairs, low and high")
    return one


class Modulation:
    """How a network responds to resistances that vary at random."""

    def __init__(self, modulation: _willis.Modulation) -> None:
        self._modulation = modulation

    @property
    def record(self) -> dict[str, Any]:
        """What run.json of the command holds."""
        record: dict[str, Any] = json.loads(self._modulation.record)
        return record

    def save(self, folder: PathLike, *, save_samples: bool = False, force: bool = False, dpi: int = 150) -> None:
        """Writes the folder that ``willis modulate`` writes; ``force`` replaces the one of an earlier run."""
        self._modulation.save(Path(folder), save_samples, force, whole("dpi", dpi))


def modulate(
    source: Source,
    *,
    classes: Sequence[tuple[float, float]] = ((0, 0.2), (0.2, 0.3), (0.3, 0.5)),
    samples: int = 1000,
    seed: int = 0,
    reading: Literal["increment", "conductance", "literal", "geometry"] = "increment",
    vessels: Sequence[str] | None = None,
    viscosity: str = "3.5cP",
    inlets: Nodes | None = None,
    outlets: str | Nodes | None = None,
    flows: Nodes | None = None,
    bc: PathLike | None = None,
    threshold: float | None = None,
    unfed: Literal["drop", "keep"] = "keep",
    threads: int | None = None,
    progress: Progress = True,
) -> Modulation:
    """Modulates the resistances of a network at random: what ``willis modulate`` does.

    ``classes`` are pairs, low and high, of u; boundary conditions are as in :func:`infer`; ``threshold`` is in mmHg/mm2; ``unfed="drop"`` leaves out vessels that no inlet feeds.
    """
    given = {
        "classes": ",".join(":".join(map(text, _pair(one))) for one in classes),
        "samples": samples,
        "seed": seed,
        "reading": reading,
        "vessels": vessels,
        "viscosity": viscosity,
        **conditions(inlets, outlets, flows),
        "bc": bc,
        "threshold": threshold,
        "unfed": unfed,
    }
    network = network_of(source)
    defaults = {**defaults_of(modulate), "classes": "0:0.2,0.2:0.3,0.3:0.5"}
    all_words = network._reading + words(given, defaults)
    watch, threads = _willis.Watch(), threads_of(threads)
    work = lambda told: _willis.modulate(network._scan, all_words, watch, threads, told, say)  # noqa: E731
    return Modulation(followed(progress, work))
