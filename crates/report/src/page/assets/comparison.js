// Builds the page of a comparison: a panel for each measure.
const found = table(data.comparison), subjects = table(data.subjects);
found.filterBy = "measure …";
const cell = (name, row) => found.find(name)?.at(row) ?? NaN;
const groups = found.rows ? ["a", "b"].map(letter => cell(`group_${letter}`, 0)) : [];
const SURE = 0.05;
// By the corrected p, then by p, then by the size of the effect.
const order = upTo(found.rows).sort((r, s) =>
  cell("p_holm", r) - cell("p_holm", s) || cell("p", r) - cell("p", s) || Math.abs(cell("cliffs_delta", s)) - Math.abs(cell("cliffs_delta", r)) || r - s);
const share = x => x.toFixed(2).replace("-", "−");
const chance = p => p < 0.001 ? "< 0.001" : `= ${shown(p, 2)}`;

function showAnswer() {
  const sizes = [true, false].map(first => data.first.filter(of => of === first).length);
  const sure = order.filter(row => cell("p_holm", row) < SURE);
  const words = [];
  if (sizes.includes(0)) words.push(`By ${data.compare}: nothing is compared, for no subject of a group could be measured.`);
  else if (found.rows === 0) words.push(`By ${data.compare}: no measure differs between subjects.`);
  else words.push(make("b", { text: `${groups[0]} (${sizes[0]}) and ${groups[1]} (${sizes[1]})` }),` by ${data.compare}, in ${count(found.rows, "measure")}: `,
    make("b", { text: sure.length === 0 ? "none differs" : sure.length === 1 ? `one differs, ${cell("measure", sure[0])},` : `${grouped(sure.length)} differ` }), ` beyond chance at ${SURE}, corrected for all of them.`);
  byId("answer-words").append(...words);
  byId("origin").textContent = `Made by willis ${data.record.willis}.`;
}

// Round numbers between two, about four of them.
function ticks(low, high) {
  const rough = (high - low) / 4, size = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 5, 10].map(m => m * size).find(s => s >= rough * 0.999);
  return Array.from({ length: 8 }, (_, i) => Number(((Math.ceil(low / step - 1e-9) + i) * step).toPrecision(12))).filter(x => x <= high + 1e-9 * step);
}

// Places beside each other where points would cover each other: the nearest to the middle that is free.
function beside(heights, radius, most) {
  const placed = [], at = new Array(heights.length);
  for (const i of heights.map((_, i) => i).sort((i, j) => heights[i] - heights[j] || i - j)) {
    const near = placed.filter(j => Math.abs(heights[j] - heights[i]) < 2 * radius);
    const free = x => near.every(j => (at[j] - x) ** 2 + (heights[j] - heights[i]) ** 2 >= 4 * radius ** 2 - 1e-6);
    const steps = Array.from({ length: 2 * Math.ceil(most / radius) }, (_, k) => (k % 2 ? 1 : -1) * Math.ceil(k / 2) * radius).filter(x => Math.abs(x) <= most);
    at[i] = steps.find(free) ?? steps[i % steps.length];
    placed.push(i);
  }
  return at;
}

const WIDE = 260, HIGH = 190, LEFT = 52, TOP = 8, BOTTOM = 20;
function panel(row) {
  const name = cell("measure", row), column = subjects.find(name);
  const rows = upTo(subjects.rows).filter(i => column && Number.isFinite(column.at(i)));
  const values = rows.map(i => column.at(i));
  let [low, high] = [Math.min(...values), Math.max(...values)];
  const room = 0.05 * (high - low) || 0.5;
  [low, high] = [low - room, high + room];
  const up = x => TOP + (HIGH - TOP - BOTTOM) * (high - x) / (high - low), half = (WIDE - LEFT) / 4;
  const parts = ticks(low, high).flatMap(x => [draw("line", { class: "grid", x1: LEFT, x2: WIDE, y1: up(x), y2: up(x) }), draw("text", { x: LEFT - 5, y: up(x) + 4, "text-anchor": "end", text: shown(x, 4) })]);
  const said = groups.map((group, at) => {
    const letter = "ab"[at], own = rows.filter(i => data.first[i] === (at === 0)), middle = LEFT + half * (1 + 2 * at);
    const heights = own.map(i => up(column.at(i))), places = beside(heights, 3.2, half - 8);
    parts.push(...own.map((i, k) => draw("circle", { class: `point ${letter}`, cx: (middle + places[k]).toFixed(1), cy: heights[k].toFixed(1), r: 3.2 }, draw("title", { text: `${subjects.find("subject").at(i)}: ${shown(column.at(i))}` }))));
    for (const what of ["quartile_1", "median", "quartile_3"]) {
      const y = up(cell(`${what}_${letter}`, row)), reach = what === "median" ? half - 8 : half / 2;
      if (Number.isFinite(y)) parts.push(draw("line", { class: what === "median" ? "median" : "quartile", x1: middle - reach, x2: middle + reach, y1: y, y2: y }));
    }
    parts.push(draw("text", { x: middle, y: HIGH - 4, "text-anchor": "middle", text: group.length > 16 ? `${group.slice(0, 15)}…` : group }));
    return `${group}: n ${shown(cell(`n_${letter}`, row))}, median ${shown(cell(`median_${letter}`, row), 4)}`;
  });
  const sure = cell("p_holm", row) < SURE, doubt = cell("doubt_share", row);
  return make("article", { class: `card${sure ? " differs" : ""}` }, make("h3", { text: name }),
    draw("svg", { class: "groups", viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": `${name}, each subject as a point. ${said.join("; ")}` }, ...parts),
    make("p", {}, said[0], make("br"), said[1]),
    make("p", { text: `δ ${share(cell("cliffs_delta", row))} (${share(cell("delta_low", row))} to ${share(cell("delta_high", row))})${doubt >= 0.005 ? `, ${shown(100 * doubt, 2)} % of its variance from doubtful topologies` : ""}` }),
    make("p", {}, `p ${chance(cell("p", row))}, `, make(sure ? "b" : "span", { text: `p (Holm) ${chance(cell("p_holm", row))}` })));
}

showAll(showAnswer, () => showCards(order, panel), () => byId("sheet").append(new Sheet(found, [], () => {}).element), showRun);
