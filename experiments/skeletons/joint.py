"""A joint posterior of contacts and joins beside the decision of willis, on its answers to masks. joint.py SKELBENCH WORK, as run.sh leaves it.

Whole topologies are drawn by Gibbs sampling over all contacts and candidates of P >= .02, with the odds P / (1 - P) of each, times exp(-cycle) for each
independent cycle and exp(-part) for each part; a free end has at most one candidate. From the draws a topology is decided in two ways: what is kept in most
draws (candidates: in .4 of them, as willis does), and the most probable draw. The table has their means over the cases.
"""
import math
import random
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import networkx as nx
import numpy as np

sys.path.insert(0, sys.argv[1])
import passes
import score

FIGURES = ("path", "strict", "nrun", "cut_recall", "lost_connections", "cycles")
PRICES = [(0, 0), (2, 0), (0, 4), (2, 4), (6, 4)]
SWEEPS, BURN_IN, LEAST = 400, 50, .02


class Case:
    """Parts of what is observed, and what may join them."""

    def __init__(self, answer):
        self.graph = nx.read_graphml(answer / "candidates.graphml", force_multigraph=True)
        observed = nx.Graph()
        observed.add_nodes_from(self.graph)
        given, self.uncertain = [], []
        for a, b, key, data in self.graph.edges(keys=True, data=True):
            if data["origin"] == "observed":
                given.append((a, b))
            elif data["probability"] >= LEAST:
                self.uncertain.append((a, b, key, data["origin"], min(data["probability"], 1 - 1e-9)))
        observed.add_edges_from(given)
        degree = dict.fromkeys(self.graph, 0)
        for a, b in given:
            degree[a], degree[b] = degree[a] + 1, degree[b] + 1
        part = {node: i for i, nodes in enumerate(nx.connected_components(observed)) for node in nodes}
        self.parts = 1 + max(part.values())
        self.ends = [(part[a], part[b]) for a, b, *_ in self.uncertain]
        self.free = [[n for n in (a, b) if degree[n] <= 1] if origin == "candidate" else [] for a, b, _, origin, _ in self.uncertain]
        self.logit = [math.log(p / (1 - p)) for *_, p in self.uncertain]

    def draw(self, cycle, part, seed):
        """The share of draws that keep each, and the most probable draw."""
        rng = random.Random(seed)
        near = [{} for _ in range(self.parts)]
        kept, used = [False] * len(self.uncertain), {}
        shares = np.zeros(len(kept))
        weight, best, most = 0.0, list(kept), 0.0

        def joined(a, b):
            if a == b:
                return True
            sides = ({a}, {b})
            rims = ([a], [b])
            while rims[0] and rims[1]:
                which = 0 if len(rims[0]) <= len(rims[1]) else 1
                rim = []
                for node in rims[which]:
                    for other in near[node]:
                        if other in sides[1 - which]:
                            return True
                        if other not in sides[which]:
                            sides[which].add(other)
                            rim.append(other)
                rims = (rim, rims[1]) if which == 0 else (rims[0], rim)
            return False

        def put(row, on):
            a, b = self.ends[row]
            for x, y in ((a, b), (b, a)):
                near[x][y] = near[x].get(y, 0) + (1 if on else -1)
                if not near[x][y]:
                    del near[x][y]
            kept[row] = on
            for end in self.free[row]:
                used[end] = used.get(end, 0) + (1 if on else -1)

        for sweep in range(SWEEPS):
            for row in range(len(kept)):
                was = kept[row]
                if not was and any(used.get(end) for end in self.free[row]):
                    continue
                level = math.log(1 / max(rng.random(), 1e-300) - 1)
                if not was and -level > self.logit[row] + part:
                    continue
                if was:
                    put(row, False)
                gain = self.logit[row] + (-cycle if joined(*self.ends[row]) else part)
                now = -level <= gain
                if now:
                    put(row, True)
                weight += gain * (now - was)
            if sweep >= BURN_IN:
                shares += kept
            if weight > most:
                best, most = list(kept), weight
        return shares / (SWEEPS - BURN_IN), best

    def most_kept(self, shares):
        kept, used = [False] * len(shares), set()
        for row in np.argsort(-shares, kind="stable"):
            if shares[row] > (.4 if self.free[row] else .5) and not used.intersection(self.free[row]):
                kept[row] = True
                used.update(self.free[row])
        return kept

    def lines(self, kept):
        graph = self.graph.copy()
        on = {key[:3] for key, keep in zip(self.uncertain, kept) if keep}
        graph.remove_edges_from([e for e in graph.edges(keys=True) if graph.edges[e]["origin"] != "observed" and e not in on and (e[1], e[0], e[2]) not in on])
        with tempfile.TemporaryDirectory() as folder:
            nx.write_graphml(graph, f"{folder}/topology.graphml")
            return score.read_graphml(Path(folder) / "topology.graphml")


def answers(job):
    """Name of an answer, its figures."""
    level, folder, answer = job
    truth, case = score.Case(folder), Case(answer)
    found = {}

    def judge(name, lines):
        found[level, name] = dict(score.score(truth, lines, None), strict=passes.pair_errors(truth, lines)["strict"])

    judge("willis", score.read_answer(answer, truth)[0])
    for cycle, part in PRICES:
        shares, best = case.draw(cycle, part, seed=1)
        judge(f"cycle {cycle}, part {part}: kept in most draws", case.lines(case.most_kept(shares)))
        judge(f"cycle {cycle}, part {part}: most probable draw", case.lines(best))
    return found


def main():
    work, found = Path(sys.argv[2]), {}
    jobs = [(level, folder, work / "mask-cut" / level / folder.name) for level in ("good", "fair") for folder in sorted((work / "cases" / level).iterdir())]
    with ProcessPoolExecutor() as pool:
        for of in pool.map(answers, jobs):
            for key, figures in of.items():
                found.setdefault(key, []).append(figures)
    print("| cases | decision | " + " | ".join(FIGURES) + " |\n" + "|---" * (len(FIGURES) + 2) + "|")
    for (level, name), of in found.items():
        print(f"| {level} | {name} | " + " | ".join(f"{np.nanmean([one[key] for one in of]):.4g}" for key in FIGURES) + " |")


if __name__ == "__main__":
    main()
