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
    """The lines by the command's rule, counted in the table: what was observed, and candidates of at least so much."""
    edges = willis.infer(willis.from_vtk(lines()), progress=False).edges
    return int(np.sum((edges["origin"] == "observed") | (edges["probability"] >= probability)))


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
    counts = []
    with mock.patch.object(willis, "infer", side_effect=willis.infer) as sampled:
        for probability in (0.0, 0.3, 0.9):
            topology.SetProbability(probability)
            topology.Update()
            counts.append(topology.GetOutputDataObject(0).GetNumberOfLines())
        assert sampled.call_count == 1, "the slider samples nothing"
    assert counts == [expected(probability) for probability in (0.0, 0.3, 0.9)]
    assert len(set(counts)) > 1


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
        assert logic.output.GetPolyData().GetNumberOfLines() == expected(probability)
    assert logic.output.GetName() == "scan topology" and logic.output.is_shown
