// The histogram of the figure of the uncertain vessels, with the median and the threshold. Likelihoods are on a logarithmic axis.
class Histogram {
  constructor(threshold) {
    this.threshold = threshold;
    const log = !threshold.at_least;
    this.of = log ? Math.log10 : x => x;
    const counted = log ? threshold.positive : threshold.sorted;
    this.zeros = threshold.sorted.length - counted.length;
    let [low, high] = log ? [this.of(counted[0]), this.of(counted.at(-1))] : [0, 1];
    if (log && low < high - DECADES) low = high - DECADES;
    if (!(high - low > 0.5) && log) [low, high] = [(low + high) / 2 - 0.5, (low + high) / 2 + 0.5];
    this.counted = counted;
    this.range = [low, high];
    this.bins = Math.min(Math.max(Math.round(2 * Math.cbrt(counted.length)), 10), 40);
    this.log = log;
  }

  // Kept and pruned in each bin; figures below the range are in the first.
  heights() {
    const [low, high] = this.range, { known, values, kept } = this.threshold;
    const heights = Array.from({ length: this.bins }, () => [0, 0]);
    for (const row of known) {
      const x = values[row];
      if (this.log && !(x > 0)) continue;
      const bin = Math.min(Math.max(Math.floor((this.of(x) - low) / (high - low) * this.bins), 0), this.bins - 1);
      heights[bin][kept[row] ? 0 : 1] += 1;
    }
    return heights;
  }

  show(place) {
    const { threshold, range: [low, high] } = this;
    if (!this.counted.length) {
      place.replaceChildren(make("p", { class: "quiet", text: `No uncertain vessel has a ${threshold.name} above zero.` }));
      return;
    }
    const [left, right, top, base] = [30, 312, 34, 150], heights = this.heights();
    const most = Math.max(...heights.map(([kept, pruned]) => kept + pruned), 1);
    const x = t => left + (right - left) * Math.min(Math.max((t - low) / (high - low), 0), 1), y = n => base - (base - top) * n / most;
    const wide = (right - left) / this.bins;
    const bars = heights.flatMap(([kept, pruned], bin) => {
      const bar = (from, to, style) => to > from && draw("rect", { x: left + bin * wide + 0.5, width: Math.max(wide - 1, 0.5), y: y(to), height: y(from) - y(to), ...style });
      return [
        bar(0, kept, { fill: "var(--kept)" }),
        bar(kept, kept + pruned, { fill: "url(#hatch)", stroke: "var(--pruned)", "stroke-width": 0.7 }),
      ].filter(Boolean);
    });
    const line = (value, text, dash, at) => {
      const t = x(this.of(value));
      return [
        draw("line", { x1: t, x2: t, y1: at + 3, y2: base, stroke: "var(--mark)", "stroke-width": dash ? 1.2 : 2, "stroke-dasharray": dash }),
        draw("text", { x: Math.min(Math.max(t, left + 26), right - 26), y: at, "text-anchor": "middle", text }),
      ];
    };
    const ticks = [];
    const step = this.log ? Math.max(1, Math.ceil((high - low) / 6)) : 0.25;
    for (let t = Math.ceil(low / step) * step; t <= high + 1e-9; t += step) {
      ticks.push(draw("line", { x1: x(t), x2: x(t), y1: base, y2: base + 4, stroke: "var(--ink)" }),
        draw("text", { x: x(t), y: base + 15, "text-anchor": "middle", text: this.log ? power(t) : shown(t) }));
    }
    const pairs = [];
    if (threshold.median !== null) pairs.push(line(threshold.median, "median", "4 3", 26));
    if (threshold.now !== null && (!this.log || threshold.now > 0)) pairs.push(line(threshold.now, "threshold", null, 12));
    // Text is drawn over the lines.
    const marks = [...pairs.map(([mark]) => mark), ...pairs.map(([, text]) => text)];
    const hatch = draw("pattern", { id: "hatch", width: 4, height: 4, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
      draw("line", { x1: 0, x2: 0, y1: 0, y2: 4, stroke: "var(--pruned)", "stroke-width": 1.6 }));
    const name = withUnit(threshold.name, threshold.unit && `(${threshold.unit})`);
    const says = `Histogram of ${name} of the ${this.counted.length} uncertain vessels${this.log ? " with L above zero" : ""}: solid kept, hatched pruned.`;
    place.replaceChildren(
      draw("svg", { viewBox: "0 0 320 186", role: "img", "aria-label": says }, draw("defs", {}, hatch), ...bars,
        draw("line", { x1: left, x2: right, y1: base, y2: base, stroke: "var(--ink)" }),
        draw("text", { x: left - 4, y: y(most) + 4, "text-anchor": "end", text: shown(most) }), draw("text", { x: left - 4, y: base, "text-anchor": "end", text: "0" }),
        ...ticks, ...marks, draw("text", { x: (left + right) / 2, y: 182, "text-anchor": "middle", text: name })),
      make("p", { class: "quiet", id: "histogram-note", text: "Solid: kept. Hatched: pruned." + (this.log ? ` ${shown(this.zeros)} of ${shown(threshold.sorted.length)} uncertain vessels have L = 0 and are not drawn.` : "") }));
  }
}
