"""Find the plausible topology of vascular centerlines by neurovascular resilience.

>>> import willis
>>> run = willis.infer("data/broken-circle-of-willis.swc", progress=False)
>>> int(run.kept.sum()) < len(run.kept)
True
"""

from ._api import (
    Modulation,
    Network,
    Phenotype,
    Run,
    Shard,
    Simulation,
    centerlines,
    classify,
    infer,
    merge,
    modulate,
    phantom,
    read,
    set_num_threads,
    simulate,
    train,
)
from ._errors import Note, WillisError
from ._willis import __version__

__all__ = [
    "Modulation",
    "Network",
    "Note",
    "Phenotype",
    "Run",
    "Shard",
    "Simulation",
    "WillisError",
    "__version__",
    "centerlines",
    "classify",
    "infer",
    "merge",
    "modulate",
    "phantom",
    "read",
    "set_num_threads",
    "simulate",
    "train",
]
