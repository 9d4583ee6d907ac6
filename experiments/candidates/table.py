"""Puts results.csv into README.md: a row a rule, a column a group of cases, recall (candidates a case)."""
import csv
import pathlib

HERE = pathlib.Path(__file__).parent


def main():
    with open(HERE / "results.csv") as file:
        rows = list(csv.DictReader(file))
    groups = list(dict.fromkeys((r["data"], r["level"], r["cases"]) for r in rows))
    cell = {(r["rule"], r["data"], r["level"]): "%.4f (%s)" % (float(r["ceiling"]), r["candidates"]) for r in rows}
    lines = ["| rule | " + " | ".join("%s, %s, %s cases" % g for g in groups) + " |", "|---|" + "---|" * len(groups)]
    for rule in dict.fromkeys(r["rule"] for r in rows):
        lines.append("| `%s` | " % rule + " | ".join(cell[rule, data, level] for data, level, _ in groups) + " |")
    readme = HERE / "README.md"
    head, rest = readme.read_text().split("<!-- table -->\n")
    readme.write_text(head + "<!-- table -->\n" + "\n".join(lines) + "\n<!-- end -->" + rest.split("<!-- end -->", 1)[1])


if __name__ == "__main__":
    main()
