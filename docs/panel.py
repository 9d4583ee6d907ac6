"""Draws docs/src/napari.png: the panel in napari with the scan of the repository, its plausible topology, its questions, and the names of its arteries.

Needs the packages of python/tests/napari.txt, an installed willis, and a screen with OpenGL; without one: xvfb-run -s "-screen 0 1600x1000x24" python docs/panel.py
"""
import sys
from pathlib import Path

import napari
import nibabel
import numpy as np
from qtpy.QtWidgets import QApplication

from willis._napari import Desk

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/src/napari.png"


def main():
    image = nibabel.load(ROOT / "data/scan.nii.gz")
    viewer = napari.Viewer(show=True)
    viewer.window.resize(1500, 900)
    layer = viewer.add_labels(np.asarray(image.dataobj).astype(np.uint8), affine=image.affine, units="mm", name="scan")
    desk = Desk(viewer)
    viewer.window.add_dock_widget(desk.panel, name="Arteries")
    desk.mask.value, desk.axes.value, desk.who.value = layer, "RAS", "A. Reader"
    desk.infer()()()
    desk.name_vessels()()()
    desk.folder.value, layer.visible = Path("/study"), False
    viewer.dims.ndisplay = 3
    # From the front and from below, as a face is seen.
    viewer.camera.set_view_direction((0, -1, 0.5), (0, 0.5, 1))
    for _ in range(20):
        QApplication.processEvents()
    viewer.screenshot(sys.argv[1] if len(sys.argv) > 1 else PICTURE, canvas_only=False, flash=False)
    viewer.close()


if __name__ == "__main__":
    main()
