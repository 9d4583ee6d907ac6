"""What copies of runs that two vessels share could add to the answers to masks. passes.py SKELBENCH WORK, as run.sh leaves it.

Every connection along such a run (`through`) that an answer has lost is put back by what the truth says, as an edge of its true length between the places of the
answer that show its two stations: as if a perfect model had copied the run for its vessel. No fusion comes back with it, and what else is lost stays lost.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

sys.path.insert(0, sys.argv[1])
import score

FIGURES = ("path", "nrun", "cut_recall", "through_kept")
PLAIN = score.Net


def with_copies(case):
    """A Net with every connection along a shared run of the truth."""

    class Copied(PLAIN):
        def __init__(self, lines, h, nodes):
            super().__init__(lines, h, nodes)
            joints = [(*joint[:2], np.linalg.norm(np.subtract(*case.station[list(joint[:2])])), *joint[3:]) for joint in case.t["joints"]]
            copies = []
            for a, b, mm, state, centre, reach in [*case.near, *joints]:
                sides = [case.sides[a], case.sides[b]]
                if state != "through" or set.intersection(*self.local(centre, reach, sides)):
                    continue
                ends = [[y for y in self.points(side) if np.linalg.norm(self.xyz[y] - centre) <= reach] for side in sides]
                if all(ends):
                    nearest = (min(of, key=lambda y: np.linalg.norm(self.xyz[y] - case.station[k])) for of, k in zip(ends, (a, b)))
                    copies.append((*nearest, mm + 1e-9))
            for a, b, _ in copies:
                self.adj[a].append(b)
                self.adj[b].append(a)
            if copies:
                a, b, mm = zip(*copies)
                self.csr = (self.csr + coo_matrix((mm, (a, b)), shape=self.csr.shape)).tocsr()
                self.comp = connected_components(self.csr, directed=False)[1]
            case.copies = len(copies)

    return Copied


work, gains = Path(sys.argv[2]), []
print("| cases | answer | " + " | ".join(FIGURES) + " | copies a case |\n" + "|---" * (len(FIGURES) + 3) + "|")
for level in ("good", "fair"):
    found = {"as it is": [], "every shared run copied": []}
    copies = []
    for folder in sorted((work / "cases" / level).iterdir()):
        case = score.Case(folder)
        answer = score.read_answer(work / "mask-cut" / level / folder.name, case)
        found["as it is"].append(score.score(case, *answer))
        score.Net = with_copies(case)
        found["every shared run copied"].append(score.score(case, *answer))
        copies.append(case.copies)
        score.Net = PLAIN
    for name, of in found.items():
        figures = " | ".join(f"{np.nanmean([one[key] for one in of]):.3f}" for key in FIGURES)
        print(f"| {level} | {name} | {figures} | {np.mean(copies) if 'copied' in name else 0:.1f} |")
    gain = np.array([after["path"] - before["path"] for before, after in zip(*found.values())])
    means = gain[np.random.default_rng(0).integers(len(gain), size=(2000, len(gain)))].mean(1)
    print(f"| {level} | gain of path | " + "{:+.3f} [{:+.3f}, {:+.3f}]".format(gain.mean(), *np.percentile(means, [2.5, 97.5])) + " | | | | |")
