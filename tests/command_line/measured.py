"""Drawn courses, and masks of them, as `willis measure` measures them, held against skan, VMTK and maskel. Usage: measured.py WILLIS; in an empty folder.

A program that is not installed is named on standard output.
"""

import importlib.util
import subprocess
import sys

import nibabel
import numpy as np
import pandas as pd
from scipy import sparse
from scipy.spatial import cKDTree

WILLIS = sys.argv[1]
HAS = {name: importlib.util.find_spec(name) is not None for name in ("skan", "vmtk", "maskel")}
RISE, RADIUS, TURNS = 2.0, 5.0, 3
CURVATURE, TORSION = (of / (RADIUS**2 + RISE**2) for of in (RADIUS, RISE))


def helix(spacing):
    turn = np.linspace(0, TURNS * 2 * np.pi, int(TURNS * 2 * np.pi * np.hypot(RADIUS, RISE) / spacing) + 1)
    return [np.column_stack([RADIUS * np.cos(turn), RADIUS * np.sin(turn), RISE * turn])]


def fork(spacing):
    """Straight vessels of 20, 15 and 12 mm, 70 degrees between the last two."""
    half = np.radians(35)
    lines = [((-20, 0, 0), (0, 0, 0)), ((0, 0, 0), (15 * np.cos(half), 15 * np.sin(half), 0)), ((0, 0, 0), (12 * np.cos(half), -12 * np.sin(half), 0))]
    return [np.linspace(*ends, int(np.linalg.norm(np.subtract(*ends)) / spacing) + 1) for ends in lines]


def circle(spacing):
    turn = np.linspace(0, 1.5 * np.pi, int(1.5 * np.pi * 8 / spacing) + 1)
    return [np.column_stack([8 * np.cos(turn), 8 * np.sin(turn), 0 * turn])]


def straight(spacing):
    return [np.outer(np.linspace(0, 1, int(30 / spacing) + 1), (20, 10, 20))]


def measure(file, *options):
    subprocess.run([WILLIS, "measure", file, "-o", "out", "--force", "-q", *options], check=True)
    return pd.read_csv("out/vessels.csv"), pd.read_csv("out/subjects.csv").iloc[0]


def swc(lines):
    """A file of the lines, whose first points after the first line are the last one of that."""
    rows = []
    for line in lines:
        parent = -1 if line is lines[0] else len(lines[0])
        for x, y, z in line[parent > 0 :]:
            rows.append(f"{len(rows) + 1} 0 {x:.9f} {y:.9f} {z:.9f} 1 {parent}\n")
            parent = len(rows)
    with open("drawn.swc", "w") as file:
        file.writelines(rows)
    return "drawn.swc"


def by_skan(lines):
    import skan

    first = len(lines[0]) - 1
    points, edges = [lines[0]], [np.column_stack([np.arange(first), np.arange(first) + 1])]
    for line in lines[1:]:
        rows = np.concatenate([[first], sum(map(len, points)) + np.arange(len(line) - 1)])
        points.append(line[1:])
        edges.append(np.column_stack([rows[:-1], rows[1:]]))
    points, edges = np.concatenate(points), np.concatenate(edges)
    steps = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
    graph = sparse.coo_array((np.tile(steps, 2), (rows, columns)), shape=(len(points),) * 2).tocsr()
    return skan.summarize(skan.csr.PathGraph.from_graph(adj=graph, node_coordinates=points, node_values=np.ones(len(points))), separator="_")


def by_vmtk(line):
    """Length, length over chord, and curvature and torsion at the points."""
    import vmtk.vtkvmtk
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    points, cells, drawn = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetDataTypeToDouble()
    cells.InsertNextCell(len(line))
    for point in line:
        cells.InsertCellPoint(points.InsertNextPoint(*point))
    drawn.SetPoints(points)
    drawn.SetLines(cells)
    geometry = vmtk.vtkvmtk.vtkvmtkCenterlineGeometry()
    geometry.SetInputData(drawn)
    for name in ("Length", "Tortuosity", "Curvature", "Torsion", "FrenetTangent", "FrenetNormal", "FrenetBinormal"):
        getattr(geometry, f"Set{name}ArrayName")(name)
    geometry.SetLineSmoothing(False)
    geometry.Update()
    made = geometry.GetOutput()
    of_line = [vtk_to_numpy(made.GetCellData().GetArray(name))[0] for name in ("Length", "Tortuosity")]
    return of_line[0], 1 + of_line[1], *(vtk_to_numpy(made.GetPointData().GetArray(name)) for name in ("Curvature", "Torsion"))


def near(found, expected, share):
    assert np.all(np.abs(np.asarray(found) - expected) <= share * np.abs(expected)), (found, expected)


def drawn():
    for spacing in (0.1, 0.25, 0.5):
        for lines in (helix(spacing), fork(spacing), circle(spacing), straight(spacing)):
            vessels, subject = measure(swc(lines), "--smoothing", "2mm", "--inlet", "1")
            assert len(vessels) == len(lines) and subject.bifurcations == len(lines) // 3
            vessels = vessels.sort_values("length_mm")
            if len(lines) == 3:
                bifurcation = pd.read_csv("out/bifurcations.csv").iloc[0]
                near(bifurcation[["angle_deg", "bend_child_1_deg", "bend_child_2_deg"]].astype(float), [70, 35, 35], 0.01)
                assert abs(bifurcation.elevation_deg) < 1e-3
            if HAS["skan"]:
                theirs = by_skan(lines).sort_values("branch_distance")
                assert len(theirs) == len(lines)
                near(vessels.length_mm, theirs.branch_distance, 1e-6)
                near(vessels.chord_mm, theirs.euclidean_distance, 1e-6)
            if HAS["vmtk"]:
                length, tortuosity = np.transpose([by_vmtk(line)[:2] for line in sorted(lines, key=len)])
                near(vessels.length_mm, length, 1e-6)
                near(vessels.distance_metric, tortuosity, 1e-6)
        # A circle has no torsion, and a line no curvature either.
        vessel = measure(swc(circle(spacing)), "--smoothing", "2mm")[0].iloc[0]
        for curvature in [1 / 8, *([np.median(by_vmtk(circle(spacing)[0])[2])] if HAS["vmtk"] else [])]:
            near(vessel.curvature_per_mm, curvature, 0.01)
        assert vessel.torsion_per_mm < 1e-3
        vessel = measure(swc(straight(spacing)), "--smoothing", "2mm")[0].iloc[0]
        near([vessel.length_mm, vessel.chord_mm, vessel.distance_metric], [30, 30, 1], 1e-6)
        assert vessel.curvature_per_mm < 1e-3 and vessel.torsion_per_mm == 0
        # At the two ends VMTK has no derivatives to make curvature and torsion of, so the middle one of its values counts.
        vessel = measure(swc(helix(spacing)), "--smoothing", "2mm")[0].iloc[0]
        references = [(CURVATURE, TORSION)]
        if HAS["vmtk"]:
            references.append([np.median(values) for values in by_vmtk(helix(spacing)[0])[2:]])
        for curvature, torsion in references:
            near(vessel.curvature_per_mm, curvature, 0.01)
            near(vessel.torsion_per_mm, torsion, 0.01)
        # Six radii, which voxels need, are as long as the helix is wide: its torsion comes out lower.
        vessel = measure(swc(helix(spacing)))[0].iloc[0]
        near(vessel.curvature_per_mm, CURVATURE, 0.01)
        assert 0.95 < vessel.torsion_per_mm / TORSION < 0.97, vessel.torsion_per_mm / TORSION


def mask(lines, spacing):
    """Voxels within a mm of the lines."""
    points = np.concatenate(lines)
    low = points.min(axis=0) - 3
    shape = np.ceil((points.max(axis=0) + 3 - low) / spacing).astype(int)
    voxels = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    away = cKDTree(points).query(voxels * spacing + low, distance_upper_bound=1.01)[0]
    inside = (away <= 1).reshape(shape).astype(np.uint8)
    affine = np.diag([spacing] * 3 + [1.0])
    affine[:3, 3] = low
    nibabel.save(nibabel.Nifti1Image(inside, affine), "mask.nii")
    return inside


def masks():
    # The axes of the courses lie askew to the voxels.
    a, b = np.radians(35), np.radians(20)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    for spacing in (0.25, 0.5):
        for lines in (helix(0.05), fork(0.05)):
            lines = [line @ turn.T for line in lines]
            truth = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)
            inside = mask(lines, spacing)
            vessels, subject = measure("mask.nii")
            assert len(vessels) == len(lines), vessels
            # A line ends within a radius of where the vessel does.
            assert -subject.ends * 1.0 < subject.length_mm - truth < 0.01 * truth, (subject.length_mm, truth)
            near(vessels.radius_mm, 1.0, 0.02)
            if len(lines) > 1:
                assert vessels.distance_metric.max() < 1.02, "straight vessels are straight"
            theirs = []
            if HAS["skan"]:
                import skan
                from skimage.morphology import skeletonize

                theirs.append(skan.summarize(skan.Skeleton(skeletonize(inside), spacing=spacing), separator="-"))
            if HAS["maskel"]:
                from maskel.config import ExtractionConfig, OutputConfig, PipelineConfig
                from maskel.pipeline import analyze_segmentation_mask

                wanted = ExtractionConfig(branches=True, mask_radius=True, spacing=(spacing,) * 3)
                made = analyze_segmentation_mask(inside, PipelineConfig(extraction=wanted, output=OutputConfig()))
                theirs.append(pd.DataFrame(made.branch_records))
                assert 0.85 < theirs[-1].mean_radius.min() <= theirs[-1].mean_radius.max() < 1, theirs[-1].mean_radius
            for branches in theirs:
                assert len(branches) == len(vessels)
                # They go from voxel to voxel.
                assert 1.04 < branches["branch-distance"].sum() / truth < 1.15, branches["branch-distance"].sum() / truth
                if len(lines) > 1:
                    assert 1.1 < (branches["branch-distance"] / branches["euclidean-distance"]).max() < 1.2, branches


drawn()
masks()
for name, has in HAS.items():
    if not has:
        print(f"skipped: {sys.executable} has no {name}")
