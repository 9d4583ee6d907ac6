// The threshold and the decisions of a person: the kept vessels, the undecided ones, and the components and cycles of the kept graph.
class Threshold {
  constructor(source, vessels, nodes) {
    Object.assign(this, source);
    // A column without any value is left out of the page.
    const values = name => vessels.find(name)?.values ?? new Float64Array(vessels.rows).fill(NaN);
    this.rows = vessels.rows;
    this.values = values(source.figure);
    this.isByChance = source.figure === "probability";
    this.uncertain = values(source.uncertain);
    this.undecided = values(source.undecided);
    this.loose = values("loose_mm");
    this.loop = values("loop_mm");
    this.touch = values("touch_mm");
    this.touchGain = values("touch_gain_mm");
    this.ends = [values("node_a"), values("node_b")];
    this.lengths = values("length_mm");
    const errors = source.error && vessels.find(source.error);
    this.asKept = source.kept && values(source.kept);
    // What the run says, and what it said before the decisions that it was made with.
    this.ofRun = vessels.find("probability")?.values ?? null;
    this.probability = vessels.find("stated")?.values ?? this.ofRun;
    this.made = new Map((data.record.parameters?.decisions?.made ?? []).filter(of => of.accepted !== null).map(of => [of.edge, of.accepted]));
    // The law of the rule of the run with its figures, and what it weighs, to follow it after a decision.
    const [followed, figures] = Object.entries(source.rule || {})[0] || [];
    this.law = followed && LAWS[followed];
    this.ruled = figures;
    this.attachedAs = [values("attached_a"), values("attached_b")];
    this.alone = nodes?.find("alone")?.values ?? new Float64Array(source.nodes).fill(NaN);
    const origin = vessels.find("origin");
    this.isObserved = origin ? row => origin.at(row) === "observed" : row => !this.uncertain[row];
    this.isContact = row => origin?.at(row) === "contact";
    const share = row => Math.sqrt(this.values[row] * (1 - this.values[row]) / Math.max(source.samples, 1));
    const near = source.band === null ? share : () => source.band;
    this.errorOf = source.error ? row => errors ? errors.values[row] : NaN : near;
    this.known = upTo(this.rows).filter(row => this.uncertain[row] && !Number.isNaN(this.values[row]));
    this.sorted = Float64Array.from(this.known, row => this.values[row]).sort();
    this.positive = this.sorted.filter(x => x > 0);
    // Every threshold that changes which vessels are kept, in ascending order.
    this.stops = [...new Set(this.sorted)];
    if (this.at_least) this.stops.push(...(this.stops.at(-1) < 1 ? [1] : []));
    else if (this.stops[0] > 0) this.stops.unshift(0);
    this.kept = new Uint8Array(this.rows);
    this.open = new Uint8Array(this.rows);
    // What a person decided, by row: true where the connection was accepted.
    this.decided = this.made;
    this.toRun();
  }

  // The decisions of the run: by its threshold, or vessel by vessel where its rule has none.
  toRun() {
    this.set(this.cut, this.asKept !== null);
  }

  // The decisions of a person changed.
  again() {
    this.set(this.now, this.asRun);
  }

  // The stop that keeps the same vessels as the threshold.
  stop() {
    const now = this.asRun ? this.middle : this.now;
    if (now === null) return this.stops.length - 1;
    const after = this.stops.findIndex(x => this.at_least ? x >= now : x > now);
    const last = this.stops.length - 1;
    return this.at_least ? (after < 0 ? last : after) : Math.max((after < 0 ? last + 1 : after) - 1, 0);
  }

  // A threshold with few digits that keeps the same vessels as a stop.
  round(stop) {
    const at = this.stops[stop];
    const [low, high] = this.at_least ? [this.stops[stop - 1] ?? 0, at] : [at, this.stops[stop + 1] ?? 2 * at];
    const fits = x => this.at_least ? x > low && x <= high : x >= low && x < high;
    for (let digits = 1; digits < 17; digits++) {
      for (const from of [0.5 * (low + high), at]) {
        const x = Number(from.toPrecision(digits));
        if (fits(x)) return x;
      }
    }
    return at;
  }

  // Whether a decision may be chance: as the run says where its rule has no threshold and the decision is still the run's, else near the
  // threshold. Without a threshold nothing has L > 0, which is certain only where the errors are known.
  isOpen(row, flip, passes) {
    if (this.followed) return this.isOpenByRule(row, flip);
    if (this.asKept && Boolean(passes) === Boolean(this.asKept[row])) return Boolean(this.undecided[row]);
    const error = this.errorOf(row);
    if (flip === null) return Boolean(this.midway) && Number.isNaN(error);
    if (this.isByChance && this.figureOf(row) === 0) return false;
    return !(Math.abs(this.figureOf(row) - flip) >= this.within * error);
  }

  // The same given what a person decided: near where the rule turns, left open, or kept though improbable; not with a far more probable
  // one in its place.
  isOpenByRule(row, flip) {
    const { kept, left, instead } = this.followed, p = this.chance(row), near = p > 0 && Math.abs(p - flip) < this.band;
    if (this.law.oneByOne || !(p < flip)) return near || left.has(row);
    return !(instead.has(row) && this.chance(instead.get(row)) - p >= this.band) && (near || left.has(row) || Boolean(kept[row]));
  }

  // The figure that is compared with the threshold; a probability is that given what a person decided.
  figureOf(row) {
    return this.isByChance ? this.chance(row) : this.values[row];
  }

  // Where a decision would change: at the threshold, or midway between the two positive figures next to it. Where the rule of the run
  // has no threshold it stays where the rule turns.
  flip() {
    if (this.asKept) return this.middle;
    if (!this.midway || this.now === null) return this.now;
    const above = this.positive.findIndex(x => x > this.now);
    return above <= 0 ? null : 0.5 * (this.positive[above - 1] + this.positive[above]);
  }

  // Without a threshold no uncertain vessel is kept, unless the decisions are those of the run.
  set(cut, asRun = false) {
    this.now = cut;
    this.asRun = asRun;
    // Whether the decisions are those that the run was made with.
    this.isAsMade = this.decided.size === this.made.size && [...this.decided].every(([row, said]) => this.made.get(row) === said);
    // Per node its fragment without and with what a person accepted.
    [this.apart, this.joined] = [row => this.isObserved(row) || !this.uncertain[row], row => this.isGiven(row)].map(has => parts(this.nodes, this.rows, this.ends, has).of);
    const flip = this.flip();
    this.followed = asRun ? this.byRule() : null;
    const byRule = this.followed?.kept ?? this.asKept;
    this.counts = { kept: 0, pruned: 0, undecided: 0, vessels: 0 };
    for (let row = 0; row < this.rows; row++) {
      const x = this.figureOf(row), said = this.decided.get(row);
      const passes = said ?? (asRun ? byRule[row] : cut !== null && (this.at_least ? x >= cut : x > cut));
      this.kept[row] = !this.uncertain[row] || passes ? 1 : 0;
      this.open[row] = said === undefined && this.uncertain[row] && this.isOpen(row, flip, passes) ? 1 : 0;
      this.counts.vessels += this.kept[row];
      if (this.uncertain[row]) this.counts[passes ? "kept" : "pruned"] += 1;
      this.counts.undecided += this.open[row];
    }
    const { count, of } = parts(this.nodes, this.rows, this.ends, row => this.kept[row]);
    this.componentOf = of;
    this.counts.components = count;
    this.counts.cycles = this.counts.vessels + count - this.nodes;
    this.expected = this.expectedErrors();
  }

  // Whether the answer has a vessel whatever the rule says.
  isGiven(row) {
    return !this.uncertain[row] || this.isObserved(row) || this.decided.get(row) === true;
  }

  // What the rule of the run keeps given the decisions of a person, as a run with them does; null where it does not follow them.
  byRule() {
    if (!this.asKept || this.isAsMade) return null;
    return this.law.keeps(this, this.ruled);
  }

  // How probably a connection attaches its one end to its other, and the reverse, given what a person decided.
  attached(row) {
    return this.follows(row).attached;
  }

  // The probability of a vessel given what a person decided.
  chance(row) {
    if (this.ofRun && this.isAsMade) return this.ofRun[row];
    return this.probability ? this.follows(row).p : this.decided.has(row) ? Number(this.decided.get(row)) : NaN;
  }

  // What decisions leave of the probability of a vessel, and of those with which its ends are attached; as decisions.rs has it.
  follows(row) {
    const stated = this.probability[row], as = this.attachedAs.map(of => of[row] || 0), said = this.decided.get(row);
    const to = p => ({ p, attached: as.map(x => stated > 0 ? Math.min(p / stated * x, 1) || 0 : 0) });
    if (said !== undefined) return to(said ? 1 : 0);
    if (this.decided.size === 0 || !this.uncertain[row] || Number.isNaN(stated) || this.isContact(row)) return to(stated);
    const beside = this.freeEnds(row).map(end => end.filter(other => !this.isContact(other) && this.decided.get(other)));
    if (this.beside_accepted !== null) return to(beside.reduce((p, end, at) => end.length && !this.taken.has(this.ends[at][row]) ? p * this.beside_accepted : p, stated));
    // What closes a loop of fragments is gone, and a fragment hangs on one other at most.
    const [a, b] = this.ends.map(of => of[row]);
    if (this.joined[a] === this.joined[b] && this.apart[a] !== this.apart[b]) return to(0);
    const left = as.map((x, at) => x * (1 / (1 + beside[at].reduce((odds, other) => odds + this.oddsToHang(other, this.ends[at][row]), 0))));
    const gone = as[0] - left[0] + (as[1] - left[1]);
    return { p: Math.max(stated - gone, 0), attached: left };
  }

  // The odds that the fragment at one end of a connection hangs by it.
  oddsToHang(row, node) {
    const p = this.probability[row], hangs = this.attachedAs[this.ends[0][row] === node ? 0 : 1][row] || 0;
    return p > 0 ? hangs / Math.max(p - hangs, 0) : 1;
  }

  // Uncertain vessels that leave a free end which this one leaves too.
  rivals(row) {
    return [...new Set(this.freeEnds(row).flat())].filter(other => other !== row);
  }

  // The uncertain vessels at each end of one that is free.
  freeEnds(row) {
    if (!this.atFreeEnd) {
      const degree = new Uint32Array(this.nodes), all = upTo(this.rows);
      for (const r of all) if (this.isObserved(r)) for (const of of this.ends) degree[of[r]] += 1;
      const leaving = open => all.filter(r => Boolean(this.uncertain[r]) === open && !this.isObserved(r)).flatMap(r => this.ends.map(of => [of[r], r]));
      this.atFreeEnd = listedBy(leaving(true).filter(([node]) => degree[node] <= 1));
      // Where one was certain before anything was decided on, others have lost their half.
      this.taken = new Set(leaving(false).filter(([, r]) => !this.isContact(r)).map(([node]) => node));
    }
    return this.ends.map(of => this.atFreeEnd.get(of[row]) || []);
  }

  // Wrong and missed connections that the probabilities expect; null without probabilities. A pair of fragments counts once.
  expectedErrors() {
    if (!this.probability) return null;
    let wrong = 0, missed = 0;
    const pairs = new Map(), fragment = this.joined;
    for (let row = 0; row < this.rows; row++) {
      if (Number.isNaN(this.probability[row])) continue;
      const p = this.chance(row), kept = this.kept[row];
      if (kept) wrong += 1 - p;
      const [a, b] = this.ends.map(of => fragment[of[row]]);
      if (a === b) { missed += kept ? 0 : p; continue; }
      const key = a < b ? `${a},${b}` : `${b},${a}`, [most, joined] = pairs.get(key) || [0, false];
      pairs.set(key, [Math.max(most, p), joined || Boolean(kept)]);
    }
    for (const [most, joined] of pairs.values()) if (!joined) missed += most;
    return { wrong, missed };
  }

  // How doubtful a decision without a probability is, from 0 (certain) to 1: by how near the figure is to where the decision flips.
  doubt(row) {
    if (this.decided.has(row) || !this.uncertain[row]) return 0;
    const flip = this.flip(), error = this.errorOf(row);
    if (flip === null || !(error > 0)) return this.open[row] ? 1 : 0;
    return Math.exp(-0.5 * ((this.values[row] - flip) / error) ** 2);
  }

  // What is asked of a row, as a function of it: whether anything is; the vessels that hang on it, mm (the shorter of what it joins, or would join); whether
  // it closes a loop, or would; the length of the part or of the loop that it stands for; and what a right answer is expected to put right.
  questions() {
    const side = sides(this.nodes, this.rows, this.ends, row => this.kept[row], this.lengths);
    const whole = new Float64Array(this.nodes);
    for (let row = 0; row < this.rows; row++) if (this.kept[row]) whole[this.componentOf[this.ends[0][row]]] += this.lengths[row];
    return row => {
      if (this.touch[row]) return { row, loose: 0, loop: 0, touch: this.touch[row], hangs: this.touch[row], asked: true, gain: this.touchGain[row] };
      const [a, b] = this.ends.map(of => this.componentOf[of[row]]), p = this.chance(row);
      const closes = this.kept[row] ? Number.isNaN(side[row]) : a === b, loop = this.kept[row] && !this.decided.has(row) && closes && this.loop[row] || 0;
      const hangs = closes ? loop : this.kept[row] ? side[row] : Math.min(whole[a], whole[b]);
      const still = !this.decided.has(row) && (this.isObserved(row) ? whole[a] <= this.loose[row] * (1 + 1e-6) : a !== b);
      const loose = still && this.loose[row] || 0, wrong = Number.isNaN(p) ? this.doubt(row) : this.kept[row] ? 1 - p : p;
      const costs = this.law?.oneByOne && this.uncertain[row] && this.kept[row] && !this.decided.has(row) && wrong * hangs > this.worth;
      return { row, loose, loop, closes, hangs: loose || hangs, asked: Boolean(this.open[row] || loose || costs), gain: loose || wrong * (hangs + this.lengths[row]) };
    };
  }

  state(row) {
    if (!this.uncertain[row]) return "certain";
    if (this.decided.has(row)) return this.decided.get(row) ? "accepted" : "rejected";
    return (this.kept[row] ? "kept" : "pruned") + (this.open[row] ? ", undecided" : "");
  }
}

// A union-find over nodes: a function that joins two, and says whether they were apart.
function union(nodes) {
  const parent = Uint32Array.from({ length: nodes }, (_, node) => node);
  const root = node => {
    while (parent[node] !== node) node = parent[node] = parent[parent[node]];
    return node;
  };
  const join = (a, b) => {
    [a, b] = [root(a), root(b)];
    parent[a] = b;
    return a !== b;
  };
  return Object.assign(join, { roots: () => parent.map((_, node) => root(node)) });
}

// The connected parts of the vessels for which `has` holds; a node without a vessel is a part.
function parts(nodes, rows, ends, has) {
  const join = union(nodes);
  let count = nodes;
  for (let row = 0; row < rows; row++) if (has(row) && join(ends[0][row], ends[1][row])) count -= 1;
  return { count, of: join.roots() };
}

// For each vessel of a graph the length of the shorter side if it were cut, mm; NaN where that cuts nothing off (Tarjan 1974, bridges).
function sides(nodes, rows, ends, has, lengths) {
  const first = new Int32Array(nodes + 1), side = new Float64Array(rows).fill(NaN);
  for (let row = 0; row < rows; row++) if (has(row)) for (const of of ends) first[of[row] + 1] += 1;
  for (let node = 0; node < nodes; node++) first[node + 1] += first[node];
  const next = first.slice(0, nodes), list = new Int32Array(first[nodes]);
  for (let row = 0; row < rows; row++) if (has(row)) for (const of of ends) list[next[of[row]]++] = row;
  const seen = new Int32Array(nodes).fill(-1), low = new Int32Array(nodes), below = new Float64Array(nodes), by = new Int32Array(nodes).fill(-1);
  next.set(first.subarray(0, nodes));
  for (let start = 0, time = 0; start < nodes; start++) {
    if (seen[start] >= 0) continue;
    const path = [start], bridges = [];
    seen[start] = low[start] = time++;
    while (path.length) {
      const node = path.at(-1);
      if (next[node] < first[node + 1]) {
        const row = list[next[node]++], other = ends[0][row] === node ? ends[1][row] : ends[0][row];
        if (row === by[node]) continue;
        if (seen[other] < 0) {
          seen[other] = low[other] = time++;
          by[other] = row;
          path.push(other);
        } else {
          low[node] = Math.min(low[node], seen[other]);
          // Each other vessel counts once, from its later end.
          if (seen[other] < seen[node] || other === node) below[node] += other === node ? lengths[row] / 2 : lengths[row];
        }
        continue;
      }
      path.pop();
      const up = path.at(-1);
      if (up === undefined) break;
      low[up] = Math.min(low[up], low[node]);
      if (low[node] > seen[up]) bridges.push([by[node], below[node]]);
      below[up] += below[node] + lengths[by[node]];
    }
    for (const [row, under] of bridges) side[row] = Math.min(under, below[start] - under - lengths[row]);
  }
  return side;
}
