// The view of the vessels: it paints after changes, flies to places, and finds the vessel at a place.
// More markers than this would hide the vessels, so they are off at first.
const MANY = 200;
const MARKERS = { inlet: [20, 20, 20], outlet: [90, 90, 90], cut: [205, 30, 40], suggested: [235, 130, 0] };
const CUTS = new Set(["cut", "suggested"]);
// The views along the axes of a known frame: from the front, from the left, from below, as radiologists see them.
const ANATOMICAL = {
  RAS: { y: [[-1, 0, 0], [0, 0, 1], [0, 1, 0]], x: [[0, -1, 0], [0, 0, 1], [-1, 0, 0]], z: [[-1, 0, 0], [0, 1, 0], [0, 0, -1]] },
  LPS: { y: [[1, 0, 0], [0, 0, 1], [0, -1, 0]], x: [[0, 1, 0], [0, 0, 1], [1, 0, 0]], z: [[1, 0, 0], [0, -1, 0], [0, 0, -1]] },
};
// The direction from what labels call right to what they call left; null where they name neither, or where no axis points there.
function sidesOf(shape, vessels) {
  const sum = { L: [0, 0, 0, 0], R: [0, 0, 0, 0] };
  for (let row = 0; row < vessels.rows; row++) {
    const side = /^([LR])-/.exec(nameOf(row))?.[1];
    if (side) [...shape.middle(row), 1].forEach((x, k) => { sum[side][k] += x; });
  }
  if (!sum.L[3] || !sum.R[3]) return null;
  const left = unit([0, 1, 2].map(k => sum.L[k] / sum.L[3] - sum.R[k] / sum.R[3])), axis = left.findIndex(x => Math.abs(x) > 0.8);
  return axis < 0 ? null : { left, axis, names: left[axis] > 0 ? ["L", "R"] : ["R", "L"] };
}

// The views along the axes from the side that has the patient's left on the viewer's right.
function asLabelled(left) {
  const turned = ([right, up, back]) => dot(right, left) < 0 ? [right.map(x => -x), up, back.map(x => -x)] : [right, up, back];
  return Object.fromEntries(Object.entries(along).map(([axis, view]) => [axis, turned(view)]));
}
const FLIGHT = 450;
// A frame with the surface that takes more (ms) is slow; so long after the last move (ms) the view rests.
const SLOW = 50, REST = 150;

class SceneView {
  constructor(source, vessels, frame, segmentation) {
    this.shape = new Shape(source, vessels);
    this.geometry = this.shape.raw;
    this.canvas = byId("canvas");
    this.over = byId("overlay");
    this.camera = new Camera(this.geometry.points);
    // Where no frame is known, labels may say where left and right are.
    const sides = ANATOMICAL[frame] ? null : sidesOf(this.shape, vessels);
    this.sidesOfLabels = sides !== null;
    this.camera.along = ANATOMICAL[frame] ?? (sides ? asLabelled(sides.left) : along);
    this.camera.look(this.camera.home);
    this.overlay = new Overlay(this, frame, sides);
    this.overlay.names = namesOf(this.shape, vessels);
    this.looks = new Uint8Array(4 * (this.geometry.starts.length - 1));
    this.markersShown = this.geometry.markers.filter(([kind]) => !CUTS.has(kind)).length <= MANY;
    this.cutsShown = true;
    this.certainShown = true;
    this.picked = -1;
    // The rows that stay when the neighbourhood of a vessel is isolated; the others become faint.
    this.near = null;
    // The segmentation around the vessels, and how far apart its voxels are, mm.
    this.hull = segmentation && surfaceOf(segmentation);
    this.hullShown = Boolean(this.hull);
    this.voxel = segmentation && Math.min(...[0, 1, 2].map(axis => Math.hypot(...segmentation.affine.map(row => row[axis]))));
    this.focus = [0, 0, 0, 0];
    this.begin(segmentation);
    this.geometry.markers.forEach(([kind], i) => this.looks.set(MARKERS[kind], 4 * (this.geometry.vessels + i)));
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.tone(dark.matches));
    // The printed page holds a picture, which needs no painting after the page has got another size.
    window.addEventListener("beforeprint", () => {
      this.tone(false, true);
      this.printed = this.picture();
      this.printed.className = "printed";
      byId("view").after(this.printed);
    });
    window.addEventListener("afterprint", () => {
      this.printed?.remove();
      this.tone(dark.matches);
    });
    this.tone(dark.matches);
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    // A lost graphics context is restored automatically, but empty.
    this.canvas.addEventListener("webglcontextlost", event => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => { this.begin(segmentation); this.tone(dark.matches); this.dress(); });
    this.resize();
  }

  // The vessels stand on white, or in dark mode on a softer grey, so that a colour means the same in both.
  tone(isDark, now) {
    const grey = isDark ? 216 : 255;
    this.paper = `rgb(${grey},${grey},${grey})`;
    this.painter.paper = [grey / 255, grey / 255, grey / 255];
    byId("view").style.background = this.paper;
    if (now) this.frame();
    else this.paint();
  }

  begin(segmentation) {
    try {
      this.painter = new GlPainter(this.canvas, this.shape.drawn, this.hull);
    } catch (reason) {
      if (this.canvas.getContext("2d") === null) {
        // The canvas is bound to the failed context, so a new one replaces it.
        const canvas = this.canvas.cloneNode();
        this.canvas.replaceWith(canvas);
        this.canvas = canvas;
      }
      this.painter = new LinePainter(this.canvas, this.geometry);
      const note = byId("canvas-note");
      this.hull = null;
      note.textContent = `Drawn as flat lines${segmentation ? ", and without the segmentation," : ""} because this browser has no WebGL 2 (${reason.message}).`;
      note.hidden = false;
    }
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h) return;
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    for (const canvas of [this.canvas, this.over]) {
      canvas.width = Math.round(w * this.ratio);
      canvas.height = Math.round(h * this.ratio);
    }
    this.camera.resize([w, h]);
    this.paint();
  }

  // The appearance of each vessel: its colour and LOOK.
  dress(colour, state) {
    if (colour) [this.colour, this.state] = [colour, state];
    for (let row = 0; row < this.geometry.vessels; row++) {
      this.looks.set(this.colour(row), 4 * row);
      this.looks[4 * row + 3] = this.state(row) | (row === this.picked ? LOOK.picked : 0) | (this.near && !this.near.has(row) ? (this.state(row) & LOOK.pruned ? LOOK.hidden : LOOK.faint) : 0);
    }
    for (let i = this.geometry.vessels; 4 * i < this.looks.length; i++) {
      const kind = this.geometry.markers[i - this.geometry.vessels][0];
      const shown = CUTS.has(kind) ? this.cutsShown : this.markersShown && this.certainShown;
      this.looks[4 * i + 3] = LOOK.marker | (kind === "inlet" ? LOOK.inlet : 0) | (CUTS.has(kind) ? LOOK.top : 0) | (shown && !this.near ? 0 : LOOK.hidden);
    }
    this.painter.dress(this.looks);
    this.paint();
  }

  // Marks a vessel with a ring; -1 for none.
  pick(row) {
    this.picked = row;
    this.overlay.picked = null;
    if (row >= 0) {
      const at = this.shape.middle(row);
      this.overlay.picked = { at, reach: Math.min(Math.max(this.shape.reach(row, at, 2), 1.5), 14) };
    }
    this.dress();
  }

  // Moves the view to a vessel that is outside of it.
  reveal(row) {
    const at = this.shape.middle(row), [x, y] = this.camera.project(at, 0), [w, h] = this.camera.size;
    if (Math.abs(x) > 0.45 * w || Math.abs(y) > 0.45 * h) this.fly({ turn: this.camera.turn, centre: at, mm: this.camera.mm });
  }

  // Flies to a vessel and isolates what is near it; `others` are rows that also stay, `likely` those that the view has to hold.
  goTo(row, others, likely) {
    const at = this.shape.middle(row), { points, starts } = this.geometry;
    const reach = Math.min(Math.max(1.6 * Math.max(...[row, ...likely].map(one => this.shape.reach(one, at, 3))), 9), 40);
    this.near = new Set([row, ...others]);
    for (let one = 0; one < this.geometry.vessels; one++) {
      if (this.state(one) & (LOOK.pruned | LOOK.undecided)) continue;
      for (let i = starts[one]; i < starts[one + 1] && !this.near.has(one); i++) {
        // A vessel of two far points may pass by between them.
        const a = 4 * i, b = i + 1 < starts[one + 1] ? a + 4 : a;
        const d = [0, 1, 2].map(axis => points[b + axis] - points[a + axis]), p = at.map((x, axis) => x - points[a + axis]), whole = dot(d, d);
        const t = whole > 0 ? Math.min(Math.max(dot(d, p) / whole, 0), 1) : 0;
        if (Math.hypot(...p.map((x, axis) => x - t * d[axis])) < reach) this.near.add(one);
      }
    }
    this.focus = [...at, reach];
    const [a, b] = [4 * starts[row], 4 * (starts[row + 1] - 1)];
    this.fly(this.camera.around(at, reach, [0, 1, 2].map(axis => points[b + axis] - points[a + axis])));
  }

  // Ends the isolation of a neighbourhood.
  showAll() {
    this.near = null;
    this.focus = [0, 0, 0, 0];
    this.overlay.chances = [];
  }

  fly(goal) {
    const { camera } = this, start = { turn: camera.turn, centre: camera.centre, mm: camera.mm }, from = performance.now();
    this.flight = goal;
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const step = now => {
      if (this.flight !== goal) return;
      const t = still ? 1 : Math.min(Math.max((now - from) / FLIGHT, 0), 1);
      camera.between(start, goal, t * t * (3 - 2 * t));
      this.move();
      if (t < 1) requestAnimationFrame(step);
      else this.flight = null;
    };
    step(from);
  }

  // The reader takes the view in hand.
  halt() {
    this.flight = null;
  }

  paintVessels() {
    const seen = this.hull && this.hullShown && !(this.hullIsSlow && this.moving);
    this.painter.paint(this.camera, seen ? { lift: this.voxel, focus: this.focus } : null, this.isSlow && this.moving);
  }

  // Whether a frame takes long here, as without a graphics card: then the picture is coarser while the view moves; and whether one with the
  // surface does: then that is left out.
  time() {
    const took = hull => {
      this.painter.finish();
      const from = performance.now();
      this.painter.paint(this.camera, hull, false);
      this.painter.finish();
      return performance.now() - from;
    };
    this.isSlow = took(null) > SLOW / 2;
    if (this.hull && this.hullShown) this.hullIsSlow = took({ lift: this.voxel, focus: this.focus }) > SLOW;
  }

  // Paints a view that moves.
  move() {
    this.moving = true;
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      this.moving = false;
      this.paint();
    }, REST);
    this.paint();
  }

  frame() {
    if (!this.colour) return;
    if (this.painter.finish && this.canvas.width > 1 && (this.isSlow === undefined || this.hull && this.hullShown && this.hullIsSlow === undefined)) this.time();
    this.paintVessels();
    this.overlay.draw(this.over.getContext("2d"), this.camera.size, this.ratio, false);
  }

  // Paints once before the next frame of the browser.
  paint() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.frame();
    });
  }

  // The view as a picture, twice as fine, with scale bar and legend; a canvas.
  picture() {
    this.moving = false;
    const [w, h] = this.camera.size, was = this.ratio, sum = make("canvas", { width: 2 * w, height: 2 * h });
    [this.canvas.width, this.canvas.height] = [2 * w, 2 * h];
    const over = make("canvas", { width: 2 * w, height: 2 * h });
    this.paintVessels();
    this.overlay.draw(over.getContext("2d"), [w, h], 2, true);
    const ink = sum.getContext("2d");
    ink.drawImage(this.canvas, 0, 0);
    ink.drawImage(over, 0, 0);
    [this.canvas.width, this.canvas.height] = [Math.round(w * was), Math.round(h * was)];
    this.frame();
    return sum;
  }

  // The frontmost vessel at a place of the view, in pixels from its middle; -1 without one. `touched` is then the place on it, mm.
  at(x, y, room) {
    const { points, starts, vessels } = this.geometry;
    let found = -1, best = [Infinity, -Infinity];
    for (let row = 0; row < vessels; row++) {
      if (this.looks[4 * row + 3] & (LOOK.hidden | LOOK.faint)) continue;
      let a = this.camera.project(points, 4 * starts[row]);
      for (let i = starts[row] + 1; i < starts[row + 1]; i++) {
        const b = this.camera.project(points, 4 * i), radius = points[4 * i + 3] / this.camera.mm;
        const [dx, dy] = [b[0] - a[0], b[1] - a[1]], length = dx * dx + dy * dy;
        const t = length > 0 ? Math.min(Math.max(((x - a[0]) * dx + (y - a[1]) * dy) / length, 0), 1) : 0;
        const off = Math.max(Math.hypot(x - a[0] - t * dx, y - a[1] - t * dy) - radius, 0), near = a[2] + t * (b[2] - a[2]) + points[4 * i + 3];
        if (off < room && (off < best[0] || (off === best[0] && near > best[1]))) {
          [found, best] = [row, [off, near]];
          this.touched = [0, 1, 2].map(axis => points[4 * i - 4 + axis] + t * (points[4 * i + axis] - points[4 * i - 4 + axis]));
        }
        a = b;
      }
    }
    return found;
  }
}
