// The vessels as they are drawn: smoothed along their course, for display only; and what the course says where vessels meet.
const MOST_POINTS = 400000;
// Radii are averaged over so many radii to either side.
const REACH = 6;

class Shape {
  constructor(source, vessels) {
    this.raw = geometry(source);
    const { points, starts } = this.raw;
    const few = points.length / 4 < MOST_POINTS / 4;
    this.drawn = few ? smoothed(this.raw) : this.raw;
    this.ends = [vessels.find("node_a")?.values, vessels.find("node_b")?.values];
    this.at = null;
    this.points = points;
    this.starts = starts;
  }

  // A point, mm.
  place(i) {
    const { points } = this;
    return [points[4 * i], points[4 * i + 1], points[4 * i + 2]];
  }

  // How far a vessel with so many of its radii reaches from a place, mm.
  reach(row, at, radii) {
    let reach = 0;
    for (let i = this.starts[row]; i < this.starts[row + 1]; i++) reach = Math.max(reach, Math.hypot(...this.place(i).map((x, k) => x - at[k])) + radii * this.points[4 * i + 3]);
    return reach;
  }

  // The middle of a vessel along its course, mm.
  middle(row) {
    return this.course(row).at(0).at;
  }

  // The course of a vessel: its length, and where it is and where it goes at a distance (mm) from its middle, straight on beyond its ends.
  course(row) {
    const { starts } = this, line = [];
    for (let i = starts[row]; i < starts[row + 1]; i++) {
      const p = this.place(i), last = line.at(-1), step = last ? Math.hypot(...p.map((x, k) => x - last.p[k])) : 0;
      if (!last || step > 0) line.push({ p, s: last ? last.s + step : 0 });
    }
    const length = line.at(-1).s;
    const at = by => {
      const s = by + length / 2;
      let k = 1;
      while (k < line.length - 1 && line[k].s < s) k += 1;
      const [a, b] = [line[k - 1], line[k]], towards = b ? b.p.map((x, i) => (x - a.p[i]) / (b.s - a.s)) : [0, 0, 0];
      return { at: a.p.map((x, i) => x + (s - a.s) * towards[i]), towards };
    };
    return { length, at };
  }

  // The direction in which a vessel leaves one of its ends, over some radii, and its radius there.
  leaving(row, end) {
    const { points, starts } = this, step = end === 0 ? 1 : -1;
    const first = end === 0 ? starts[row] : starts[row + 1] - 1, last = end === 0 ? starts[row + 1] - 1 : starts[row];
    const from = this.place(first), far = Math.max(6 * points[4 * first + 3], 2);
    let i = first;
    while (i !== last && Math.hypot(...this.place(i).map((x, axis) => x - from[axis])) < far) i += step;
    return { towards: this.place(i).map((x, axis) => x - from[axis]), radius: points[4 * first + 3] };
  }

  // The bend (degrees) and the radius (mm) at both ends of a connection: against the vessel that goes on most nearly straight.
  junction(row, threshold) {
    const certain = () => upTo(threshold.rows).filter(other => !threshold.uncertain[other]);
    this.at ??= listedBy(certain().flatMap(other => this.ends.map((of, end) => [of[other], [other, end]])));
    const bends = [], radii = [];
    for (const end of [0, 1]) {
      const mine = this.leaving(row, end).towards;
      const met = (this.at.get(this.ends[end][row]) || []).map(([other, of]) => this.leaving(other, of));
      const angle = ({ towards }) => 180 / Math.PI * Math.acos(Math.min(Math.max(-dot(mine, towards) / (Math.hypot(...mine) * Math.hypot(...towards)), -1), 1));
      const best = met.map(way => [angle(way), way.radius]).filter(([bend]) => !Number.isNaN(bend)).sort((a, b) => a[0] - b[0])[0];
      bends.push(best ? best[0] : NaN);
      radii.push(best ? best[1] : NaN);
    }
    return { bends, radii };
  }
}

// Averages the radius along each vessel, and rounds its corners (Catmull & Rom 1974); the ends stay.
function smoothed({ points, starts, vessels, markers }) {
  const out = [], first = [0];
  for (let item = 0; item + 1 < starts.length; item++) {
    const [from, to] = [starts[item], starts[item + 1]], n = to - from;
    if (n < 3) {
      for (let i = 4 * from; i < 4 * to; i++) out.push(points[i]);
    } else {
      const along = new Float64Array(n);
      for (let i = 1; i < n; i++) along[i] = along[i - 1] + Math.hypot(...[0, 1, 2].map(axis => points[4 * (from + i) + axis] - points[4 * (from + i - 1) + axis]));
      const radius = smoothRadii(points, from, along);
      curve(points, from, along, radius, out);
    }
    first.push(out.length / 4);
  }
  return { points: Float32Array.from(out), starts: first, vessels, markers };
}

// The mean of the piecewise linear radius around each point, by the trapezoid rule.
function smoothRadii(points, from, along) {
  const n = along.length, radius = i => points[4 * (from + i) + 3], sum = new Float64Array(n);
  for (let i = 1; i < n; i++) sum[i] = sum[i - 1] + 0.5 * (radius(i) + radius(i - 1)) * (along[i] - along[i - 1]);
  const mean = sum[n - 1] / (along[n - 1] || 1);
  const integral = s => {
    let low = 0, high = n - 1;
    while (high - low > 1) { const mid = (low + high) >> 1; if (along[mid] <= s) low = mid; else high = mid; }
    const part = s - along[low], whole = along[high] - along[low] || 1, end = radius(low) + (radius(high) - radius(low)) * part / whole;
    return sum[low] + 0.5 * (radius(low) + end) * part;
  };
  return Float64Array.from(along, s => {
    const [a, b] = [Math.max(s - REACH * mean, 0), Math.min(s + REACH * mean, along[n - 1])];
    return b > a ? (integral(b) - integral(a)) / (b - a) : mean;
  });
}

// More points where the course bends, so that it looks round.
function curve(points, from, along, radius, out) {
  const n = along.length, last = n - 1;
  const place = i => { const at = 4 * (from + Math.min(Math.max(i, 0), last)); return [points[at], points[at + 1], points[at + 2]]; };
  // The course without the noise of its points: each inner point moves halfway towards its neighbours.
  const calm = i => { const p = place(i); if (i <= 0 || i >= last) return p; const [a, b] = [place(i - 1), place(i + 1)], t = (along[i] - along[i - 1]) / ((along[i + 1] - along[i - 1]) || 1); return p.map((x, axis) => 0.5 * x + 0.5 * (a[axis] + t * (b[axis] - a[axis]))); };
  const near = Array.from({ length: n }, (_, i) => {
    const p = place(i), q = calm(i), by = Math.hypot(...q.map((x, axis) => x - p[axis])), most = 0.3 * radius[i];
    return by > most ? p.map((x, axis) => x + (q[axis] - x) * most / by) : q;
  });
  const at = i => near[Math.min(Math.max(i, 0), last)];
  const bend = i => {
    if (i <= 0 || i >= last) return 0;
    const [u, v] = [at(i).map((x, axis) => x - at(i - 1)[axis]), at(i + 1).map((x, axis) => x - at(i)[axis])];
    return Math.acos(Math.min(Math.max(dot(u, v) / (Math.hypot(...u) * Math.hypot(...v) || 1), -1), 1));
  };
  for (let i = 0; i < last; i++) {
    const [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
    const pieces = Math.min(Math.max(Math.ceil(Math.max(bend(i), bend(i + 1)) / 0.15), 1), 6);
    const length = along[i + 1] - along[i];
    const tangent = (p, q, span) => q.map((x, axis) => span > 0 ? (x - p[axis]) / span * length : 0);
    const u = tangent(a, c, along[Math.min(i + 1, last)] - along[Math.max(i - 1, 0)]), v = tangent(b, d, along[Math.min(i + 2, last)] - along[i]);
    for (let k = 0; k < pieces; k++) {
      const t = k / pieces, t2 = t * t, t3 = t2 * t;
      for (let axis = 0; axis < 3; axis++) {
        out.push((2 * t3 - 3 * t2 + 1) * b[axis] + (t3 - 2 * t2 + t) * u[axis] + (3 * t2 - 2 * t3) * c[axis] + (t3 - t2) * v[axis]);
      }
      out.push(radius[i] + t * (radius[i + 1] - radius[i]));
    }
  }
  out.push(...at(last), radius[last]);
}
