"""What a call says while it works: notes, log and progress."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from collections.abc import Callable
from typing import Any, Union

from . import _willis
from ._errors import Note
from ._words import whole

PathLike = Union[str, "os.PathLike[str]"]
Progress = Union[bool, Callable[[int, int], object]]

_LOG = logging.getLogger("willis")


def say(heading: str, fact: str) -> None:
    """A note is a warning, everything else goes to the log."""
    if heading == "note":
        warnings.warn(fact, Note, stacklevel=4)
    else:
        _LOG.info("%s: %s", heading, fact)


class Bar:
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


def followed(progress: Progress, work: Callable[[Callable[[int, int], object] | None], Any]) -> Any:
    if callable(progress):
        return work(progress)
    if not (progress and _is_watched()):
        return work(None)
    bar = Bar()
    try:
        return work(bar)
    finally:
        bar.close()


def set_num_threads(threads: int) -> None:
    """So many threads from now on, where a call does not say otherwise; at first as many as ``RAYON_NUM_THREADS`` says, or processors."""
    _willis.set_num_threads(whole("threads", threads))


def threads_of(threads: int | None) -> int | None:
    return None if threads is None else whole("threads", threads)
