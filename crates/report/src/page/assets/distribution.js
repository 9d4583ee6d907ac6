// The distribution of a column over the subjects: a histogram of numbers, or a bar for each word. Choosing a bar filters the table.
const MOST_WORDS = 30;

// The edges of the bins: round numbers, or one bin for each whole number where these are few.
function binEdges(values) {
  const low = Math.min(...values), high = Math.max(...values), range = high - low;
  const wanted = Math.min(Math.max(Math.round(2 * Math.cbrt(values.length)), 5), 20);
  if (range === 0) return [low, high];
  const rough = range / wanted, size = 10 ** Math.floor(Math.log10(rough));
  let step = [1, 2, 5, 10].map(m => m * size).find(s => s >= rough * 0.999);
  if (values.every(Number.isInteger)) step = Math.max(step, 1);
  const first = Math.floor(low / step), count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: count + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

// The bars of a column: the text and the subjects of each.
function barsOf(column, rows) {
  if (column.text) {
    const groups = listedBy(rows.filter(row => column.at(row) !== "").map(row => [column.at(row), row]));
    const bars = [...groups].map(([text, rows]) => ({ text, rows })).sort((a, b) => b.rows.length - a.rows.length || (a.text < b.text ? -1 : 1));
    if (bars.length <= MOST_WORDS) return bars;
    const rest = bars.slice(MOST_WORDS - 1);
    return [...bars.slice(0, MOST_WORDS - 1), { text: `${rest.length} others`, rows: rest.flatMap(b => b.rows) }];
  }
  const known = rows.filter(row => Number.isFinite(column.at(row)));
  if (known.length === 0) return [];
  const edges = binEdges(known.map(row => column.at(row))), last = Math.max(edges.length - 2, 0);
  const whole = known.every(row => Number.isInteger(column.at(row))) && (edges.length < 2 || edges[1] - edges[0] <= 1);
  const bars = Array.from({ length: last + 1 }, (_, i) => ({ text: whole || edges[0] === edges.at(-1) ? shown(edges[i]) : `${shown(edges[i])} – ${shown(edges[i + 1])}`, rows: [] }));
  for (const row of known) {
    const x = column.at(row);
    let bin = edges.length < 2 ? 0 : Math.min(Math.max(edges.findLastIndex(edge => edge <= x), 0), last);
    bars[bin].rows.push(row);
  }
  return bars;
}

// Rows of text with bars, which work at any width and in screen readers.
function showBars(place, column, rows, choose) {
  const bars = barsOf(column, rows), most = Math.max(...bars.map(b => b.rows.length), 1);
  place.replaceChildren(...bars.map(bar => {
    const fill = make("i", {});
    fill.style.width = `${100 * bar.rows.length / most}%`;
    const share = `${shown(100 * bar.rows.length / rows.length, 3)} %`;
    const button = make("button", { type: "button", "aria-pressed": "false", title: `Show these ${bar.rows.length}` },
      make("span", { class: "word", text: bar.text, title: bar.text.length > 24 ? bar.text : null }), make("span", { class: "track" }, fill), make("span", { class: "count", text: `${grouped(bar.rows.length)} (${share})` }));
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      for (const other of place.children) other.setAttribute("aria-pressed", "false");
      button.setAttribute("aria-pressed", on);
      choose(on ? bar : null);
    });
    return button;
  }));
  return bars.reduce((sum, bar) => sum + bar.rows.length, 0);
}
