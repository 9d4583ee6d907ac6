"""Find the plausible topology of vascular centerlines by neurovascular resilience.

>>> import willis
>>> run = willis.infer("data/broken-circle-of-willis.swc", progress=False)
>>> int(run.kept.sum()) < len(run.kept)
True
"""

from ._api import (
    Network,
    Run,
    Shard,
    Simulation,
    centerlines,
    infer,
    merge,
    phantom,
    read,
    set_num_threads,
    simulate,
)
from ._errors import Note, WillisError
from ._willis import __version__

__all__ = [
    "Network",
    "Note",
    "Run",
    "Shard",
    "Simulation",
    "WillisError",
    "__version__",
    "centerlines",
    "infer",
    "merge",
    "phantom",
    "read",
    "set_num_threads",
    "simulate",
]
