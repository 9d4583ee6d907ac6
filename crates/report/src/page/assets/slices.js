// Slices of the image, or of the segmentation, through a place, with the courses of the vessels near each slice: along the axes of the
// patient, along the connection straightened, and across it. A slider, or the wheel, moves a slice.
// How far a slice reaches from the place, and vessels from a slice, mm; its pixels.
const SLICE_REACH = 12, SLAB = 0.75, ACROSS_SLICE = 160;
const PLANES = { z: "axial", y: "coronal", x: "sagittal" };
// A shorter connection has no course, mm.
const NO_COURSE = 0.5;

// Values by place (mm): 1 inside of the segmentation, else 0.
class MaskVolume {
  constructor(segmentation) {
    Object.assign(this, { inside: voxelsOf(segmentation), shape: segmentation.shape, inverse: inverseOf(segmentation.affine), name: "segmentation" });
  }

  value(p) {
    const { shape: [nx, ny, nz] } = this, [x, y, z] = this.inverse.map(row => Math.round(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]));
    return x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz ? this.inside[x + nx * (y + ny * z)] : 0;
  }

  grey(value) {
    return value ? 205 : 40;
  }
}

// Values of the image in a cube, between samples by its eight neighbours; NaN outside.
class CubeVolume {
  constructor({ centre, held, shown, is_dark: dark, samples }, { side, step_mm }) {
    Object.assign(this, { centre, held, shown, dark, side, step: step_mm, samples: decoded("u8", samples), name: "image" });
  }

  value(p) {
    const { side, samples, held } = this, at = p.map((x, k) => (x - this.centre[k]) / this.step + (side - 1) / 2), low = at.map(Math.floor);
    if (low.some(x => x < 0 || x > side - 2)) return NaN;
    let sum = 0;
    for (let corner = 0; corner < 8; corner++) {
      const bits = [corner & 1, corner >> 1 & 1, corner >> 2], sample = samples[low[0] + bits[0] + side * (low[1] + bits[1] + side * (low[2] + bits[2]))];
      if (!sample) return NaN;
      sum += sample * bits.reduce((share, bit, k) => share * (bit ? at[k] - low[k] : 1 - at[k] + low[k]), 1);
    }
    return held[0] + (sum - 1) / 254 * (held[1] - held[0]);
  }
}

class Slices {
  // `views`: to the right, up, and towards the reader along each axis.
  constructor(segmentation, images, shape, frame, views) {
    Object.assign(this, { images, shape, frame, views, coarse: segmentation?.block > 1 });
    this.mask = segmentation && new MaskVolume(segmentation);
    // What the reader set: level and window in units of the image, thickness of the slab in mm, which of the two is shown.
    this.set = { level: null, window: null, slab: 0, of: "image" };
  }

  // What is there to be shown of a vessel.
  volumes(row) {
    const place = this.images.of.find(one => one.vessels.includes(row));
    return [place && new CubeVolume(place, this.images), this.mask].filter(Boolean);
  }

  // The figures of a vessel; null where nothing is to be seen. `others` are drawn too where they are not kept.
  of(row, others, isShown) {
    const volumes = this.volumes(row), { set } = this;
    if (!volumes.length) return null;
    const colourOf = one => one === row ? "#c8102e" : others.includes(one) ? "#d98200" : isShown(one) ? "#1f6fb2" : null;
    const shows = [];
    const current = () => volumes.find(volume => volume.name === set.of) ?? volumes[0];
    const figure = view => {
      const canvas = make("canvas", { width: ACROSS_SLICE, height: ACROSS_SLICE, role: "img" });
      const slider = make("input", { type: "range", ...view.range, value: 0, "aria-label": `Move: ${view.name}, ${view.unit}` });
      const label = make("figcaption");
      const show = () => {
        const by = Number(slider.value);
        this.paint(canvas.getContext("2d"), current(), view.at(by), colourOf);
        label.textContent = `${view.name}${by ? `, ${by > 0 ? "+" : "−"}${Math.abs(by)} ${view.unit}` : ""}`;
        canvas.setAttribute("aria-label", `${view.name} slice of the ${current().name}, ${by} ${view.unit} from the middle of the connection`);
      };
      slider.addEventListener("input", show);
      canvas.addEventListener("wheel", event => { event.preventDefault(); slider.value = Number(slider.value) + (event.deltaY > 0 ? -2 : 2) * view.range.step; show(); }, { passive: false });
      shows.push(show);
      return make("figure", {}, canvas, slider, label);
    };
    const figures = this.viewsOf(row).map(figure), again = () => shows.forEach(show => show());
    const controls = volumes[0].name === "image" ? this.controls(volumes, again) : null;
    again();
    return make("div", {}, make("div", { class: "slices", "data-at": this.shape.middle(row).join(" ") }, ...figures), ...(controls ? [controls] : []));
  }

  // Level, window and slab of the image, and what is shown.
  controls(volumes, again) {
    const { set } = this, { held } = volumes[0], whole = held[1] - held[0], [black, white] = this.shownOf(volumes[0]), step = whole / 200;
    const slider = (name, key, range, value) => {
      const input = make("input", { type: "range", ...range, input: () => { set[key] = Number(input.value); again(); } });
      input.value = value;
      return make("label", {}, `${name} `, input);
    };
    const parts = [slider("Level", "level", { min: held[0], max: held[1], step }, (black + white) / 2), slider("Window", "window", { min: step, max: whole, step }, white - black),
      slider("Slab, mm", "slab", { min: 0, max: 12, step: 0.6 }, set.slab)];
    if (volumes.length > 1) {
      const choice = make("select", {}, ...volumes.map(({ name }) => make("option", { value: name, text: name })));
      choice.value = set.of;
      choice.addEventListener("change", () => { set.of = choice.value; again(); });
      parts.push(make("label", {}, "Show ", choice));
    }
    return make("div", { class: "row slice-controls" }, ...parts);
  }

  // The planes through the middle of a vessel, and those of its course. `at(by)` tells where a slice lies that was moved: its origin, to
  // the right, up and towards the reader; of the straightened one `bent`, the place that a distance along the course stands for.
  viewsOf(row) {
    const origin = this.shape.middle(row), course = this.shape.course(row);
    const plane = axis => {
      const [right, up, near] = this.views[axis];
      return { name: this.frame in ANATOMICAL ? PLANES[axis] : `along ${axis}`, unit: "mm", range: { min: -8, max: 8, step: 0.25 },
        at: by => ({ origin: origin.map((x, k) => x + by * near[k]), right, up, near, letters: true }) };
    };
    const planes = Object.keys(PLANES).map(plane);
    if (course.length < NO_COURSE) return planes;
    const chord = unit(course.at(0.5).at.map((x, k) => x - course.at(-0.5).at[k])), far = chord.map(Math.abs), least = far.indexOf(Math.min(...far));
    const fixed = [0, 1, 2].map(k => k === least ? 1 : 0);
    const across = s => { const { at, towards } = course.at(s); return { at, near: towards, right: unit(fixed.map((x, k) => x - dot(fixed, towards) * towards[k])) }; };
    const square = s => { const { at, near, right } = across(s); return { origin: at, right, up: cross(near, right), near }; };
    return [...planes,
      { name: "straightened", unit: "°", range: { min: -90, max: 90, step: 5 }, at: turn => {
        const [c, s] = [Math.cos(turn * Math.PI / 180), Math.sin(turn * Math.PI / 180)];
        return { ...square(0), length: course.length, bent: a => { const { origin: from, right, up } = square(a); return { from, up: right.map((x, k) => c * x + s * up[k]), near: right.map((x, k) => c * up[k] - s * x) }; } };
      } },
      { name: "across it", unit: "mm", range: { min: -10, max: 10, step: 0.25 }, at: square }];
  }

  // How bright the pixels are: the brightest within the slab, or the darkest where vessels are dark.
  pixels(volume, { origin, right, up, near, bent }) {
    const n = ACROSS_SLICE, mm = 2 * SLICE_REACH / n, { set } = this, isImage = volume.name === "image", half = isImage ? set.slab / 2 : 0;
    const [low, high] = isImage ? this.shownOf(volume) : [0, 1], pick = volume.dark ? Math.min : Math.max, data = new Uint8ClampedArray(4 * n * n);
    for (let i = 0; i < n; i++) {
      const a = (i + 0.5) * mm - SLICE_REACH, line = bent?.(a) ?? { from: origin.map((x, k) => x + a * right[k]), up, near };
      for (let j = 0; j < n; j++) {
        const b = SLICE_REACH - (j + 0.5) * mm, p = line.from.map((x, k) => x + b * line.up[k]);
        let value = NaN;
        for (let off = -half; off <= half + 1e-9; off += 0.6) {
          const here = volume.value(off ? p.map((x, k) => x + off * line.near[k]) : p);
          if (!Number.isNaN(here)) value = Number.isNaN(value) ? here : pick(value, here);
        }
        const grey = isImage ? 255 * (value - low) / (high - low) || 0 : volume.grey(value);
        data.set([grey, grey, grey, 255], 4 * (i + n * j));
      }
    }
    return new ImageData(data, n, n);
  }

  // What is black and what is white.
  shownOf({ shown }) {
    const middle = this.set.level ?? (shown[0] + shown[1]) / 2, wide = this.set.window ?? shown[1] - shown[0];
    return [middle - wide / 2, middle + wide / 2];
  }

  paint(ink, volume, slice, colourOf) {
    const { origin, right, up, near } = slice, n = ACROSS_SLICE, mm = 2 * SLICE_REACH / n;
    ink.putImageData(this.pixels(volume, slice), 0, 0);
    ink.strokeStyle = "#ffffff90";
    ink.lineWidth = 1;
    const line = (...ends) => { ink.beginPath(); ink.moveTo(...ends[0]); ink.lineTo(...ends[1]); ink.stroke(); };
    for (const [from, to] of [[0, 0.4], [0.6, 1]]) {
      line([from * n, n / 2], [to * n, n / 2]);
      line([n / 2, from * n], [n / 2, to * n]);
    }
    if (slice.bent) {
      // The connection is a line from end to end.
      ink.lineWidth = 1.5;
      ink.strokeStyle = "#c8102e";
      for (const side of [-1, 1]) { const x = n / 2 + side * slice.length / 2 / mm; line([x, n / 2 - 8], [x, n / 2 + 8]); }
      return;
    }
    const { points, starts, vessels } = this.shape.raw, slab = Math.max(SLAB, this.coarse ? 2 * SLAB : 0, volume.name === "image" ? this.set.slab / 2 : 0);
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
    if (!letters || !slice.letters) return;
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
  const [a, b, c] = affine.map(row => row.slice(0, 3));
  const whole = dot(a, cross(b, c)), columns = [cross(b, c), cross(c, a), cross(a, b)], move = affine.map(row => row[3]);
  return [0, 1, 2].map(k => { const row = columns.map(column => column[k] / whole); return [...row, -dot(row, move)]; });
}
