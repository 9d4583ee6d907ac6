"""Makes the performance page of the book and the table in this folder's README from results.csv and large.csv: page.py, or page.py --check.

--check writes nothing. It fails if a page does not match the figures. Any Python from 3.8 on, without packages.
"""
import csv
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs/src/performance.md"
BENCHES = HERE / "README.md"
MACHINE = "machine"

TEXT = """# Performance

<!-- Made by benches/page.py from benches/results.csv and benches/large.csv; do not edit. -->

`benches/run.sh` measured every number on this page, and `benches/page.py` made the page from them. `benches/README.md` describes the
measurements and their limits.

## Small graphs

The table has microseconds per sample, for all steps of a sample: mask, flow, resilience, forest and sums. Each column is a graph. The first one
ships with the project; the names of the others end in their numbers of nodes and vessels. The occlusion probability is 0.3, and every vessel is
uncertain.

{small}

{machine}
{million}{skipped}
- **The paper's loop** is `--solver reference`: for each sample one sparse Cholesky factorisation by faer and one spanning forest by petgraph.
- **NumPy, SciPy** is the faster of SuperLU and dense LAPACK, with `csgraph` for components and forest. Most of its time goes to the interpreter and
  to setting up arrays. The ratio shows what a user gains, not the quality of SuperLU.
- A ratio compares two measurements of the same round, taken one after the other.

`benches/run.sh` repeats these measurements.

## Large graphs

The table compares willis with the best Python pipeline on graphs of `willis phantom arterial|capillary --edges N --break`, with one thread each.
Candidates are open with probability 0.25; observed vessels are always open. The bytes per vessel are those of one worker with its sums, and those of
the elimination programs that all workers share. They do not include the graph. The peak is that of the whole process, with the graph.

{large}

{where}`benches/run.sh --large` repeats these measurements. Both commands also update this page.
"""

ROWS = [
    ("figures", "**one thread**", "one", 1),
    ("figures", "{threads} threads", "all", 1),
    ("figures", "of one thread: mask", "mask", 1),
    ("figures", "solve: assemble, eliminate, substitute", "solve", 1),
    ("figures", "forest", "forest", 1),
    ("figures", "the rest: resilience, keys, sums", "rest", 1),
    ("figures", "the paper's loop (faer, petgraph), one thread", "reference", 1),
    ("ratios", "times as long, by round", "reference", "one"),
    ("figures", "NumPy, SciPy, one thread", "python", 1),
    ("ratios", "times as long, by round", "python", "one"),
    ("figures", "forest only: Kruskal in willis", "kruskal", 1),
    ("figures", "forest only: petgraph, graph ready", "petgraph_ready", 1),
    ("figures", "forest only: petgraph, with building the graph", "petgraph", 1),
    ("ratios", "times as long as willis, by round", "petgraph", "lanes"),
    ("figures", "joins of the solve", "joins_solve", 1),
    ("figures", "joins of the forest", "joins_forest", 1),
    ("figures", "thousand instructions per sample, baseline", "instructions", None),
    ("figures", "peak memory of `willis infer`, MB", "memory", 1e-3),
]


def digits(x):
    return f"{x:.0f}" if x >= 1000 or x == int(x) else f"{x:.1f}" if x >= 10 else f"{x:.2f}"


def three(x):
    """Three digits, or all before the point."""
    return f"{x:.0f}" if x >= 100 else f"{x:.3g}"


class Results:
    """results.csv: rounds of every figure on every graph, and words on the machine."""

    def __init__(self, path):
        self.rounds, self.graphs, self.words, self.skipped = {}, [], {}, []
        for row in csv.DictReader(open(path, encoding="utf-8")):
            figure, graph, value = row["figure"], row["graph"], row["value"]
            if figure == "skipped":
                self.skipped.append(value)
            elif graph == MACHINE:
                self.words[figure] = value
            else:
                if graph not in self.graphs:
                    self.graphs.append(graph)
                self.rounds.setdefault((figure, graph), []).append(float(value))
        for graph in self.graphs:
            parts = [self.least(figure, graph) for figure in ("one", "mask", "solve", "forest")]
            if None not in parts:
                self.rounds["rest", graph] = [parts[0] - sum(parts[1:])]

    def least(self, figure, graph):
        return min(self.rounds[figure, graph]) if (figure, graph) in self.rounds else None

    def ratios(self, figure, base, graph):
        both = zip(self.rounds.get((figure, graph), []), self.rounds.get((base, graph), []))
        return " / ".join(digits(a / b) for a, b in both) or "-"

    def table(self, rows):
        lines = ["| microseconds per sample | " + " | ".join(self.graphs) + " |", "|---|" + "---:|" * len(self.graphs)]
        for kind, title, key, other in rows:
            cells = []
            for graph in self.graphs:
                if kind == "ratios":
                    cells.append(self.ratios(key, other, graph))
                else:
                    least, scale = self.least(key, graph), other or 1e-3 / float(self.words["samples"])
                    cells.append("-" if least is None or least < 0 else digits(least * scale))
            lines.append(f"| {title.format(**self.words)} | " + " | ".join(cells) + " |")
        return "\n".join(lines)

    def machine(self):
        rounds = max(len(values) for values in self.rounds.values())
        return f"{self.words['cpu']}, {self.words['threads']} threads, load {self.words['load']} at the end; the least of {rounds} rounds.\n"

    def million(self):
        found = [graph for graph in self.graphs if ("million_1", graph) in self.rounds]
        line = "A million samples of {}: {} s with one thread, {} s with two; ratio by round {}.\n"
        return "".join(
            line.format(g, digits(self.least("million_1", g)), digits(self.least("million_2", g)), self.ratios("million_1", "million_2", g))
            for g in found
        )


def large(path):
    """The table of large.csv, and the machine where it is known."""
    rows = {}
    for row in csv.DictReader(open(path, encoding="utf-8")):
        rows.setdefault((row["family"], int(row["edges"])), []).append(row)
    lines = [
        "| family | edges | uncertain | solver | ms per sample | Python, ms | its solver | times as long | bytes per vessel: worker | shared | peak, MB | residual |",
        "|---|---:|---:|---|---:|---:|---|---:|---:|---:|---:|---:|",
    ]
    machines = set()
    for (family, _), rounds in rows.items():
        least = min(float(r["ms"]) for r in rounds)
        theirs = min(float(r["peer_ms"]) for r in rounds)
        ratio = " / ".join(f"{float(r['peer_ms']) / float(r['ms']):.0f}" for r in rounds)
        r = rounds[0]
        machines |= {one["cpu"] for one in rounds if one.get("cpu")}
        lines.append(
            f"| {family} | {int(r['vessels']):,} | {int(r['uncertain']):,} | {r['solver']} | {three(least)} | {three(theirs)} | {r['peer']} "
            f"| {ratio} | {r['worker']} | {r['shared']} | {r['peak_mb']} | {r['residual']} |"
        )
    return "\n".join(lines), "".join(f"{machine}. " for machine in sorted(machines))


def spliced(text, mark, table):
    """A text with a table between the marks MARK:begin and MARK:end."""
    begin, end = f"<!-- {mark}:begin -->\n", f"<!-- {mark}:end -->"
    before, rest = text.split(begin)
    return before + begin + table + "\n" + end + rest.split(end, 1)[1]


def main():
    results = Results(HERE / "results.csv")
    table, where = large(HERE / "large.csv")
    skipped = f"Skipped: {'; '.join(results.skipped)}.\n" if results.skipped else ""
    page = TEXT.format(
        small=results.table(ROWS), machine=results.machine(), million=results.million(), skipped=skipped, large=table, where=where
    )
    made = {
        PAGE: page,
        BENCHES: spliced(BENCHES.read_text(encoding="utf-8"), "large", table),
    }
    if "--check" in sys.argv:
        stale = [str(path) for path, text in made.items() if path.read_text(encoding="utf-8") != text]
        sys.exit(f"does not match the figures, run benches/page.py: {', '.join(stale)}" if stale else 0)
    for path, text in made.items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
