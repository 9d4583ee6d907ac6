#!/usr/bin/env python3
"""Compares two orders of elimination on the fragments of `layouts.py`'s box: least degree, and nested dissection by place. Needs SciPy.

    orders.py WILLIS [COUNT...]

Prints, of the largest tangle of fragments, the widest star, and the multiplications of one elimination, under each.
"""

import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import layouts
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

SPACE = "{http://graphml.graphdrawing.org/xmlns}"
# Parts of fewer fragments are not divided.
LEAF = 40


def tangle(path):
    """Which fragments of the largest tangle candidates join, as a matrix, and their places."""
    keys, at, places, ends, observed = {}, {}, [], [], []
    for _, item in ET.iterparse(path):
        data = {keys[d.get("key")]: d.text for d in item.findall(SPACE + "data")} if item.tag in (SPACE + "node", SPACE + "edge") else {}
        if item.tag == SPACE + "key":
            keys[item.get("id")] = item.get("attr.name")
        elif item.tag == SPACE + "node":
            at[item.get("id")] = len(places)
            places.append([float(data[axis]) for axis in ("x_mm", "y_mm", "z_mm")])
        elif item.tag == SPACE + "edge":
            ends.append([at[item.get("source")], at[item.get("target")]])
            observed.append(data["origin"] == "observed")
    ends, observed, places = np.array(ends), np.array(observed), np.array(places)
    linked = lambda pairs, count: sparse.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    count, fragment = connected_components(linked(ends[observed], len(places)), directed=False)
    joins = fragment[ends[~observed]]
    joins = linked(joins[joins[:, 0] != joins[:, 1]], count).tocsr()
    joins = ((joins + joins.T) > 0).astype(float).tocsr()
    middle = np.zeros((count, 3))
    np.add.at(middle, fragment, places)
    middle /= np.bincount(fragment, minlength=count)[:, None]
    _, part = connected_components(joins, directed=False)
    rows = np.flatnonzero(part == np.argmax(np.bincount(part)))
    return joins[rows][:, rows], middle[rows]


def dissection(joins, places, rows):
    """Halves across the longest side, each before what separates them."""
    if len(rows) < LEAF:
        return list(rows)
    axis = np.argmax(np.ptp(places[rows], axis=0))
    rows = rows[np.argsort(places[rows, axis], kind="stable")]
    halves = [rows[: len(rows) // 2], rows[len(rows) // 2 :]]
    inside = [np.isin(np.arange(len(places)), half).astype(float) for half in halves]
    borders = [half[joins[half] @ inside[1 - side] > 0] for side, half in enumerate(halves)]
    side = int(len(borders[1]) < len(borders[0]))
    halves[side] = np.setdiff1d(halves[side], borders[side])
    return [*dissection(joins, places, halves[0]), *dissection(joins, places, halves[1]), *borders[side]]


def cost(joins, order=None):
    """The widest star and the multiplications of an elimination; by least degree without an order."""
    matrix = (sparse.diags(np.asarray(joins.sum(1)).ravel() + 1) - joins).tocsc()
    matrix = matrix if order is None else matrix[order][:, order].tocsc()
    spec = "MMD_AT_PLUS_A" if order is None else "NATURAL"
    stars = np.diff(splu(matrix, permc_spec=spec, diag_pivot_thresh=0, options={"SymmetricMode": True}).L.indptr).astype(float)
    return f"{stars.max():.0f} | {(stars**2).sum():.2g}"


def main():
    print("| fragments | in the tangle | widest, least degree | multiplications | widest, nested dissection | multiplications |\n|---|---|---|---|---|---|")
    for count in map(int, sys.argv[2:] or ("2500", "5000", "10000", "20000")):
        with tempfile.TemporaryDirectory() as folder:
            source, made = Path(folder, "a.swc"), Path(folder, "a.graphml")
            layouts.swc(source, layouts.box(count))
            subprocess.run([sys.argv[1], "candidates", source, "-o", made, "-q"], check=True)
            joins, places = tangle(made)
        order = np.array(dissection(joins, places, np.arange(len(places))))
        print(f"| {count:,} | {len(places):,} | {cost(joins)} | {cost(joins, order)} |", flush=True)


if __name__ == "__main__":
    main()
