"""A module of 3D Slicer: the plausible topology of a model of centerlines, as a new model.

Edit > Application Settings > Modules: add this folder. The Python of Slicer must have the package `willis`: in its console,
`slicer.util.pip_install("/path/to/the/clone/of/willis")`.
"""

import slicer
from slicer.ScriptedLoadableModule import ScriptedLoadableModule, ScriptedLoadableModuleLogic, ScriptedLoadableModuleWidget


class WillisTopology(ScriptedLoadableModule):
    """What Slicer says of the module."""

    def __init__(self, parent):
        super().__init__(parent)
        parent.title = "Willis Topology"
        parent.categories = ["Vascular Modeling Toolkit"]
        parent.contributors = ["The willis developers"]
        parent.helpText = "Connects the fragments of centerlines (a model with radii at its points, mm) where vessels are likely to be."
        parent.acknowledgementText = "Moriconi et al. 2019, Towards Quantifying Neurovascular Resilience."


class WillisTopologyWidget(ScriptedLoadableModuleWidget):
    """An input, a slider, a button."""

    def setup(self):
        """Builds the panel."""
        import ctk
        import qt

        super().setup()
        self.logic, form = WillisTopologyLogic(), qt.QFormLayout()
        self.layout.addLayout(form)
        self.lines = slicer.qMRMLNodeComboBox()
        self.lines.nodeTypes = ["vtkMRMLModelNode", "vtkMRMLMarkupsCurveNode"]
        self.lines.setMRMLScene(slicer.mrmlScene)
        form.addRow("Centerlines", self.lines)
        self.probability = ctk.ctkSliderWidget()
        self.probability.maximum, self.probability.singleStep, self.probability.value = 1, 0.01, 0.5
        form.addRow("Least probability", self.probability)
        self.radius = qt.QDoubleSpinBox()
        self.radius.minimum, self.radius.singleStep, self.radius.value = 0.01, 0.1, 1
        form.addRow("Radius of curves without one, mm", self.radius)
        self.apply = qt.QPushButton("Apply")
        form.addRow(self.apply)
        self.apply.clicked.connect(self.on_apply)
        self.probability.valueChanged.connect(self.on_slider)

    def on_apply(self):
        """Samples, and shows what is kept."""
        with slicer.util.tryWithErrorDisplay("willis cannot use these lines", waitCursor=True):
            self.logic.infer(self.lines.currentNode(), default_radius=self.radius.value)
            self.logic.show(self.probability.value)

    def on_slider(self, probability):
        """Shows what is kept at another probability, without sampling again."""
        if self.logic.run is not None:
            self.logic.show(probability)


class WillisTopologyLogic(ScriptedLoadableModuleLogic):
    """The work, which needs no window."""

    def __init__(self):
        super().__init__()
        self.run, self.output = None, None

    def infer(self, node, samples=1000, default_radius=None):
        """Samples the lines of a model, or of a curve, whose scene is RAS; ``default_radius`` is for those that have no radii, mm."""
        import willis

        lines = node.GetCurveWorld() if node.IsA("vtkMRMLMarkupsCurveNode") else node.GetPolyData()
        self.run = willis.infer(willis.from_vtk(lines, default_radius=default_radius, frame="RAS"), samples=samples, progress=False)
        self.output = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode", f"{node.GetName()} topology")
        return self.run

    def show(self, probability):
        """Puts the connections of at least so much probability into the output, beside what was observed."""
        self.output.SetAndObservePolyData(self.run.rekeep(f"probability={probability!r}").topology.to_vtk())
        self.output.CreateDefaultDisplayNodes()
