"""Puts radii.csv into README.md and into the guide: a row a width, a column a rule."""
import csv
import pathlib

HERE = pathlib.Path(__file__).parent
GUIDE = HERE.parent.parent / "docs/src/guide-mask.md"


def main():
    with open(HERE / "radii.csv") as file:
        rows = list(csv.DictReader(file))
    rules = list(dict.fromkeys(row["rule"] for row in rows))
    cell = {(row["width"], row["rule"]): "%+.1f ± %.1f %%" % (float(row["bias_percent"]), float(row["spread_percent"])) for row in rows}
    lines = ["| radius in voxels | " + " | ".join("`%s`" % rule for rule in rules) + " |", "|---|" + "---|" * len(rules)]
    for width in dict.fromkeys(row["width"] for row in rows):
        lines.append("| %s | " % width + " | ".join(cell[width, rule] for rule in rules) + " |")
    for page in (HERE / "README.md", GUIDE):
        head, rest = page.read_text().split("<!-- radii -->\n")
        page.write_text(head + "<!-- radii -->\n" + "\n".join(lines) + "\n<!-- end -->" + rest.split("<!-- end -->", 1)[1])


if __name__ == "__main__":
    main()
