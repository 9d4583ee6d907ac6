// The view of the vessels: it paints after changes, and finds the vessel at a place.
// More markers than this would hide the vessels, so they are off at first.
const MANY = 200;
const MARKERS = { inlet: [20, 20, 20], outlet: [90, 90, 90], cut: [205, 30, 40], suggested: [235, 130, 0] };
const CUTS = new Set(["cut", "suggested"]);

class SceneView {
  constructor(source) {
    this.geometry = geometry(source);
    this.canvas = byId("canvas");
    this.camera = new Camera(this.geometry.points);
    this.looks = new Uint8Array(4 * (this.geometry.starts.length - 1));
    this.markersShown = this.geometry.markers.filter(([kind]) => !CUTS.has(kind)).length <= MANY;
    this.cutsShown = true;
    this.picked = -1;
    this.begin();
    this.geometry.markers.forEach(([kind], i) => this.looks.set(MARKERS[kind], 4 * (this.geometry.vessels + i)));
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    // A lost graphics context is restored automatically, but empty.
    this.canvas.addEventListener("webglcontextlost", event => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => { this.begin(); this.dress(); });
    this.resize();
  }

  begin() {
    try {
      this.painter = new GlPainter(this.canvas, this.geometry);
    } catch (reason) {
      if (this.canvas.getContext("2d") === null) {
        // The canvas is bound to the failed context, so a new one replaces it.
        const canvas = this.canvas.cloneNode();
        this.canvas.replaceWith(canvas);
        this.canvas = canvas;
      }
      this.painter = new LinePainter(this.canvas, this.geometry);
      const note = byId("canvas-note");
      note.textContent = `Drawn as flat lines because this browser has no WebGL 2 (${reason.message}).`;
      note.hidden = false;
    }
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.canvas.width = Math.round(w * ratio);
    this.canvas.height = Math.round(h * ratio);
    this.camera.resize([w, h]);
    this.paint();
  }

  // The appearance of each vessel: its colour and LOOK.
  dress(colour, state) {
    if (colour) [this.colour, this.state] = [colour, state];
    for (let row = 0; row < this.geometry.vessels; row++) {
      this.looks.set(this.colour(row), 4 * row);
      this.looks[4 * row + 3] = this.state(row) | (row === this.picked ? LOOK.picked : 0);
    }
    for (let i = this.geometry.vessels; 4 * i < this.looks.length; i++) {
      const kind = this.geometry.markers[i - this.geometry.vessels][0];
      const shown = CUTS.has(kind) ? this.cutsShown : this.markersShown;
      this.looks[4 * i + 3] = LOOK.marker | (kind === "inlet" ? LOOK.inlet : 0) | (shown ? 0 : LOOK.hidden);
    }
    this.painter.dress(this.looks);
    this.paint();
  }

  // Marks a vessel, and moves the view to it when it is outside.
  pick(row) {
    this.picked = row;
    if (row >= 0) {
      const { points, starts } = this.geometry, at = 4 * Math.floor((starts[row] + starts[row + 1]) / 2);
      const [x, y] = this.camera.project(points, at), [w, h] = this.camera.size;
      if (Math.abs(x) > 0.48 * w || Math.abs(y) > 0.48 * h) this.camera.pan(-x, -y);
    }
    this.dress();
  }

  // Paints once before the next frame of the browser.
  paint() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      if (!this.colour) return;
      this.painter.paint(this.camera);
      this.showScaleBar();
    });
  }

  showScaleBar() {
    const bar = byId("scale-bar"), widest = Math.min(120, this.camera.size[0] / 3) * this.camera.mm;
    const ten = 10 ** Math.floor(Math.log10(widest));
    const length = [5, 2, 1].map(m => m * ten).find(l => l <= widest) || ten;
    bar.style.width = `${length / this.camera.mm}px`;
    bar.firstElementChild.textContent = `${shown(length, 3)} mm`;
  }

  // The frontmost vessel at a place of the view, in pixels from its middle; -1 without one.
  at(x, y, room) {
    const { points, starts, vessels } = this.geometry;
    let found = -1, best = [Infinity, -Infinity];
    for (let row = 0; row < vessels; row++) {
      if (this.looks[4 * row + 3] & LOOK.hidden) continue;
      let a = this.camera.project(points, 4 * starts[row]);
      for (let i = starts[row] + 1; i < starts[row + 1]; i++) {
        const b = this.camera.project(points, 4 * i), radius = points[4 * i + 3] / this.camera.mm;
        const [dx, dy] = [b[0] - a[0], b[1] - a[1]], length = dx * dx + dy * dy;
        const t = length > 0 ? Math.min(Math.max(((x - a[0]) * dx + (y - a[1]) * dy) / length, 0), 1) : 0;
        const off = Math.max(Math.hypot(x - a[0] - t * dx, y - a[1] - t * dy) - radius, 0), near = a[2] + t * (b[2] - a[2]) + points[4 * i + 3];
        if (off < room && (off < best[0] || (off === best[0] && near > best[1]))) [found, best] = [row, [off, near]];
        a = b;
      }
    }
    return found;
  }
}
