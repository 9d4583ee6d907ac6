"""Find the plausible topology of vascular centerlines, with a probability for every connection.

>>> import willis
>>> run = willis.infer("data/broken-circle-of-willis.swc", progress=False)
>>> int(run.kept.sum()) < len(run.kept)
True
"""

from ._errors import Note, WillisError
from ._flow import Modulation, Simulation, modulate, simulate
from ._following import set_num_threads
from ._network import (
    Network,
    Table,
    centerlines,
    from_mask,
    from_networkx,
    from_skan,
    from_vtk,
    read,
)
from ._run import Handle, Run, SavedRun, candidates, infer, load
from ._study import Cohort, Labelled, Measured, Phenotype, classify, cohort, label, label_cohort, measure, phantom, train
from ._willis import __version__

__all__ = [
    "Cohort",
    "Handle",
    "Labelled",
    "Measured",
    "Modulation",
    "Network",
    "Note",
    "Phenotype",
    "Run",
    "SavedRun",
    "Simulation",
    "Table",
    "WillisError",
    "__version__",
    "candidates",
    "centerlines",
    "classify",
    "cohort",
    "from_mask",
    "from_networkx",
    "from_skan",
    "from_vtk",
    "infer",
    "label",
    "label_cohort",
    "load",
    "measure",
    "modulate",
    "phantom",
    "read",
    "set_num_threads",
    "simulate",
    "train",
]
