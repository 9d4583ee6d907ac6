"""The filter of ParaView in VTK's own pipeline, and the module of 3D Slicer on a stand-in for the calls that it makes of Slicer."""

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


def expected(probability):
    """The length of the lines by the command's rule, of the table: what was observed, and candidates of at least so much."""
    edges = willis.infer(willis.from_vtk(lines()), progress=False).edges
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

    slicer, scripted = types.ModuleType("slicer"), types.ModuleType("slicer.ScriptedLoadableModule")
    slicer.mrmlScene = types.SimpleNamespace(AddNewNodeByClass=lambda kind, name: Node(name))
    for name in ("ScriptedLoadableModule", "ScriptedLoadableModuleLogic", "ScriptedLoadableModuleWidget"):
        setattr(scripted, name, type(name, (), {"__init__": lambda self, parent=None: None}))
    module = loaded("python/slicer/WillisTopology.py", {"slicer": slicer, "slicer.ScriptedLoadableModule": scripted})
    model = Node("scan")
    model.lines = lines()
    logic = module.WillisTopologyLogic()
    logic.infer(model)
    for probability in (0.3, 0.9):
        logic.show(probability)
        assert length(logic.output.GetPolyData()) == expected(probability)
    assert logic.output.GetName() == "scan topology" and logic.output.is_shown
