// What stands over the vessels: scale bar, orientation, names, chances, the ring around what is selected; and the legend of a picture.
const DIRECTIONS = { RAS: [["R", "L"], ["A", "P"], ["S", "I"]], LPS: [["L", "R"], ["P", "A"], ["S", "I"]] };
const MOST_NAMES = 60;

class Overlay {
  // `sides`: as `sidesOf`, where labels alone say them.
  constructor(scene, frame, sides) {
    this.scene = scene;
    this.axes = (DIRECTIONS[frame] || [["x"], ["y"], ["z"]]).map(([name]) => name);
    this.letters = DIRECTIONS[frame] || [0, 1, 2].map(axis => axis === sides?.axis ? sides.names : ["", ""]);
    // `{at: [x, y, z], text, strong}` in mm.
    this.names = [];
    this.chances = [];
    // `{at, text}` of places of edits.
    this.places = [];
    this.namesShown = true;
    // `{at, towards, reversed}`: which way blood flows; and `{at, text}` of what a simulation changed.
    this.arrows = [];
    this.changes = [];
    this.flowShown = true;
    // `{at, row}` of what is selected.
    this.picked = null;
    this.legend = null;
  }

  // Draws over a picture of the scene; `size` in pixels of the page, `scale` pixels of the canvas in each.
  draw(ink, size, scale, withLegend) {
    const [w, h] = size;
    ink.setTransform(scale, 0, 0, scale, 0, 0);
    ink.clearRect(0, 0, w, h);
    ink.font = "13px system-ui, 'Segoe UI', Roboto, 'Noto Sans', sans-serif";
    ink.textBaseline = "middle";
    this.ring(ink, w, h);
    const taken = [];
    if (this.flowShown) for (const arrow of this.arrows) this.arrow(ink, w, h, arrow);
    for (const place of [...this.places, ...this.changes]) this.dot(ink, w, h, place);
    for (const label of [...this.chances, ...this.changes, ...(this.flowShown ? this.arrows.filter(arrow => arrow.text) : []), ...this.places.filter(place => place.text)]) this.label(ink, w, h, label, taken);
    if (this.namesShown) for (const label of this.names) this.label(ink, w, h, label, taken);
    this.edges(ink, w, h);
    this.cross(ink, w, h);
    this.scaleBar(ink, h);
    if (withLegend) this.key(ink, w);
  }

  on(w, h, at) {
    const [x, y, z] = this.scene.camera.project(at, 0);
    return [w / 2 + x, h / 2 + y, z];
  }

  text(ink, text, x, y, { align = "center", colour = "#1a1a1a", weight = "" } = {}) {
    ink.font = ink.font.replace(/^(bold )?/, weight ? "bold " : "");
    ink.textAlign = align;
    ink.lineWidth = 3.5;
    ink.lineJoin = "round";
    ink.strokeStyle = this.scene.paper;
    ink.strokeText(text, x, y);
    ink.fillStyle = colour;
    ink.fillText(text, x, y);
  }

  // A line through places in the view.
  line(ink, colour, wide, ...places) {
    ink.strokeStyle = colour;
    ink.lineWidth = wide;
    ink.beginPath();
    for (const [x, y] of places) ink.lineTo(x, y);
    ink.stroke();
  }

  // A name beside its vessel, unless another stands there already.
  label(ink, w, h, { at, text, strong }, taken) {
    const [x, y] = this.on(w, h, at), wide = ink.measureText(text).width / 2 + 3;
    const box = [x + 10, x + 10 + 2 * wide, y - 17, y - 1];
    if (box[1] < 0 || box[0] > w || box[3] < 0 || box[2] > h) return;
    if (taken.some(b => b[0] < box[1] && box[0] < b[1] && b[2] < box[3] && box[2] < b[3])) return;
    taken.push(box);
    this.line(ink, "#777", 1, [x, y], [x + 9, y - 8]);
    this.text(ink, text, x + 11, y - 9, { align: "left", weight: strong ? "bold" : "" });
  }

  dot(ink, w, h, { at }) {
    const [x, y] = this.on(w, h, at);
    for (const [colour, r] of [[this.scene.paper, 7], ["#c8102e", 5]]) {
      ink.fillStyle = colour;
      ink.beginPath();
      ink.arc(x, y, r, 0, 2 * Math.PI);
      ink.fill();
    }
  }

  // An arrowhead along a vessel, where it is seen from the side; one of a flow that turned round is red.
  arrow(ink, w, h, { at, towards, reversed }) {
    const [x, y] = this.on(w, h, at), [right, up] = this.scene.camera.turn, d = [dot(right, towards), -dot(up, towards)];
    const long = Math.hypot(...towards), seen = Math.hypot(...d);
    if (!(seen > 0.3 * long)) return;
    const [a, b] = d.map(c => c / seen), r = reversed ? 9 : 6.5;
    ink.beginPath();
    ink.moveTo(x + r * a, y + r * b);
    for (const side of [1, -1]) ink.lineTo(x - r * (0.8 * a - side * 0.75 * b), y - r * (0.8 * b + side * 0.75 * a));
    ink.closePath();
    ink.lineWidth = 1.5;
    ink.strokeStyle = reversed ? "#fff" : "#1a1a1a";
    ink.fillStyle = reversed ? "#c8102e" : "#fff";
    ink.fill();
    ink.stroke();
  }

  ring(ink, w, h) {
    if (!this.picked) return;
    const [x, y] = this.on(w, h, this.picked.at), r = Math.max(this.picked.reach / this.scene.camera.mm, 14);
    for (const [colour, wide] of [[this.scene.paper, 6], ["#c8102e", 2.5]]) {
      ink.strokeStyle = colour;
      ink.lineWidth = wide;
      ink.beginPath();
      ink.arc(x, y, r, 0, 2 * Math.PI);
      ink.stroke();
    }
  }

  // The letter of a direction of the view: the axis that points there most.
  towards(direction) {
    let best = 0;
    for (let axis = 1; axis < 3; axis++) if (Math.abs(direction[axis]) > Math.abs(direction[best]) + 1e-9) best = axis;
    return this.letters[best][direction[best] > 0 ? 0 : 1];
  }

  edges(ink, w, h) {
    const [right, up] = this.scene.camera.turn, minus = v => v.map(x => -x);
    const style = { colour: "#444", weight: "bold" };
    this.text(ink, this.towards(minus(right)), 14, h / 2, style);
    this.text(ink, this.towards(right), w - 14, h / 2, style);
    this.text(ink, this.towards(up), w / 2, 14, style);
    this.text(ink, this.towards(minus(up)), w / 2, h - 14, style);
  }

  // Three short axes in the lower right corner.
  cross(ink, w, h) {
    const { turn } = this.scene.camera, [x, y] = [w - 44, h - 44];
    const arms = [0, 1, 2].map(axis => ({ x: turn[0][axis], y: -turn[1][axis], z: turn[2][axis], name: this.axes[axis] }));
    for (const arm of arms.sort((a, b) => a.z - b.z)) {
      this.line(ink, arm.z < -0.05 ? "#999" : "#333", 2, [x, y], [x + 22 * arm.x, y + 22 * arm.y]);
      if (Math.hypot(arm.x, arm.y) > 0.25) this.text(ink, arm.name, x + 31 * arm.x, y + 31 * arm.y, { colour: "#333" });
    }
  }

  scaleBar(ink, h) {
    const { camera } = this.scene, widest = Math.min(120, camera.size[0] / 3) * camera.mm;
    const ten = 10 ** Math.floor(Math.log10(widest));
    const length = [5, 2, 1].map(m => m * ten).find(l => l <= widest) || ten, wide = length / camera.mm;
    this.line(ink, "#1a1a1a", 2, [12, h - 18], [12, h - 11], [12 + wide, h - 11], [12 + wide, h - 18]);
    this.text(ink, `${shown(length, 3)} mm`, 12 + wide / 2, h - 24);
  }

  // The colour scale, for a picture that stands alone.
  key(ink, w) {
    if (!this.legend) return;
    const { name, ticks, colours } = this.legend, [x, y, wide] = [w - 196, 34, 180];
    ink.fillStyle = "rgba(255,255,255,0.85)";
    ink.fillRect(x - 10, y - 26, wide + 20, 60);
    for (let i = 0; i < wide; i++) { ink.fillStyle = `rgb(${colours(i / (wide - 1))})`; ink.fillRect(x + i, y, 1.5, 11); }
    this.text(ink, name, x, y - 13, { align: "left", weight: "bold" });
    for (const [share, text] of ticks) this.text(ink, text, x + share * wide, y + 21, { align: share < 0.06 ? "left" : share > 0.94 ? "right" : "center" });
  }
}

// One name for each label, at the middle of its longest vessel.
function namesOf(shape, vessels) {
  const longest = new Map(), lengths = vessels.find("length_mm");
  for (let row = 0; row < vessels.rows; row++) {
    const text = nameOf(row), length = lengths ? lengths.at(row) : 0;
    if (text && !(longest.get(text)?.length >= length)) longest.set(text, { row, length });
  }
  if (longest.size > MOST_NAMES) return [];
  return [...longest].map(([text, { row }]) => ({ at: shape.middle(row), text: text.length > 24 ? `${text.slice(0, 23)}…` : text }));
}
