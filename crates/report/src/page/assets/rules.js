// What the rules of a run keep, given what a person decided; as the library decides (most_probable_forest.rs, arborescence.rs).
// Each returns `kept` by row, and what else makes a decision open: `left`, rows of the forest that are not probable enough, and
// `instead`, by row the one that the forest has in its place.
const MOST_FIRST = of => (a, b) => of(b) - of(a) || a - b;

// The law of a rule by its key in the page (FollowedRule), and whether candidates are taken one by one.
const LAWS = {
  best_first: { keeps: bestFirst, oneByOne: true },
  forest: { keeps: mostProbableForest, oneByOne: false },
};

// The most probable candidates first, each free end once; then, where the rule says so, what joins two parts.
function bestFirst(of, { first, joins, doubtful }) {
  const { rows, nodes, ends } = of, kept = new Uint8Array(rows), degree = new Uint32Array(nodes), used = new Set(), joined = union(nodes);
  const open = [];
  for (let row = 0; row < rows; row++) {
    if (of.isGiven(row)) {
      kept[row] = 1;
      const joins = !of.isObserved(row) && !of.isContact(row);
      for (const end of ends) if (joins) used.add(end[row]); else degree[end[row]] += 1;
    } else if (of.chance(row) > 0) open.push(row);
  }
  const p = new Map(open.map(row => [row, of.chance(row)])), chance = row => p.get(row);
  for (const row of open.filter(row => !of.isContact(row) && chance(row) > first).sort(MOST_FIRST(chance))) {
    const free = ends.map(end => end[row]).filter(node => degree[node] <= 1);
    if (free.some(node => used.has(node))) continue;
    for (const node of free) used.add(node);
    kept[row] = 1;
  }
  if (joins !== null) {
    const score = row => of.isContact(row) ? of.attached(row)[0] + of.attached(row)[1] : chance(row);
    for (let row = 0; row < rows; row++) if (kept[row]) joined(ends[0][row], ends[1][row]);
    for (const row of open.filter(row => !kept[row] && score(row) >= (of.isContact(row) ? joins : doubtful)).sort(MOST_FIRST(score))) {
      kept[row] = joined(ends[0][row], ends[1][row]) ? 1 : 0;
    }
  }
  return { kept, left: new Set(), instead: new Map() };
}

// Whether a probability is no less than what is needed, but for rounding.
const isEnough = (p, needed) => needed - p <= 1e-9 * Math.max(p, needed);

// The most probable forest of fragments, and what of it is more probable than what hangs on it is nothing.
function mostProbableForest(of, { price, without }) {
  const { rows, nodes, ends } = of, kept = new Uint8Array(rows), needed = new Map(), number = new Map(), alone = [], left = [];
  const roots = parts(nodes, rows, ends, row => of.isGiven(row)).of;
  const fragment = node => number.get(roots[node]);
  for (let node = 0; node < nodes; node++) {
    if (!number.has(roots[node])) { number.set(roots[node], alone.length); alone.push(NaN); left.push(1); }
    const known = of.alone[node], at = fragment(node);
    if (!Number.isNaN(known)) alone[at] = Number.isNaN(alone[at]) ? known : Math.min(alone[at], known);
  }
  const arcs = [];
  for (let row = 0; row < rows; row++) {
    if (of.isGiven(row)) { kept[row] = 1; continue; }
    const p = of.chance(row);
    if (Number.isNaN(p)) continue;
    const [a, b] = ends.map(end => fragment(end[row]));
    if (a === b) {
      needed.set(row, without * price);
      kept[row] = isEnough(p, without * price) ? 1 : 0;
      continue;
    }
    of.attached(row).forEach((score, side) => {
      const [to, from] = side ? [b, a] : [a, b];
      left[to] -= p;
      if (score > 0) arcs.push({ from, to, score, tie: arcs.length, row });
    });
  }
  const nothing = alone.map((known, at) => Number.isNaN(known) ? Math.max(left[at], 0) : known), lone = [...nothing], ground = nothing.length, between = arcs.length;
  nothing.forEach((p, to) => arcs.push({ from: ground, to, score: without * price * p, tie: between + to, row: -1 }));
  const enters = arborescence(ground + 1, ground, arcs).slice(0, ground).map(at => arcs[at]), hanging = new Uint32Array(ground + 1), open = new Set();
  for (const { from } of enters) hanging[from] += 1;
  const order = [...enters.keys()].filter(at => hanging[at] === 0);
  for (let at = 0; at < order.length; at++) {
    const child = order[at], { from, row } = enters[child];
    if (row < 0) continue;
    if (--hanging[from] === 0) order.push(from);
    const p = of.chance(row);
    needed.set(row, price * nothing[child]);
    kept[row] = isEnough(p, needed.get(row)) ? 1 : 0;
    if (!kept[row]) open.add(row);
    nothing[from] *= 1 - p * (1 - nothing[child]);
  }
  const instead = new Map();
  for (let row = 0; row < rows; row++) {
    if (kept[row] || needed.has(row) || Number.isNaN(of.chance(row))) continue;
    const attaching = ends.map(end => enters[fragment(end[row])].row).filter(other => other >= 0).sort(MOST_FIRST(other => of.chance(other)));
    if (attaching.length) instead.set(row, attaching[0]);
    else needed.set(row, price * Math.max(...ends.map(end => lone[fragment(end[row])])));
  }
  return { kept, left: open, instead };
}

// Per node the arc by which the spanning arborescence with the largest sum of scores enters it (Edmonds 1967); -1 for the root, from which
// every node has an arc. Of equal sums the one with the smaller sum of `tie` wins.
function arborescence(count, root, arcs) {
  const best = new Int32Array(count).fill(-1), better = (a, b) => a.score > b.score || a.score === b.score && a.tie < b.tie;
  arcs.forEach((arc, at) => {
    if (arc.to !== root && (best[arc.to] < 0 || better(arc, arcs[best[arc.to]]))) best[arc.to] = at;
  });
  const whole = new Int32Array(count).fill(-1), seen = new Int32Array(count).fill(-1);
  let wholes = 0;
  for (let start = 0; start < count; start++) {
    let node = start;
    while (node !== root && seen[node] < 0) { seen[node] = start; node = arcs[best[node]].from; }
    if (node === root || seen[node] !== start || whole[node] >= 0) continue;
    // Back on the way: a cycle.
    for (; whole[node] < 0; node = arcs[best[node]].from) whole[node] = wholes;
    wholes += 1;
  }
  if (wholes === 0) return [...best];
  for (let node = 0; node < count; node++) if (whole[node] < 0) whole[node] = wholes++;
  const inner = [];
  arcs.forEach(({ from, to, score, tie }, at) => {
    if (whole[from] === whole[to] || to === root) return;
    const { score: least, tie: first } = arcs[best[to]];
    inner.push({ from: whole[from], to: whole[to], score: score - least, tie: tie - first, at });
  });
  for (const arc of arborescence(wholes, whole[root], inner)) {
    if (arc >= 0) best[arcs[inner[arc].at].to] = inner[arc].at;
  }
  return [...best];
}
