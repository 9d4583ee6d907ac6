// A parallel projection that rotates about the point in the middle of the view.
const along = {
  z: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  y: [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  x: [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
};

class Camera {
  constructor(points) {
    this.points = points;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < points.length; i += 4) {
      for (let axis = 0; axis < 3; axis++) {
        low[axis] = Math.min(low[axis], points[i + axis]);
        high[axis] = Math.max(high[axis], points[i + axis]);
      }
    }
    const extent = high.map((h, axis) => h - low[axis]);
    this.middle = low.map((l, axis) => l <= high[axis] ? (l + high[axis]) / 2 : 0);
    // Half of the depth that the projection holds, whichever way it is turned.
    this.depth = Math.hypot(...extent.filter(Number.isFinite)) || 1;
    this.size = [300, 150];
    this.home = extent[2] < 0.35 * Math.max(extent[0], extent[1]) ? "z" : "y";
    this.along = along;
    this.look(this.home);
  }

  // Looks along an axis and fits all.
  look(axis) {
    this.turn = this.along[axis].map(row => [...row]);
    this.fit();
  }

  // Puts all points into the view; `mm` is then how many of them one pixel spans.
  fit() {
    const [right, up] = this.turn;
    let [west, east, south, north] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let i = 0; i < this.points.length; i += 4) {
      const p = [0, 1, 2].map(axis => this.points[i + axis] - this.middle[axis]);
      const x = dot(right, p), y = dot(up, p), r = this.points[i + 3];
      west = Math.min(west, x - r); east = Math.max(east, x + r);
      south = Math.min(south, y - r); north = Math.max(north, y + r);
    }
    if (!(west <= east)) [west, east, south, north] = [-1, 1, -1, 1];
    this.centre = this.middle.map((m, axis) => m + right[axis] * (west + east) / 2 + up[axis] * (south + north) / 2);
    this.mm = 1.08 * Math.max((east - west) / this.size[0], (north - south) / this.size[1], 1e-9);
    this.fitted = this.mm;
  }

  // The view that shows a sphere around a place (mm), turned so that a direction lies across the reader's sight.
  around(at, reach, direction) {
    let [right, up, back] = this.turn;
    const length = direction ? Math.hypot(...direction) : 0;
    const d = length > 0 ? direction.map(x => x / length) : null, seen = d ? dot(d, back) : 0;
    if (d && Math.abs(seen) > 0.45) {
      back = unit(back.map((x, i) => x - seen * d[i]));
      if (!back.every(Number.isFinite)) back = unit(cross(d, right));
      const across = cross(up, back);
      [right, up, back] = orthonormal(across, up.map((x, i) => x - dot(up, back) * back[i]));
    }
    const mm = Math.max(2 * reach / Math.min(...this.size), this.fitted / 2000);
    return { turn: [right, up, back], centre: [...at], mm };
  }

  // The view that fits some points, given as [x, y, z].
  fitting(points) {
    const low = [0, 1, 2].map(axis => Math.min(...points.map(p => p[axis]))), high = [0, 1, 2].map(axis => Math.max(...points.map(p => p[axis])));
    const middle = low.map((l, axis) => (l + high[axis]) / 2);
    return this.around(middle, 1.15 * Math.max(...points.map(p => Math.hypot(...p.map((x, axis) => x - middle[axis])))) + 3, null);
  }

  // Part of the way (from 0 to 1) from one view to another.
  between(a, b, share) {
    const mix = (p, q) => p.map((x, i) => x + share * (q[i] - x));
    this.turn = orthonormal(mix(a.turn[0], b.turn[0]), mix(a.turn[1], b.turn[1]));
    this.centre = mix(a.centre, b.centre);
    this.mm = Math.exp(Math.log(a.mm) + share * (Math.log(b.mm) - Math.log(a.mm)));
  }

  // A view of another size, in pixels, keeps what it showed.
  resize(size) {
    const [old, fitted] = [this.mm, this.fitted];
    this.size = size;
    const centre = this.centre;
    this.fit();
    if (old !== fitted) { this.mm = this.fitted * old / fitted; this.centre = centre; }
  }

  // Turns by angles about the vertical and the horizontal of the view.
  orbit(across, down) {
    const [c, s, d, e] = [Math.cos(across), Math.sin(across), Math.cos(down), Math.sin(down)];
    const [x, y, z] = this.turn;
    const a = x.map((v, i) => c * v + s * z[i]), b = z.map((v, i) => c * v - s * x[i]);
    const up = y.map((v, i) => d * v - e * b[i]);
    this.turn = orthonormal(a, up);
  }

  // Moves the scene by pixels.
  pan(dx, dy) {
    const [right, up] = this.turn;
    this.centre = this.centre.map((c, axis) => c - this.mm * (right[axis] * dx - up[axis] * dy));
  }

  // Zooms by a factor, keeping what is at a place (pixels from the middle, y down) where it is.
  zoom(factor, x = 0, y = 0) {
    const mm = Math.min(Math.max(this.mm / factor, this.fitted / 2000), this.fitted * 10);
    const by = 1 - mm / this.mm;
    const [right, up] = this.turn;
    this.centre = this.centre.map((c, axis) => c + by * this.mm * (right[axis] * x - up[axis] * y));
    this.mm = mm;
  }

  // A place of the scene in the view: pixels from its middle, x right and y down, and mm towards the reader.
  project(points, at) {
    const p = [points[at] - this.centre[0], points[at + 1] - this.centre[1], points[at + 2] - this.centre[2]];
    return [dot(this.turn[0], p) / this.mm, -dot(this.turn[1], p) / this.mm, dot(this.turn[2], p)];
  }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => a.map(v => v / Math.hypot(...a));

// Three axes at right angles, so that rounding never shears the view.
function orthonormal(x, y) {
  const right = unit(x);
  const up = unit(y.map((v, i) => v - dot(right, y) * right[i]));
  return [right, up, cross(right, up)];
}
