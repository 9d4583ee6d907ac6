// Three slices of the segmentation through a place, with the courses of the vessels near each slice. A slider, or the wheel, moves a slice.
// How far a slice reaches from the place, and vessels from a slice, mm; its pixels.
const SLICE_REACH = 12, SLAB = 0.75, ACROSS_SLICE = 160;
const PLANES = { z: "axial", y: "coronal", x: "sagittal" };

class Slices {
  constructor(segmentation, shape, frame, views) {
    Object.assign(this, { segmentation, shape, frame, views });
    this.inside = voxelsOf(segmentation);
    this.inverse = inverseOf(segmentation.affine);
  }

  // The figures of a vessel; `others` are drawn too where they are not kept.
  of(row, others, isShown) {
    const at = this.shape.middle(row);
    const each = Object.keys(PLANES).map(view => {
      const canvas = make("canvas", { width: ACROSS_SLICE, height: ACROSS_SLICE, role: "img" });
      const slider = make("input", { type: "range", min: -8, max: 8, step: 0.25, value: 0, "aria-label": `Move the ${this.name(view)} slice, mm` });
      const label = make("figcaption");
      const show = () => {
        const by = Number(slider.value);
        this.paint(canvas.getContext("2d"), view, at, by, one => one === row ? "#c8102e" : others.includes(one) ? "#d98200" : isShown(one) ? "#1f6fb2" : null);
        label.textContent = `${this.name(view)}${by ? `, ${by > 0 ? "+" : "−"}${Math.abs(by)} mm` : ""}`;
        canvas.setAttribute("aria-label", `${this.name(view)} slice of the segmentation, ${by} mm from the middle of the connection`);
      };
      slider.addEventListener("input", show);
      canvas.addEventListener("wheel", event => { event.preventDefault(); slider.value = Number(slider.value) + (event.deltaY > 0 ? -0.5 : 0.5); show(); }, { passive: false });
      show();
      return make("figure", {}, canvas, slider, label);
    });
    return make("div", { class: "slices" }, ...each);
  }

  name(view) {
    return this.frame in ANATOMICAL ? PLANES[view] : `along ${view}`;
  }

  paint(ink, view, at, by, colourOf) {
    const [right, up, near] = this.views[view], n = ACROSS_SLICE, mm = 2 * SLICE_REACH / n, { shape: [nx, ny, nz], block } = this.segmentation;
    const origin = at.map((x, k) => x + by * near[k]), image = ink.createImageData(n, n), w = this.inverse;
    for (let j = 0; j < n; j++) {
      for (let i = 0; i < n; i++) {
        const [a, b] = [(i + 0.5) * mm - SLICE_REACH, SLICE_REACH - (j + 0.5) * mm], p = origin.map((x, k) => x + a * right[k] + b * up[k]);
        const [x, y, z] = w.map(row => Math.round(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]));
        const is = x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz && this.inside[x + nx * (y + ny * z)];
        const grey = is ? 205 : 40;
        image.data.set([grey, grey, grey, 255], 4 * (i + n * j));
      }
    }
    ink.putImageData(image, 0, 0);
    ink.strokeStyle = "#ffffff90";
    ink.lineWidth = 1;
    const line = (...ends) => { ink.beginPath(); ink.moveTo(...ends[0]); ink.lineTo(...ends[1]); ink.stroke(); };
    for (const [from, to] of [[0, 0.4], [0.6, 1]]) {
      line([from * n, n / 2], [to * n, n / 2]);
      line([n / 2, from * n], [n / 2, to * n]);
    }
    const { points, starts, vessels } = this.shape.raw, slab = Math.max(SLAB, block > 1 ? 2 * SLAB : 0);
    const place = i => { const d = [0, 1, 2].map(k => points[4 * i + k] - origin[k]); return [n / 2 + dot(d, right) / mm, n / 2 - dot(d, up) / mm, dot(d, near)]; };
    ink.lineWidth = 2.5;
    for (let row = 0; row < vessels; row++) {
      const colour = colourOf(row);
      if (!colour) continue;
      ink.strokeStyle = colour;
      for (let i = starts[row]; i + 1 < starts[row + 1]; i++) {
        const [a, b] = [place(i), place(i + 1)];
        // The part of the segment within the slab.
        const t = [0, 1], rise = b[2] - a[2];
        for (const side of [-1, 1]) {
          const out = side * a[2] - slab, slope = side * rise;
          if (slope === 0) { if (out > 0) t[1] = -1; } else if (slope > 0) t[1] = Math.min(t[1], -out / slope); else t[0] = Math.max(t[0], -out / slope);
        }
        if (t[0] >= t[1]) continue;
        const on = s => [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])];
        line(on(t[0]), on(t[1]));
      }
    }
    const letters = DIRECTIONS[this.frame];
    if (!letters) return;
    ink.fillStyle = "#fff";
    ink.font = "bold 12px system-ui, sans-serif";
    ink.textBaseline = "middle";
    ink.textAlign = "center";
    const letter = axis => { const k = axis.findIndex(x => x !== 0); return letters[k][axis[k] > 0 ? 0 : 1]; };
    for (const [x, y, axis] of [[n - 8, n / 2, right], [8, n / 2, right.map(v => -v)], [n / 2, 8, up], [n / 2, n - 8, up.map(v => -v)]]) ink.fillText(letter(axis), x, y);
  }
}

// From mm to voxels.
function inverseOf(affine) {
  const [a, b, c] = affine.map(row => row.slice(0, 3)), cross = (u, v) => [0, 1, 2].map(k => u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
  const whole = dot(a, cross(b, c)), columns = [cross(b, c), cross(c, a), cross(a, b)], move = affine.map(row => row[3]);
  return [0, 1, 2].map(k => { const row = columns.map(column => column[k] / whole); return [...row, -dot(row, move)]; });
}
