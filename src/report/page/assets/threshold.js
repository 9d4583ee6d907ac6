// The threshold: the kept vessels, the undecided ones, and the components and cycles of the kept graph.
class Threshold {
  constructor(source, vessels) {
    Object.assign(this, source);
    const values = name => vessels.find(name).values;
    this.rows = vessels.rows;
    this.values = values(source.figure);
    this.uncertain = values(source.uncertain);
    this.ends = [values("node_a"), values("node_b")];
    const errors = source.error && vessels.find(source.error);
    this.asKept = source.kept && values(source.kept);
    const share = row => Math.sqrt(this.values[row] * (1 - this.values[row]) / Math.max(source.samples, 1));
    const near = source.band === null ? share : () => source.band;
    this.errorOf = source.error ? row => errors ? errors.values[row] : NaN : near;
    this.known = [...Array(this.rows).keys()].filter(row => this.uncertain[row] && !Number.isNaN(this.values[row]));
    this.sorted = Float64Array.from(this.known, row => this.values[row]).sort();
    this.positive = this.sorted.filter(x => x > 0);
    // Every threshold that changes which vessels are kept, in ascending order.
    this.stops = [...new Set(this.sorted)];
    if (this.at_least) this.stops.push(...(this.stops.at(-1) < 1 ? [1] : []));
    else if (this.stops[0] > 0) this.stops.unshift(0);
    this.kept = new Uint8Array(this.rows);
    this.open = new Uint8Array(this.rows);
    this.toRun();
  }

  // The decisions of the run: by its threshold, or vessel by vessel where its rule has none.
  toRun() {
    this.set(this.cut, this.asKept !== null);
  }

  // The stop that keeps the same vessels as the threshold.
  stop() {
    const now = this.asRun ? this.middle : this.now;
    if (now === null) return this.stops.length - 1;
    const after = this.stops.findIndex(x => this.at_least ? x >= now : x > now);
    const last = this.stops.length - 1;
    return this.at_least ? (after < 0 ? last : after) : Math.max((after < 0 ? last + 1 : after) - 1, 0);
  }

  // Where a decision would change: at the threshold, or midway between the two positive figures next to it.
  flip() {
    if (this.asRun) return this.middle;
    if (!this.midway || this.now === null) return this.now;
    const above = this.positive.findIndex(x => x > this.now);
    return above <= 0 ? null : 0.5 * (this.positive[above - 1] + this.positive[above]);
  }

  // Without a threshold no uncertain vessel is kept, unless the decisions are those of the run.
  set(cut, asRun = false) {
    this.now = cut;
    this.asRun = asRun;
    const flip = this.flip();
    this.counts = { kept: 0, pruned: 0, undecided: 0, vessels: 0 };
    for (let row = 0; row < this.rows; row++) {
      const x = this.values[row];
      const passes = asRun ? this.asKept[row] : cut !== null && (this.at_least ? x >= cut : x > cut);
      this.kept[row] = !this.uncertain[row] || passes ? 1 : 0;
      this.open[row] = this.uncertain[row] && flip !== null && !(Math.abs(x - flip) >= this.within * this.errorOf(row)) ? 1 : 0;
      this.counts.vessels += this.kept[row];
      if (this.uncertain[row]) this.counts[passes ? "kept" : "pruned"] += 1;
      this.counts.undecided += this.open[row];
    }
    this.counts.components = this.components();
    this.counts.cycles = this.counts.vessels + this.counts.components - this.nodes;
  }

  // Connected components of the kept vessels; a node without a vessel is a component.
  components() {
    const parent = Uint32Array.from({ length: this.nodes }, (_, node) => node);
    const root = node => {
      while (parent[node] !== node) node = parent[node] = parent[parent[node]];
      return node;
    };
    let count = this.nodes;
    for (let row = 0; row < this.rows; row++) {
      if (!this.kept[row]) continue;
      const [a, b] = [root(this.ends[0][row]), root(this.ends[1][row])];
      if (a !== b) { parent[a] = b; count -= 1; }
    }
    return count;
  }

  state(row) {
    if (!this.uncertain[row]) return "certain";
    return (this.kept[row] ? "kept" : "pruned") + (this.open[row] ? ", undecided" : "");
  }
}
