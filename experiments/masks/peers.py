"""Times of the same steps by scikit-image, edt and skan, one core: peers.py MASK..."""
import sys
import time

import edt
import nibabel
import numpy as np
import skan
from skimage.morphology import skeletonize


def main():
    # skan compiles its functions when they are called first.
    line = np.zeros((9, 9, 9), bool)
    line[4, 4, 1:8] = True
    skan.Skeleton(line)
    print("mask,thinning_s,distance_s,graph_s")
    for path in sys.argv[1:]:
        image = nibabel.load(path)
        mask = np.ascontiguousarray(np.asarray(image.dataobj) > 0)
        spacing = tuple(float(x) for x in image.header.get_zooms()[:3])
        times = [time.perf_counter()]
        thinned = skeletonize(mask, method="lee") > 0
        times.append(time.perf_counter())
        edt.edt(mask, anisotropy=spacing, parallel=1)
        times.append(time.perf_counter())
        skan.Skeleton(thinned, spacing=spacing)
        times.append(time.perf_counter())
        print(path.rsplit("/", 1)[1], *("%.2f" % x for x in np.diff(times)), sep=",")


if __name__ == "__main__":
    main()
