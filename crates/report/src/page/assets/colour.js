// Colours for figures: the map of the pictures (viridis, light to dark), and a diverging one for signed figures.
const GREY = [169, 173, 179];
const SIDES = [[0, 83, 141], [200, 200, 200], [176, 74, 0]];

function blend(colours, t) {
  const steps = colours.length - 1;
  const place = Math.min(Math.max(t || 0, 0), 1) * steps;
  const low = Math.min(Math.floor(place), steps - 1);
  return colours[low].map((c, i) => Math.round(c + (place - low) * (colours[low + 1][i] - c)));
}

// The largest number of decades on a logarithmic scale, from the largest value down.
const DECADES = 12;

// The scale for some values: `share` converts a value to [0, 1], `ticks` are the labels by share.
// A mixed figure is a colour itself, made of those of the legend.
function scaleOf(kind, values, legend) {
  if (kind === "mixed") {
    const colour = x => [x >> 16 & 255, x >> 8 & 255, x & 255];
    return { colour, legend, bar: t => legend[Math.min(Math.floor(t * legend.length), legend.length - 1)][1], ticks: legend.map(([name], i) => [(i + 0.5) / legend.length, name]), clipped: false };
  }
  const bar = t => blend(data.colours, t);
  if (kind === "share") return { colour: bar, bar, ticks: [0, 0.25, 0.5, 0.75, 1].map(t => [t, shown(t)]), clipped: false };
  let low = Infinity, high = -Infinity, most = 0, least = Infinity;
  for (const v of values) {
    const size = Math.abs(v);
    if (!Number.isFinite(size)) continue;
    low = Math.min(low, size);
    high = Math.max(high, size);
    if (size > 0) least = Math.min(least, size);
    most = Math.max(most, size);
  }
  if (kind === "diverging") {
    const share = x => 0.5 + 0.5 * x / (most || 1);
    const tick = x => [share(x), x > 0 ? "+" + shown(x, 3) : shown(x, 3)];
    return { colour: x => blend(SIDES, share(x)), bar: t => blend(SIDES, t), ticks: most > 0 ? [tick(-most), tick(0), tick(most)] : [tick(0)], clipped: false };
  }
  if (kind === "log" && most > 0) {
    let [from, to] = [Math.log10(least), Math.log10(most)];
    const clipped = to - from > DECADES;
    if (clipped) from = to - DECADES;
    if (to - from < 1) [from, to] = [(from + to) / 2 - 0.5, (from + to) / 2 + 0.5];
    const share = x => x === 0 ? 0 : (Math.log10(Math.abs(x)) - from) / (to - from);
    const step = Math.max(1, Math.ceil((to - from) / 5));
    const ticks = [];
    for (let e = Math.ceil(from); e <= to; e += step) ticks.push([(e - from) / (to - from), power(e)]);
    const at = t => shown(10 ** (from + t * (to - from)), 3);
    return { colour: x => bar(share(x)), bar, ticks: ticks.length > 2 ? ticks : [0, 0.5, 1].map(t => [t, at(t)]), clipped };
  }
  if (!(low <= high)) [low, high] = [0, 1];
  const range = high - low || 1;
  const share = x => (Math.abs(x) - low) / range;
  return { colour: x => bar(share(x)), bar, ticks: [0, 0.5, 1].map(t => [t, shown(low + t * range, 3)]), clipped: false };
}

// The colour bar with its ticks.
function showScale(canvas, ticks, scale) {
  const ink = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x++) {
    ink.fillStyle = `rgb(${scale.bar(x / (canvas.width - 1))})`;
    ink.fillRect(x, 0, 1, canvas.height);
  }
  ticks.replaceChildren(...scale.ticks.map(([share, text]) => {
    const label = make("span", { text, class: share < 0.06 ? "first" : share > 0.94 ? "last" : null });
    label.style.left = `${100 * share}%`;
    return label;
  }));
}
