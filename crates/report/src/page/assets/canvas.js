// The vessels as lines on a plain canvas, far ones first, for browsers without WebGL 2.
class LinePainter {
  constructor(canvas, geometry) {
    this.canvas = canvas;
    this.ink = canvas.getContext("2d");
    this.geometry = geometry;
    this.paper = [1, 1, 1];
  }

  dress(looks) {
    this.looks = looks.slice();
  }

  // The visible pieces, from far to near; the selected vessel last.
  pieces(camera) {
    const { points, starts } = this.geometry, pieces = [];
    for (let item = 0; item + 1 < starts.length; item++) {
      const state = this.looks[4 * item + 3];
      if (state & LOOK.hidden) continue;
      let from = camera.project(points, 4 * starts[item]);
      if (starts[item + 1] - starts[item] === 1) pieces.push({ item, state, from, to: from, radius: points[4 * starts[item] + 3], far: from[2] + (state & LOOK.top ? 4 * camera.depth : 0) });
      for (let i = starts[item] + 1; i < starts[item + 1]; i++) {
        const to = camera.project(points, 4 * i);
        const far = (from[2] + to[2]) / 2 + (state & (LOOK.picked | LOOK.top) ? 4 * camera.depth : 0);
        pieces.push({ item, state, from, to, radius: (points[4 * i - 1] + points[4 * i + 3]) / 2, far });
        from = to;
      }
    }
    return pieces.sort((a, b) => a.far - b.far);
  }

  paint(camera) {
    const { ink, canvas, looks } = this, ratio = canvas.width / camera.size[0];
    ink.setTransform(1, 0, 0, 1, 0, 0);
    ink.fillStyle = `rgb(${this.paper.map(x => Math.round(255 * x))})`;
    ink.fillRect(0, 0, canvas.width, canvas.height);
    ink.setTransform(ratio, 0, 0, ratio, canvas.width / 2, canvas.height / 2);
    for (const { item, state, from, to, radius, far } of this.pieces(camera)) {
      const thin = state & LOOK.pruned ? 0.55 : 1;
      const width = Math.max(2 * thin * radius / camera.mm, state & LOOK.inlet ? 8 : state & LOOK.marker ? 4.4 : 1.4 * thin);
      const stroke = (style, wide, dash, cap) => {
        ink.strokeStyle = style;
        ink.lineWidth = wide;
        ink.lineCap = cap;
        ink.setLineDash(dash);
        ink.beginPath();
        ink.moveTo(from[0], from[1]);
        ink.lineTo(to[0] + 1e-3, to[1]);
        ink.stroke();
      };
      const faint = state & LOOK.faint, mix = (c, i) => faint ? Math.round(0.18 * c + 0.82 * 255 * this.paper[i]) : c;
      const colour = `rgb(${[0, 1, 2].map(i => mix(looks[4 * item + i], i))})`;
      const dashed = state & LOOK.pruned && !(state & LOOK.picked);
      if (!dashed && !faint) stroke("#1a1a1a", width + (state & LOOK.picked ? 6 : 1), [], "round");
      stroke(colour, width, dashed ? [5, 4] : [], dashed ? "butt" : "round");
      if (state & LOOK.undecided) stroke("#1a1a1a", width, [3, 9], "butt");
    }
  }
}
