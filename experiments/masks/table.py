"""Puts radii.csv into README.md, and into radii.md and maps.md for the guide: a row a width, a column a rule for masks, and a column an image for maps."""
import csv
import pathlib

HERE = pathlib.Path(__file__).parent


def table(rows, key, heading):
    columns = list(dict.fromkeys(row[key] for row in rows))
    cell = {(row["width"], row[key]): "%+.1f ± %.1f %%" % (float(row["bias_percent"]), float(row["spread_percent"])) for row in rows}
    lines = ["| radius in voxels | " + " | ".join(heading % column for column in columns) + " |", "|---|" + "---|" * len(columns)]
    for width in dict.fromkeys(row["width"] for row in rows):
        lines.append("| %s | " % width + " | ".join(cell[width, column] for column in columns) + " |")
    return "\n".join(lines).replace("-0.0 ±", "+0.0 ±")


def main():
    with open(HERE / "radii.csv") as file:
        rows = list(csv.DictReader(file))
    of_masks = [row for row in rows if row["image"] == "mask"]
    of_maps = [row for row in rows if row["image"] != "mask"]
    text = (HERE / "README.md").read_text()
    for mark, lines in (("radii", table(of_masks, "rule", "`%s`")), ("maps", table(of_maps, "image", "%s"))):
        # The guide takes it from here, where this experiment is not stale.
        (HERE / f"{mark}.md").write_text(lines + "\n")
        head, rest = text.split("<!-- %s -->\n" % mark)
        text = head + "<!-- %s -->\n" % mark + lines + "\n<!-- end -->" + rest.split("<!-- end -->", 1)[1]
    (HERE / "README.md").write_text(text)


if __name__ == "__main__":
    main()
