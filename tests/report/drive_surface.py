"""The surface that a page makes of a segmentation, of shapes whose area, volume and Euler characteristic are known."""
import base64
import math
from pathlib import Path

import nibabel as nib
import numpy as np
from scipy.ndimage import map_coordinates

STEP = 0.5
ASSETS = Path(__file__).resolve().parents[2] / "crates/report/src/page/assets"
# The scripts of the page that make the surface, without the page's own data.
SCRIPTS = "".join((ASSETS / name).read_text().replace('const data = JSON.parse(byId("data").textContent);', "") for name in ("data.js", "surface.js"))


def run_lengths(inside):
    """Lengths of background and of vessel in turn, seven bits a byte; the last axis of `inside` runs fastest."""
    flat = np.concatenate([[False], inside.ravel(), [False]])
    out, before = bytearray(), 0
    for turn in map(int, np.flatnonzero(flat[1:] != flat[:-1])):
        length, before = turn - before, turn
        while length >= 128:
            out.append(length % 128 + 128)
            length //= 128
        out.append(length)
    return base64.b64encode(bytes(out)).decode()


def surface(page, inside):
    """Corners (mm) and triangles."""
    affine = [[STEP if row == column else 0 for column in range(3)] + [0] for row in range(3)]
    source = {"shape": inside.shape[::-1], "runs": run_lengths(inside), "affine": affine, "block": 1}
    places, triangles = page.driver.execute_script(SCRIPTS + "const s = surfaceOf(arguments[0]); return [Array.from(s.places), Array.from(s.triangles)]", source)
    return np.array(places).reshape(-1, 3), np.array(triangles, int).reshape(-1, 3)


def check_surface(page):
    """A ball and a ring: closed, turned outwards, of the right volume and area, with no corner further than half a voxel from a voxel's."""
    z, y, x = np.mgrid[-24:25, -24:25, -24:25]
    ball, ring = x**2 + y**2 + z**2 <= 18.3**2, (np.hypot(x, y) - 14) ** 2 + z**2 <= 6.3**2
    tube, way = 6.3 * STEP, 14 * STEP
    truths = [
        (ball, 2, 4 / 3 * math.pi * (18.3 * STEP) ** 3, 4 * math.pi * (18.3 * STEP) ** 2),
        (ring, 0, 2 * math.pi**2 * way * tube**2, 4 * math.pi**2 * way * tube),
    ]
    for inside, euler, volume, area in truths:
        places, triangles = surface(page, inside)
        edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        forth, back = set(map(tuple, edges)), set(map(tuple, edges[:, ::-1]))
        assert len(forth) == len(edges) and forth == back, "closed: every edge once each way"
        assert len(places) - len(edges) // 2 + len(triangles) == euler
        a, b, c = places[triangles].transpose(1, 0, 2)
        across = np.cross(b - a, c - a)
        assert math.isclose((a * across).sum() / 6, volume, rel_tol=0.03)
        # The faces of the voxels themselves have 1.5 times the area of a ball, and smoothing takes most of that excess away.
        assert 1 <= np.linalg.norm(across, axis=1).sum() / 2 / area < 1.1
        from_corner = np.abs(places / STEP - 0.5 - np.round(places / STEP - 0.5)).max()
        assert from_corner <= 0.451, from_corner


# To the right and up in a slice, by the frame of the run: the patient's right is on the left.
VIEWS = {
    "RAS": [([-1, 0, 0], [0, 1, 0]), ([-1, 0, 0], [0, 0, 1]), ([0, -1, 0], [0, 0, 1])],
    "LPS": [([1, 0, 0], [0, -1, 0]), ([1, 0, 0], [0, 0, 1]), ([0, 1, 0], [0, 0, 1])],
}


def shown(page):
    """The pixels of the slices, by row and column."""
    script = "return [...document.querySelectorAll('.slices canvas')].map(c => [c.width, [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data]])"
    return [np.array(pixels).reshape(n, n, 4) for n, pixels in page.driver.execute_script(script)]


def set_range(page, at, value):
    """Moves a slider of the slices, and waits."""
    page.driver.execute_script("const s = document.querySelectorAll(arguments[0])[arguments[1]]; s.value = arguments[2]; s.dispatchEvent(new Event('input'))", *at, value)
    page.settle()


def check_cube(page):
    """Slices through a connection show the image as SciPy interpolates it; the window, the slab and the plane across it change what is seen."""
    row = next(at for at in page.listed() if page.edges[at]["origin"] == "candidate")
    page.click(f"#review-list li[data-row='{row}'] .go")
    page.rest()
    image = nib.load(page.folder.parent / page.record["parameters"]["image"]["path"])
    values, inverse = np.asarray(image.dataobj, float), np.linalg.inv(image.affine)
    place = next(one for one in page.driver.execute_script("return JSON.parse(document.getElementById('data').textContent).image_places.of") if row in one["vessels"])
    low, high = place["shown"]
    pictures = shown(page)
    assert len(pictures) == 5, len(pictures)
    right, up = map(np.array, VIEWS["RAS"][0])
    n = pictures[0].shape[0]
    along = (np.arange(n) + 0.5) * 24 / n - 12
    centre = np.array([float(x) for x in page.one(".slices").get_attribute("data-at").split()])
    held = page.driver.execute_script("const i = JSON.parse(document.getElementById('data').textContent).image_places; return [i.side, i.step_mm]")
    # The cube as SciPy samples it, and the slice as SciPy samples the cube.
    offsets = (np.arange(held[0]) - (held[0] - 1) / 2) * held[1]
    grid = np.stack(np.meshgrid(*(c + offsets for c in place["centre"]), indexing="ij"), -1)
    sample = lambda field, voxel: map_coordinates(field, np.moveaxis(voxel, -1, 0), order=1, mode="nearest")
    cube = sample(values, nib.affines.apply_affine(inverse, grid))
    world = centre + along[None, :, None] * right - along[:, None, None] * up
    truth = np.clip(255 * (sample(cube, (world - place["centre"]) / held[1] + (held[0] - 1) / 2) - low) / (high - low), 0, 255)
    inner = (np.ptp(pictures[0][..., :3], axis=-1) == 0) & (np.abs(along)[:, None] < 8) & (np.abs(along)[None, :] < 8)
    off = np.abs(pictures[0][..., 0] - truth)[inner]
    # The image is seen as it is judged: its noise averaged over less than a voxel.
    assert inner.sum() > 3000 and np.median(off) < 6, (inner.sum(), np.median(off))
    assert np.corrcoef(pictures[0][..., 0][inner], truth[inner])[0, 1] > 0.9
    _, window, slab = ((".slice-controls input[type=range]", at) for at in range(3))
    set_range(page, slab, 9)
    thick = shown(page)
    assert all((b[..., 0].astype(int) - a[..., 0] >= -1)[(np.ptp(a[..., :3], axis=-1) == 0) & (np.ptp(b[..., :3], axis=-1) == 0)].all() for a, b in zip(pictures[:1], thick[:1]))
    set_range(page, slab, 0)
    set_range(page, window, high - low + (high - low) / 2)
    assert any((a != b).any() for a, b in zip(shown(page), pictures))
    set_range(page, window, high - low)
    set_range(page, (".slices input[type=range]", 4), 4)
    assert (shown(page)[4] != pictures[4]).any()


def check_slices(page):
    """The slices through a connection show the mask as nibabel reads it: axial, coronal, sagittal."""
    row = next(at for at in page.listed() if page.edges[at]["origin"] == "candidate")
    page.click(f"#review-list li[data-row='{row}'] .go")
    page.rest()
    page.driver.execute_script("const s = document.querySelector('.slice-controls select'); if (s) { s.value = 'segmentation'; s.dispatchEvent(new Event('change')); }")
    mask = nib.load(page.folder.parent / page.record["input"]["path"])
    inside, inverse = np.asarray(mask.dataobj) > 0, np.linalg.inv(mask.affine)
    middle = np.array([float(x) for x in page.one(".slices").get_attribute("data-at").split()])
    ends = np.array([[float(page.edges[row][f"{end}{axis}_mm"]) for axis in "xyz"] for end in "ab"])
    assert np.linalg.norm(middle - ends.mean(0)) <= float(page.edges[row]["length_mm"]) / 2
    seen, views = set(), 0
    for pixels, (right, up) in zip(shown(page), VIEWS[page.record["input"]["frame"]]):
        n = pixels.shape[0]
        along = (np.arange(n) + 0.5) * 24 / n - 12
        world = middle + along[None, :, None] * np.array(right) - along[:, None, None] * np.array(up)
        flip = -1 if page.record["input"]["frame"] == "LPS" else 1
        voxel = nib.affines.apply_affine(inverse, world * [flip, flip, 1])
        clear = np.abs(voxel - np.floor(voxel) - 0.5).min(-1) > 0.02
        at = np.round(voxel).astype(int)
        held = ((at >= 0) & (at < inside.shape)).all(-1)
        truth = np.zeros((n, n), bool)
        truth[held] = inside[tuple(at[held].T)]
        # Lines, the crosshair and letters lie over the rest.
        plain = clear & (np.ptp(pixels[..., :3], axis=-1) == 0) & np.isin(pixels[..., 0], (40, 205))
        if plain.sum() < n * n / 2:
            # The slice lies between two voxels.
            continue
        views += 1
        wrong = (pixels[..., 0] == 205)[plain] != truth[plain]
        assert wrong.mean() < 0.005, (right, up, wrong.mean())
        seen |= set(truth[plain].tolist())
    assert seen == {True, False} and views > 1, (seen, views)
