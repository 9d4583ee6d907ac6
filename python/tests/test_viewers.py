"""The filter of ParaView in VTK's own pipeline, and the module of 3D Slicer on a stand-in for what it calls, and in a scene of Slicer's core."""

import importlib.util
import sys
import types
import warnings
from unittest import mock

import numpy as np
import pytest

import willis

BROKEN = "data/broken-circle-of-willis.swc"
pytest.importorskip("vtkmodules")


def loaded(path, modules):
    with mock.patch.dict(sys.modules, modules):
        spec = importlib.util.spec_from_file_location("viewer", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


def expected(probability, frame=None):
    """The length of the lines by the command's rule, of the table: what was observed, and candidates of at least so much."""
    edges = willis.infer(willis.from_vtk(lines(), frame=frame), progress=False).edges
    kept = (edges["origin"] == "observed") | (edges["probability"] >= probability)
    return pytest.approx(edges["length_mm"][kept].sum(), rel=1e-6)


def length(data):
    """The length of all lines: vessels that a rejected candidate divided are one again, so that their number says nothing."""
    cells = (data.GetCell(row).GetPoints() for row in range(data.GetNumberOfCells()))
    places = [np.array([points.GetPoint(at) for at in range(points.GetNumberOfPoints())]) for points in cells]
    return sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in places)


def lines():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", willis.Note)
        return willis.read(BROKEN).to_vtk()


def test_the_filter_of_paraview():
    class Decorators:
        """As those of ParaView, which only note what the panel shows."""

        def __getattr__(self, name):
            return lambda *args, **options: lambda decorated: decorated

    from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase

    some = Decorators()
    algorithm = types.ModuleType("paraview.util.vtkAlgorithm")
    algorithm.VTKPythonAlgorithmBase = VTKPythonAlgorithmBase
    algorithm.smproxy = algorithm.smproperty = algorithm.smdomain = algorithm.smhint = some
    packages = {name: types.ModuleType(name) for name in ("paraview", "paraview.util")}
    module = loaded("python/paraview/willis_topology.py", {**packages, "paraview.util.vtkAlgorithm": algorithm})
    topology = module.WillisTopology()
    topology.SetInputDataObject(0, lines())
    lengths = []
    with mock.patch.object(willis, "infer", side_effect=willis.infer) as sampled:
        for probability in (0.0, 0.3, 0.9):
            topology.SetProbability(probability)
            topology.Update()
            lengths.append(length(topology.GetOutputDataObject(0)))
        assert sampled.call_count == 1, "the slider samples nothing"
    assert lengths == [expected(probability) for probability in (0.0, 0.3, 0.9)]
    assert lengths[0] > lengths[1] > lengths[2]


def logic_in(slicer):
    """The logic of the module, whose base class is a stand-in: that of Slicer is in no package."""
    scripted = types.ModuleType("slicer.ScriptedLoadableModule")
    for name in ("ScriptedLoadableModule", "ScriptedLoadableModuleLogic", "ScriptedLoadableModuleWidget"):
        setattr(scripted, name, type(name, (), {"__init__": lambda self, parent=None: None}))
    module = loaded("python/slicer/WillisTopology.py", {"slicer": slicer, "slicer.ScriptedLoadableModule": scripted})
    return module.WillisTopologyLogic()


def slides(logic, model):
    model.SetAndObservePolyData(lines())
    logic.infer(model)
    for probability in (0.3, 0.9):
        logic.show(probability)
        assert length(logic.output.GetPolyData()) == expected(probability, frame="RAS")
    assert logic.output.GetName() == "scan topology"


def test_the_module_of_slicer():
    class Node:
        def __init__(self, name):
            self.name, self.lines, self.is_shown = name, None, False

        def GetName(self):
            return self.name

        def IsA(self, name):
            return name == "vtkMRMLModelNode"

        def GetPolyData(self):
            return self.lines

        def SetAndObservePolyData(self, lines):
            self.lines = lines

        def CreateDefaultDisplayNodes(self):
            self.is_shown = True

    slicer = types.ModuleType("slicer")
    slicer.mrmlScene = types.SimpleNamespace(AddNewNodeByClass=lambda kind, name: Node(name))
    logic = logic_in(slicer)
    slides(logic, Node("scan"))
    assert logic.output.is_shown


def test_the_module_in_a_scene_of_slicer():
    """With the nodes of Slicer itself, as the package slicer-core has them."""
    slicer = pytest.importorskip("slicer", reason="slicer-core is not installed: tests/peers.txt")
    from vtkmodules.vtkCommonCore import vtkDoubleArray
    from vtkmodules.vtkCommonDataModel import vtkVector3d

    slicer.mrmlScene = slicer.vtkMRMLScene()
    logic = logic_in(slicer)
    slides(logic, slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode", "scan"))
    assert logic.output.GetDisplayNode() is not None
    curve = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", "drawn")
    for x in (0, 4, 8, 12):
        curve.AddControlPointWorld(vtkVector3d(x, 0, 0))
    with pytest.raises(willis.WillisError, match="default_radius"):
        logic.infer(curve)
    radii = lambda: logic.run.graph.edges["radius_mm"]  # noqa: E731
    logic.infer(curve, default_radius=1.5)
    assert radii() == pytest.approx([1.5]) and logic.run.graph.edges["length_mm"] == pytest.approx([12])
    # As SlicerVMTK keeps the radii of centerlines.
    values, radius = vtkDoubleArray(), slicer.vtkMRMLStaticMeasurement()
    values.SetName("Radius")
    for _ in range(4):
        values.InsertNextValue(0.75)
    radius.SetName("Radius")
    radius.SetControlPointValues(values)
    curve.AddMeasurement(radius)
    logic.infer(curve, default_radius=1.5)
    assert radii() == pytest.approx([0.75])
