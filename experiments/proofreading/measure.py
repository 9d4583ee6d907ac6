"""A person who knows the truth works on the answers to simulated scans, to expert masks and to masks with gaps and fusions put into them; what the topology gains
by number of decisions; the tables of README.md too.

    measure.py SKELBENCH CASES WORK LEVEL [--subjects a,b] [--orders review,doubt,chance] [--decisions 20,60] [--rounds 4]
    measure.py SKELBENCH CASES WORK LEVEL --alone 20 [--subjects a,b]

Prints results.csv: level, subject, order, asked (0: the default answer; all: every question of that order; right: whatever is seen to be wrong, in so many
rounds of looking), figure, value. With `--alone` alone.csv: by what each of the first decisions of the review, made alone, changes path and run length. CASES has skelbench's cases with masks. WILLIS names the program. Answers are kept in WORK, and gone on from.
"""
import argparse
import collections
import csv
import json
import os
import random
import re
import shutil
import sys
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import common

HERE = Path(__file__).resolve().parent
AXES = ("x_mm", "y_mm", "z_mm")
WILLIS = os.environ.get("WILLIS", "target/release/willis")
FIGURES = ("path", "nrun", "join_f1", "cut_recall", "lost_connections", "cycles")
#: The level of masks with gaps and fusions put into them, and its figures.
IMPLANTS = "implants"
OF_IMPLANTS = ("gaps_closed", "fusions_undone", "safe_lost", "cycles")
#: The ends of a true link are so near to the stations between which it is missing, mm.
SITE = 4.0
#: What implants.py says of pairs of stations: that nothing is known of them, or no more than that both are of one side of a fusion.
UNKNOWN = "unknown"
UNSURE = (UNKNOWN, "side")
#: A person follows a vessel so far from where it touches another, mm, and sees a place as on a vessel so near to its line.
FOLLOWED, ON = 15.0, 1.5
#: What says that vessels at a place are one, as the answer has it; it costs a decision, and no list has it.
SAME = "same"
#: So many decisions are made on a list, before the run is made again with them and has a new one.
AT_ONCE = 10


def ends_of(row):
    """The places of the two nodes of a row of edges.csv, mm."""
    return np.array([[float(row[end + axis]) for axis in AXES] for end in "ab"])


class Person:
    """One who sees the tracing of a case beside the answer to it."""

    def __init__(self, score, proofread, folder, work):
        self.score, self.proofread, self.folder, self.work = score, proofread, folder, work
        self.case = score.Case(folder)
        self.stations = cKDTree(self.case.station)
        self.radius = np.array([station[3] for station in self.case.t["stations"]])
        self.near = [pair for pair in self.case.near if pair[3] not in UNSURE]
        self.sure = {frozenset(pair[:2]) for pair in self.near}
        self.neighbours = collections.defaultdict(set)
        for a, b, _, state, *_ in self.case.near:
            if state != UNKNOWN:
                self.neighbours[a].add(b)
                self.neighbours[b].add(a)
        # What a run said is wrong is not said again.
        self.refused = set()
        self.first = self.infer("0", [])
        self.gaps = {frozenset(pair[:2]) for pair in self.near if pair[3] == "gap"}
        self.rows, self.right = proofread.truth(self.case, self.first)
        for row, yes in self.right.items():
            if yes is False and self.is_candidate(row):
                self.right[row] = self.along(self.rows[row])
        self.ids = [row["id"] for row in common.rows(self.first / "nodes.csv")]

    def knows(self, place):
        """Whether a person can say of the line at a place how many vessels it shows."""
        return True

    def is_candidate(self, row):
        return self.rows[row]["origin"].strip() == "candidate"

    def along(self, row):
        """Whether a candidate that makes none of the case's links goes along the tracing all the same: over a gap of it, or else nobody can say."""
        places = ends_of(row)
        a, b = (next((self.case.station_of[node] for node in self.case.snap(place) if node in self.case.station_of), None) for place in places)
        if a is None or b is None:
            return False
        limit = 1.5 * np.linalg.norm(np.subtract(*places)) + 3.0
        far, before = dijkstra(self.case.true, directed=False, indices=a, limit=limit, return_predecessors=True)
        if not np.isfinite(far[b]):
            return False
        way = [b]
        while way[-1] != a:
            way.append(before[way[-1]])
        # Of several over one gap the one that is kept will do.
        return True if any(frozenset(pair) in self.gaps for pair in zip(way, way[1:])) and float(row["kept"] or 0) else None

    def infer(self, name, decisions):
        """The folder of the run with these decisions, (row, whether accepted) or (word, places). What the run refuses is left out of the list."""
        out, file = self.work / name, self.work / f"{name}.csv"
        if not decisions:
            if not (out / "run.json").exists():
                self.proofread.infer(WILLIS, self.folder, "mask.nii.gz", out)
            return out
        while True:
            made = [one for one in decisions if one[0] != SAME]
            text = self.listed(made)
            if file.exists() and file.read_text() == text and (out / "run.json").exists():
                return out
            shutil.rmtree(out, ignore_errors=True)
            file.write_text(text)
            try:
                self.proofread.infer(WILLIS, self.folder, "mask.nii.gz", out, file)
            except SystemExit as refused:
                line = re.search(rf"{re.escape(str(file))}:(\d+): ", str(refused))
                if not line:
                    raise
                print(f"{self.folder.name}: {refused}", file=sys.stderr)
                self.refused.add(made[int(line[1]) - 2])
                decisions.remove(made[int(line[1]) - 2])

    def listed(self, decisions):
        """decisions.csv."""
        sha256 = json.loads((self.first / "run.json").read_text())["input"]["sha256"]
        lines = [["edge", "id_a", "id_b", "decision", "input_sha256", "places"]]
        for what, how in decisions:
            if isinstance(how, bool):
                ends = [self.ids[int(self.rows[what][end])] for end in ("node_a", "node_b")]
                lines.append([what, *ends, "accept" if how else "reject", sha256, ""])
            else:
                lines.append(["", "", "", what, sha256, how])
        return "\n".join(",".join(map(str, line)) for line in lines) + "\n"

    def seen(self, out):
        """The figures of an answer, and its lines as skelbench sees them."""
        lines, rows = self.score.read_answer(out, self.case)
        return self.figures(out, lines, rows), self.score.Net(lines, self.case.h, self.case.kd)

    def figures(self, _, lines, rows):
        figures = self.score.score(self.case, lines, rows)
        return {name: figures[name] for name in FIGURES}

    def place(self, station):
        nodes = self.case.xyz[self.case.sides[station]]
        return nodes[np.linalg.norm(nodes - self.case.station[station], axis=1).argmin()]

    def text(self, groups):
        place = lambda station: " ".join(f"{x:.3f}" for x in self.place(station))
        return " | ".join(" + ".join(map(place, group)) for group in groups)

    def sides(self, fusion):
        """The stations of each vessel of a fusion that are of no other."""
        sides = [{self.case.station_of[node - 1] for node in side if node - 1 in self.case.station_of} for side in fusion["sides"]]
        return [side - set().union(*sides[:at], *sides[at + 1 :]) for at, side in enumerate(sides)]

    def part(self, fusion):
        """The decision that parts a fusion; none where not two vessels of it are seen. A vessel is followed on each way along it to the first station
        that is shown, outside the fusion's ball, and clear of the others; where it truly meets another first, to there."""
        case = self.case
        sides = [side for side in self.sides(fusion) if side]
        reach = fusion["reach_mm"]
        far = [dijkstra(case.true, directed=False, indices=sorted(side), limit=reach + FOLLOWED, min_only=True) for side in sides]
        owner = np.where(np.isfinite(far).any(axis=0), np.argmin(far, axis=0), -1) if sides else None
        groups = []
        for side, own in enumerate(sides):
            rest = np.flatnonzero((owner != side) & (owner >= 0))

            def away(station):
                apart = np.linalg.norm(case.station[rest] - case.station[station], axis=1) - self.radius[rest] - self.radius[station]
                return apart.min(initial=np.inf)

            legs, found, todo = set(), set(own), sorted(own)
            while todo:
                station = todo.pop()
                outside = np.linalg.norm(case.station[station] - fusion["place"]) >= reach
                ends = case.sides[station] and outside and away(station) > 2 * case.h
                if ends:
                    legs.add(station)
                # A vessel may be seen outside of the ball first; then it is followed into it.
                inward = lambda near: np.linalg.norm(case.station[near] - fusion["place"]) < np.linalg.norm(case.station[station] - fusion["place"])
                for near in sorted(near for near in self.neighbours[station] - found if not ends or inward(near)):
                    if owner[near] == side:
                        found.add(near)
                        todo.append(near)
                    elif owner[near] >= 0 and (shown := [one for one in sorted((station, near)) if case.sides[one]]):
                        legs.add(shown[0])
            if legs := legs or {max((station for station in found if case.sides[station]), key=away, default=None)} - {None}:
                groups.append(sorted(legs))
        return ("part", self.text(groups)) if len(groups) > 1 else None

    def fusions_left(self, net):
        met = lambda parts: any(parts[i] & parts[j] for i in range(len(parts)) for j in range(i))
        sides = lambda fusion: [[node - 1 for node in side] for side in fusion["sides"]]
        return [fusion for fusion in self.case.t["fusions"] if fusion["sides"] and met(net.local(fusion["place"], fusion["reach_mm"], sides(fusion)))]

    def missing(self, net):
        """Each stretch of the tracing that the answer lacks, as stations from where its lines show it to where they do again."""
        case = self.case
        held = lambda a, b, centre, reach: set.intersection(*net.local(centre, reach, [case.sides[a], case.sides[b]]))
        shown = {station for station, side in enumerate(case.sides) if side and self.is_shown(station, net)}
        absent = collections.defaultdict(set)
        for a, b, _, _, centre, reach in self.near:
            if not case.vein[a] and not (case.sides[a] and case.sides[b] and held(a, b, centre, reach)):
                absent[a].add(b)
                absent[b].add(a)
        found = []
        for start in sorted(shown & set(absent)):
            for way in ([start, near] for near in sorted(absent[start])):
                while way[-1] not in shown and len(further := absent[way[-1]] - {way[-2]}) == 1:
                    way.append(*further)
                if way[-1] in shown and start < way[-1] and not self.goes_on(net, way):
                    found.append(way)
        return found + self.apart(net)

    def apart(self, net):
        """Each stretch of the tracing of whose two ends the answer shows two stations in a row as one part each, but not the same."""
        near = [net.kd.query(self.place(station)) if side else (np.inf, 0) for station, side in enumerate(self.case.sides)]
        part = [int(net.comp[node]) if away <= ON else -1 for away, node in near]
        found = {}
        for a in range(len(part)):
            for b in self.neighbours[a]:
                if frozenset((a, b)) in self.sure and 0 <= part[a] != part[b] >= 0 and (part[b], part[a]) not in found:
                    beyond = [[far for far in sorted(self.neighbours[end] - {other}) if part[far] == part[end]] for end, other in ((a, b), (b, a))]
                    if all(beyond):
                        found.setdefault((part[a], part[b]), [beyond[0][0], a, b, beyond[1][0]])
        return list(found.values())

    def is_shown(self, station, net):
        """Whether a line of the answer passes a station, and not rather another vessel's."""
        away, node = net.kd.query(self.place(station))
        nearest = int(self.stations.query(net.xyz[node])[1])
        return away <= ON and (nearest == station or nearest in self.neighbours[station] or bool(self.neighbours[nearest] & self.neighbours[station]))

    def goes_on(self, net, way):
        """Whether the answer has a line from the one end of a stretch to the other that is about as long."""
        true = sum(np.linalg.norm(np.diff(self.case.station[way], axis=0), axis=1))
        a, b = (net.kd.query(self.place(station))[1] for station in (way[0], way[-1]))
        return np.isfinite(dijkstra(net.csr, directed=False, indices=a, limit=1.5 * true + 2 * ON)[b])

    def join(self, way):
        """The decision that joins two stations by those between; from the ends of the fragments that a true link is between, where one is."""
        case, ends = self.case, [way[0], way[-1]]
        near = [case.kd.query_ball_point(case.station[end], SITE) for end in ends]
        sites = [(a, b) for a in near[0] for b in near[1] for g, m in case.site.get(a, []) for h, n in case.site.get(b, []) if g == h and m != n]
        away = lambda pair: sum(np.linalg.norm(case.xyz[node] - case.station[end]) for node, end in zip(pair, ends))
        first, last = case.xyz[list(min(sites, key=away))] if sites else map(self.place, ends)
        between = [case.station[station] for station in way[1:-1]]
        return "join", " + ".join(" ".join(f"{x:.3f}" for x in place) for place in [first, *between, last])

    def answers(self, kind, row, at, absent):
        """What is said to the question of a row: where two vessels touch they are parted, all else is accepted or rejected; nothing where the tracing does not
        say. Where a wrong candidate ends, the right candidate is said if there is one, else where the tracing goes on."""
        if kind == "touch" or self.rows[row]["origin"].strip() == "contact":
            away = lambda fusion: np.linalg.norm(np.subtract(fusion["place"], at)) - fusion["reach_mm"]
            near = min((fusion for fusion in self.case.t["fusions"] if fusion["sides"]), key=away, default=None)
            if near and away(near) <= 0 and (parted := self.part(near)):
                return [parted]
        if kind == "touch":
            return [(SAME, " ".join(map(str, at)))] if self.knows(at) else []
        if self.right.get(row):
            return [(row, True)]
        if self.is_candidate(row) and self.right[row] is None:
            return []
        said = []
        ends = zip(ends_of(self.rows[row]), (self.rows[row]["node_a"], self.rows[row]["node_b"]))
        for place, node in ends if self.is_candidate(row) else ():
            beside = [other for other, yes in self.right.items() if yes and self.is_candidate(other) and node in (self.rows[other]["node_a"], self.rows[other]["node_b"])]
            away = lambda way: min(np.linalg.norm(self.case.station[way[at]] - place) for at in (0, -1))
            way = min(absent, key=away, default=None)
            if beside:
                said.append((max(beside, key=lambda other: float(self.rows[other]["probability"])), True))
            elif way and away(way) <= SITE:
                said.append(self.join(way))
        return said or [(row, False)] if self.right.get(row) is False else said

    def where(self, at, net, absent):
        """What is said of a part that nothing connects: the right candidate that leads out of it if there is one, else where the tracing goes on."""
        part = lambda place: net.comp[net.kd.query(place)[1]]
        loose = part(at)
        size = np.bincount(net.comp)
        leads = lambda places: (two := list(map(part, places))) and two[0] != two[1] and loose in two and size[two].sum()
        found = [(leads(ends_of(self.rows[row])), (row, True)) for row, yes in self.right.items() if yes and self.is_candidate(row)]
        found += [(leads([self.place(way[0]), self.place(way[-1])]), self.join(way)) for way in absent]
        most, said = max(found, key=lambda one: one[0], default=(0, None))
        return [said] if most else []

    def questions(self, order, out):
        """Rows of an answer in an order, and the places of the questions."""
        rows = common.rows(out / "edges.csv")[: len(self.rows)]
        if order == "review":
            asked = common.rows(out / "review.csv") if (out / "review.csv").exists() else []
            return [(row["kind"], int(row["edge"]), [float(row[axis]) for axis in AXES]) for row in asked if int(row["edge"]) < len(self.rows)]
        open_rows = [row for row in self.right if rows[row]["probability"] not in ("", "0", "1")]
        doubt = lambda row: -(p := float(rows[row]["probability"])) * (1 - p)
        open_rows.sort(key=doubt)
        if order == "chance":
            random.Random(0).shuffle(open_rows)
        return [(None, row, ends_of(rows[row]).mean(axis=0)) for row in open_rows]

    def session(self, order, counts):
        """Decisions in an order, the list looked at again after each few; (count, decisions, answer, how many questions were put) at each of the counts, and where
        the list of the review ends. A question to which nothing is said is put once."""
        decisions, out, put = [], self.first, set()
        while True:
            fresh, (_, net) = [], self.seen(out)
            absent = self.missing(net)
            for kind, row, at in self.questions(order, out):
                if len(fresh) < AT_ONCE:
                    put.add((kind, row))
                    said = self.where(at, net, absent) if kind == "part" else self.answers(kind, row, at, absent)
                    fresh += [one for one in dict.fromkeys(said) if one not in decisions + fresh and one not in self.refused]
            decisions += fresh
            out = self.infer(f"{order}-{len(decisions)}", decisions) if fresh else out
            while counts and len(decisions) >= counts[0]:
                yield counts.pop(0), decisions, out, len(put)
            if order != "review" and not counts:
                return
            if not fresh:
                for count in [*counts, "all"]:
                    yield count, decisions, out, len(put)
                return

    def alone(self, count):
        """What each of the first decisions of the review changes by itself: (its word, the change of each figure)."""
        before, net = self.seen(self.first)
        absent, said = self.missing(net), []
        for kind, row, at in self.questions("review", self.first):
            said += self.where(at, net, absent) if kind == "part" else self.answers(kind, row, at, absent)
        for number, decision in enumerate(list(dict.fromkeys(said))[:count]):
            made = [decision]
            after = self.seen(self.infer(f"alone-{number}", made))[0]
            if made:
                yield decision[0] if isinstance(decision[0], str) else "accept" if decision[1] else "reject", {name: after[name] - before[name] for name in ("path", "nrun")}

    def right_at_last(self, decisions, out, rounds):
        """After these decisions: whatever is seen to be wrong decided, and what is seen then, as often as that."""
        tried = set()
        for count in range(rounds):
            _, net = self.seen(out)
            rows = common.rows(out / "edges.csv")
            absent = self.missing(net)
            wrong = [row for row, yes in self.right.items() if yes is False and self.is_candidate(row) and float(rows[row]["kept"] or 0)]
            said = [one for row in wrong for one in self.answers(None, row, ends_of(rows[row]).mean(axis=0), absent)]
            left = {tuple(fusion["place"]): fusion for fusion in self.fusions_left(net)}
            said += [self.part(fusion) for place, fusion in left.items() if place not in tried]
            tried.update(left)
            said += map(self.join, absent)
            fresh = [one for one in dict.fromkeys(said) if one and one not in decisions]
            if not fresh:
                break
            decisions = decisions + fresh
            out = self.infer(f"right-{count + 1}", decisions)
        return decisions, out


class WhoPutIn(Person):
    """One who knows what was put into a real mask, and which branches of it are certain (`implants.py`), and says nothing of all else."""

    def __init__(self, score, proofread, folder, work):
        import implant

        self.implant = implant
        super().__init__(score, proofread, folder, work)
        self.degree = collections.Counter(row[end] for row in self.rows if row["origin"].strip() == "observed" for end in ("node_a", "node_b"))
        # Two sides are one for certain only by a way that is known throughout; apart if by no way.
        by_all, self.case.true = self.case.true, self.known_ways()
        certain = proofread.contact_truth(self.case, self.first)
        self.case.true = by_all
        for row, yes in self.right.items():
            if not self.is_candidate(row):
                self.right[row] = yes if yes == certain.get(row) else None
            elif yes is False and not self.leaves_gap(row):
                self.right[row] = None

    def known_ways(self):
        a, b, mm = zip(*(pair[:3] for pair in self.near))
        return coo_matrix((mm, (a, b)), shape=self.case.true.shape).tocsr()

    def leaves_gap(self, row):
        """Whether a candidate begins at a loose end of a gap, whose other side is known."""
        ends = zip((self.rows[row]["node_a"], self.rows[row]["node_b"]), ends_of(self.rows[row]))
        return any(self.degree[node] <= 1 and any(shown in self.case.site for shown in self.case.snap(place)) for node, place in ends)

    def knows(self, place):
        at = {self.case.station_of[node] for node in self.case.snap(place) if node in self.case.station_of}
        return any(pair & at for pair in self.sure)

    def figures(self, out, *_):
        judged = self.implant.judge(self.folder / "put-in", out)
        return {name: judged[name] for name in OF_IMPLANTS}


def measured(given, score, proofread):
    for folder in sorted(path.parent for path in given.cases.glob(f"{given.level}/*/truth.json")):
        if given.subjects and folder.name not in given.subjects.split(","):
            continue
        work = given.work / given.level / folder.name
        work.mkdir(parents=True, exist_ok=True)
        person = (WhoPutIn if given.level == IMPLANTS else Person)(score, proofread, folder, work)
        counts = [*map(int, given.decisions.split(","))]
        sessions = [("review", 0, [], person.first, 0)]
        for order in given.orders.split(","):
            sessions += [(order, count, list(said), *rest) for count, said, *rest in person.session(order, list(counts))]
        _, _, said, out, put = next(session for session in reversed(sessions) if session[0] == "review")
        sessions.append(("right", "all", *person.right_at_last(said, out, given.rounds), put))
        for order, count, decisions, out, put in sessions:
            words = collections.Counter(what if isinstance(what, str) else "row" for what, _ in decisions)
            figures = person.seen(out)[0] | {f"decisions_{word}": words[word] for word in ("row", "part", "join")}
            if given.level == IMPLANTS:
                figures["questions"] = put
            for figure, value in figures.items():
                yield [given.level, folder.name, order, count, figure, f"{value:.6g}"]


def alone(given, score, proofread):
    for folder in sorted(path.parent for path in given.cases.glob(f"{given.level}/*/truth.json")):
        if given.subjects and folder.name not in given.subjects.split(","):
            continue
        work = given.work / given.level / folder.name
        work.mkdir(parents=True, exist_ok=True)
        for number, (word, changes) in enumerate(Person(score, proofread, folder, work).alone(given.alone)):
            yield [given.level, folder.name, number + 1, word, *(f"{x:.6g}" for x in changes.values())]


def table():
    """README.md's tables: means over the subjects, of results.csv, and over decisions, of alone.csv."""
    changes = collections.defaultdict(list)
    for row in common.rows(HERE / "alone.csv"):
        changes[row["level"], row["decision"]].append((float(row["path"]), float(row["nrun"])))
        changes[row["level"], "all"].append((float(row["path"]), float(row["nrun"])))
    lines = []
    levels = list(dict.fromkeys(level for level, _ in changes))
    for (level, word), made in sorted(changes.items(), key=lambda item: (levels.index(item[0][0]), item[0][1] == "all")):
        path, run = np.array(made).T
        lines.append([level, word, len(path), f"{path.mean():+.4f}", f"{np.median(path):+.4f}", f"{path.min():+.3f}", int((path < -0.01).sum()), int((path > 0.01).sum()), f"{run.mean():+.4f}"])
    names = ["level", "decision", "made", "path, mean", "median", "worst", "of them below -.01", "above .01", "run length, mean"]
    common.splice(HERE / "README.md", "alone", common.table(names, lines))
    found = collections.defaultdict(list)
    for row in common.rows(HERE / "results.csv"):
        found[row["level"], row["order"], row["asked"], row["figure"]].append(float(row["value"]))
    lines = {"proofreading": [], IMPLANTS: []}
    for level, order, asked in dict.fromkeys(key[:3] for key in found):
        mean = lambda figure: np.nanmean(found[level, order, asked, figure])
        made = [f"{mean(f'decisions_{word}'):.0f}" for word in ("row", "part", "join")]
        start, cycles = ["" if asked == "0" else order, asked], f"{mean('cycles'):.1f}"
        if level == IMPLANTS:
            lines[IMPLANTS].append([*start, f"{mean('questions'):.0f}", *made, *(f"{mean(name):.3f}" for name in OF_IMPLANTS[:-1]), cycles])
        else:
            lines["proofreading"].append([level, *start, *made, *(f"{mean(name):.3f}" for name in FIGURES[:-1]), cycles])
    decided = ["rows", "parted", "joined"]
    names = {
        "proofreading": ["level", "order", "asked", *decided, "path", "run length", "F1 of joins", "fusions undone", "connections lost", "excess cycles"],
        IMPLANTS: ["order", "asked", "questions put", *decided, "gaps closed", "fusions undone", "safe lost", "cycles"],
    }
    for mark, of in lines.items():
        common.splice(HERE / "README.md", mark, common.table(names[mark], of))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "cases", "work"):
        parser.add_argument(name, type=Path)
    parser.add_argument("level")
    parser.add_argument("--subjects")
    parser.add_argument("--orders", default="review,doubt,chance")
    parser.add_argument("--decisions", default="20,60")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--alone", type=int)
    given = parser.parse_args()
    sys.path.insert(0, str(given.bench))
    import proofread
    import score

    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["level", "subject", "number", "decision", "path", "nrun"] if given.alone else ["level", "subject", "order", "asked", "figure", "value"])
    for row in (alone if given.alone else measured)(given, score, proofread):
        out.writerow(row)
        sys.stdout.flush()


if __name__ == "__main__":
    table() if sys.argv[1:] == ["table"] else main()
