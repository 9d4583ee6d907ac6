"""The performance page and the tables of both READMEs, from results.csv and large.csv alone: page.py, or page.py --check.

--check writes nothing and fails when a page is not what the figures say. Any Python from 3.8 on, without packages.
"""
import csv
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs/src/performance.md"
README = HERE.parent / "README.md"
BENCHES = HERE / "README.md"
MACHINE = "machine"

TEXT = """# Performance

<!-- Made by benches/page.py from benches/results.csv and benches/large.csv; do not edit. -->

Every figure here was measured by `benches/run.sh` and put in place by `benches/page.py`. `benches/README.md` says how, and what bounds it.

## Small graphs

Microseconds a sample (mask, flow, resilience, forest, sums), by graph; names end in nodes and vessels, but for the first, which ships with the
project. Occlusion probability 0.3, every vessel uncertain.

{small}

{machine}
{million}{skipped}
- **The paper's loop** is `--solver reference`: for each sample one sparse Cholesky factorisation by faer and one spanning forest by petgraph.
- **NumPy, SciPy** is the better of SuperLU and dense LAPACK, with `csgraph` for components and forest. Most of its time is interpreter and
  array set-up: the ratio says what a user gains, not how good SuperLU is.
- Ratios are taken within a round, in which the two sides follow each other.

To measure anew: `benches/run.sh`.

## Large graphs

Graphs of `willis phantom arterial|capillary --edges N --break` beside the best Python pipeline, one thread each. Candidates are open with
probability 0.25, observed vessels are certain. Bytes are of one worker with its sums, and of the programs that workers share; the graph itself is not in
them, but in the peak, which is that of the whole process.

{large}

{where}To measure anew: `benches/run.sh --large`. Both commands end by making this page.
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
    ("figures", "forest alone: Kruskal here", "kruskal", 1),
    ("figures", "forest alone: petgraph, graph ready", "petgraph_ready", 1),
    ("figures", "forest alone: petgraph, graph built", "petgraph", 1),
    ("ratios", "times as long as ours, by round", "petgraph", "lanes"),
    ("figures", "joins of the solve", "joins_solve", 1),
    ("figures", "joins of the forest", "joins_forest", 1),
    ("figures", "thousand instructions a sample, baseline", "instructions", None),
    ("figures", "peak memory of `willis infer`, MB", "memory", 1e-3),
]
SHORT = [
    ("figures", "**willis, one thread**", "one", 1),
    ("figures", "{threads} threads", "all", 1),
    ("figures", "the paper's loop as it is written, by faer and petgraph", "reference", 1),
    ("figures", "NumPy, SciPy", "python", 1),
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

    def ratios(self, figure, ours, graph):
        both = zip(self.rounds.get((figure, graph), []), self.rounds.get((ours, graph), []))
        return " / ".join(digits(a / b) for a, b in both) or "-"

    def table(self, rows):
        lines = ["| microseconds a sample | " + " | ".join(self.graphs) + " |", "|---|" + "---:|" * len(self.graphs)]
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
        return f"{self.words['cpu']}, {self.words['threads']} threads, load {self.words['load']} at the end; least of {rounds} rounds.\n"

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
        "| family | edges | uncertain | solver | ms a sample | Python, ms | its solver | times as long | bytes a vessel: worker | shared | peak, MB | residual |",
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
    short = results.table(SHORT) + "\n\n" + results.machine().rstrip("\n")
    made = {
        PAGE: page,
        README: spliced(README.read_text(encoding="utf-8"), "bench", short),
        BENCHES: spliced(BENCHES.read_text(encoding="utf-8"), "large", table),
    }
    if "--check" in sys.argv:
        stale = [str(path) for path, text in made.items() if path.read_text(encoding="utf-8") != text]
        sys.exit(f"not what the figures say, run benches/page.py: {', '.join(stale)}" if stale else 0)
    for path, text in made.items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
