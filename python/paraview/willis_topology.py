"""A filter of ParaView: candidates in, the plausible topology out, with a slider on the probability.

Tools > Manage Plugins > Load New, this file; then Filters > Alphabetical > Willis Topology. The Python of ParaView must find the package
`willis` (`PYTHONPATH`, or `pvpython -m pip install`).
"""

from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase, smdomain, smhint, smproperty, smproxy
from vtkmodules.vtkCommonDataModel import vtkPolyData

import willis


@smproxy.filter(name="WillisTopology", label="Willis Topology")
@smproperty.input(name="Input", port_index=0)
@smdomain.datatype(dataTypes=["vtkPolyData"], composite_data_supported=False)
class WillisTopology(VTKPythonAlgorithmBase):
    """Lines with radii, mm, to the vessels that are likely to be there; samples again only when its input or their number changes."""

    def __init__(self):
        super().__init__(nInputPorts=1, nOutputPorts=1, inputType="vtkPolyData", outputType="vtkPolyData")
        self._probability, self._samples, self._radius = 0.5, 1000, ""
        self._made_of, self._run = None, None

    @smproperty.doublevector(name="Probability", default_values=0.5)
    @smdomain.doublerange(min=0.0, max=1.0)
    @smhint.xml("""<Property name="Probability"/>""")
    def SetProbability(self, probability):
        """The least probability of a connection that is kept."""
        if probability != self._probability:
            self._probability = probability
            self.Modified()

    @smproperty.intvector(name="Samples", default_values=1000)
    @smdomain.intrange(min=64, max=100000)
    def SetSamples(self, samples):
        """How many networks are drawn at random."""
        if samples != self._samples:
            self._samples = samples
            self.Modified()

    @smproperty.stringvector(name="RadiusArray", default_values="")
    def SetRadiusArray(self, name):
        """The point array that holds the radii, when it has an unusual name."""
        if name != self._radius:
            self._radius = name
            self.Modified()

    def RequestData(self, request, inputs, outputs):
        """Runs when ParaView wants the output."""
        lines = vtkPolyData.GetData(inputs[0], 0)
        made_of = (lines.__this__, lines.GetMTime(), self._samples, self._radius)
        if made_of != self._made_of:
            network = willis.from_vtk(lines, radius_array=self._radius or None)
            self._run = willis.infer(network, samples=self._samples, progress=False)
            self._made_of = made_of
        kept = self._run.rekeep(f"probability={self._probability!r}").topology
        vtkPolyData.GetData(outputs, 0).ShallowCopy(kept.to_vtk())
        return 1
