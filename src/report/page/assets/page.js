// Builds the page of a run.
const tables = data.tables.map(table);
const vessels = tables[0];
const threshold = data.threshold && vessels.rows > 0 ? new Threshold(data.threshold, vessels) : null;
const histogram = threshold && new Histogram(threshold);
const live = threshold ? [{ name: "state", text: true, at: row => threshold.state(row) }] : [];
let scene = null, sheet = null, picked = -1;

function pairs(entries) {
  return make("dl", { class: "pairs" }, ...entries.flatMap(([name, value]) => [make("dt", { text: name }), make("dd", { text: value })]));
}

// Selects a vessel in all views; -1 clears the selection. Its row is that of the shown table, if rows are vessels, or of the first.
function pick(row, turn = true) {
  picked = row;
  if (scene) scene.pick(row);
  sheet.pick(row, turn);
  const place = byId("picked");
  if (row < 0) {
    place.replaceChildren(make("p", { class: "quiet", text: "No vessel is selected." }));
    return;
  }
  const of = sheet.table.ofVessels ? sheet.table : vessels;
  const label = of.find("label")?.at(row);
  const rest = [...of.columns.filter(c => c.name !== "label" && c.name !== "uncertain"), ...live];
  const entries = rest.map(c => [c.name, shown(c.at(row), 7)]).filter(([, text]) => text !== "");
  const image = of === vessels ? imageOf(row) : null;
  place.replaceChildren(make("h3", { text: label ? `Vessel ${row}: ${label}` : `Vessel ${row}` }), ...(image ? [image] : []), pairs(entries));
}

function showFacts() {
  byId("facts").append(...data.facts.filter(([, value]) => value !== null).map(([name, value, unit]) =>
    make("div", {}, make("dt", { text: name }), make("dd", {}, shown(value), " ", make("small", { text: unit })))));
  const { input, willis } = data.record;
  byId("origin").textContent = `${input.path} (${input.format}, ${input.units}). Made by willis ${willis}.`;
}

// A section of the record, with nested objects as one list.
function recordPart(title, part) {
  const flat = (prefix, object) => Object.entries(object).flatMap(([key, value]) => {
    const name = prefix ? `${prefix}: ${key}` : key;
    if (value === null) return [];
    if (Array.isArray(value)) return [[name, value.length > 40 ? `${value.length} entries` : value.map(v => typeof v === "object" ? JSON.stringify(v) : shown(v, 7)).join(", ")]];
    return typeof value === "object" ? flat(name, value) : [[name, shown(value, 7)]];
  });
  return make("section", {}, make("h3", { text: title }), pairs(flat("", part)));
}

function showRun() {
  const { record } = data, box = byId("command");
  box.value = record.command;
  byId("copy").addEventListener("click", async () => {
    box.select();
    let done = false;
    try {
      await navigator.clipboard.writeText(box.value);
      done = true;
    } catch {
      done = document.execCommand("copy");
    }
    byId("copied").textContent = done ? "Copied." : "Selected: press Ctrl-C or Cmd-C to copy.";
  });
  byId("notes").append(...(record.notes || []).map(text => make("li", { text })));
  const parts = Object.entries(record).filter(([, part]) => part && typeof part === "object" && !Array.isArray(part));
  const loose = Object.entries(record).filter(([name, part]) => !["command"].includes(name) && (typeof part !== "object" || part === null));
  byId("record").append(recordPart("run", Object.fromEntries(loose)), ...parts.map(([name, part]) => recordPart(name.replaceAll("_", " "), part)));
  (record.classes || []).forEach(part => byId("record").append(recordPart(`class ${part.class}`, part)));
}

function showFigures() {
  byId("figures").hidden = data.figures.length === 0;
  byId("pictures").append(...data.figures.map(({ title, caption, source }) =>
    make("figure", {}, make("img", { src: source, alt: caption }), make("figcaption", {}, make("b", { text: title }), `. ${caption}`))));
}

function showTables() {
  const tabs = byId("tabs"), place = byId("sheet");
  const choose = at => {
    [...tabs.children].forEach((tab, i) => { tab.setAttribute("aria-selected", i === at); tab.tabIndex = i === at ? 0 : -1; });
    place.setAttribute("aria-labelledby", `tab-${at}`);
    sheet = new Sheet(tables[at], tables[at].ofVessels ? live : [], pick);
    place.replaceChildren(sheet.element);
    if (picked >= 0) pick(picked);
  };
  tabs.append(...tables.map((t, at) => {
    const tab = make("button", { type: "button", role: "tab", id: `tab-${at}`, "aria-controls": "sheet", text: `${t.title} (${grouped(t.rows)})` });
    tab.addEventListener("click", () => choose(at));
    return tab;
  }));
  tabs.addEventListener("keydown", event => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const at = [...tabs.children].indexOf(event.target);
    if (!by || at < 0) return;
    const next = (at + by + tables.length) % tables.length;
    choose(next);
    tabs.children[next].focus();
  });
  choose(0);
}

// The colours of the vessels: the chosen figure, on one scale for all its variants.
function colouring() {
  const by = byId("colour-by"), variant = byId("variant");
  const options = (select, names) => select.replaceChildren(...names.map((text, i) => make("option", { value: i, text })));
  const usable = data.colourings.map(c => ({ ...c, variants: c.variants.filter(([, at, name]) => tables[at].find(name)) })).filter(c => c.variants.length);
  options(by, usable.map(c => c.name));
  let colour = () => GREY;
  const choose = () => {
    const chosen = usable[by.value || 0];
    if (!chosen) return;
    const grey = row => chosen.uncertain_only && threshold && !threshold.uncertain[row];
    const each = chosen.variants.map(([, at, name]) => tables[at].find(name).values);
    const scale = scaleOf(chosen.scale, each.flatMap(values => Array.from(values).filter((_, row) => !grey(row))), chosen.legend);
    showScale(byId("colour-bar"), byId("colour-ticks"), scale, chosen.scale);
    const parts = [withUnit(chosen.name, chosen.unit && `(${chosen.unit})`)];
    if (chosen.scale === "log") parts.push(chosen.uncertain_only ? "logarithmic; zero takes the lightest colour" : "magnitude, logarithmic; zero is grey");
    if (chosen.scale === "mixed") parts.push("colours of the inlets mixed by their shares");
    if (scale.clipped) parts.push(`values more than ${DECADES} decades below the largest take the lightest colour`);
    if (chosen.uncertain_only) parts.push("certain vessels are grey");
    byId("colour-note").textContent = parts.join("; ") + ".";
    const values = each[variant.value || 0];
    const none = x => Number.isNaN(x) || x === 0 && chosen.scale === "log" && !chosen.uncertain_only;
    colour = row => grey(row) || none(values[row]) ? GREY : scale.colour(values[row]);
    dress();
  };
  by.addEventListener("change", () => {
    const names = usable[by.value].variants.map(([name]) => name), before = variant.selectedOptions[0]?.textContent;
    options(variant, names);
    variant.value = Math.max(names.indexOf(before), 0);
    byId("variant-label").hidden = names.length < 2;
    choose();
  });
  variant.addEventListener("change", choose);
  if (usable.length) {
    by.value = 0;
    by.dispatchEvent(new Event("change"));
  }
  return row => colour(row);
}

const shownState = { kept: byId("show-kept"), pruned: byId("show-pruned"), undecided: byId("show-undecided"), observed: byId("show-observed") };
function look(row) {
  if (!threshold) return 0;
  if (!threshold.uncertain[row]) return shownState.observed.checked ? 0 : LOOK.hidden;
  const of = threshold.open[row] ? "undecided" : threshold.kept[row] ? "kept" : "pruned";
  return (shownState[of].checked ? 0 : LOOK.hidden) | (threshold.kept[row] ? 0 : LOOK.pruned) | (threshold.open[row] ? LOOK.undecided : 0);
}

let colourOf = () => GREY;
function dress() {
  if (scene) scene.dress(row => colourOf(row), look);
}

function showThreshold() {
  byId("threshold").hidden = !threshold;
  if (!threshold) return;
  const slider = byId("slider"), number = byId("number");
  byId("rule").textContent = `${threshold.name} ${threshold.at_least ? "≥" : ">"} threshold`;
  byId("unit").textContent = threshold.unit;
  slider.max = Math.max(threshold.stops.length - 1, 0);
  slider.disabled = threshold.stops.length < 2;
  let waiting = 0;
  const show = () => {
    const { counts } = threshold, value = threshold.asRun ? "as the run decided" : threshold.now === null ? "none" : withUnit(shown(threshold.now), threshold.unit);
    for (const name of ["kept", "pruned", "undecided", "components", "cycles"]) byId(`count-${name}`).textContent = grouped(counts[name]);
    slider.value = threshold.stop();
    slider.setAttribute("aria-valuetext", value);
    number.value = threshold.now ?? "";
    histogram.show(byId("histogram"));
    dress();
    // Announced, and updated in the table, when the slider rests.
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      byId("live").textContent = `Threshold ${value}: ${counts.kept} kept, ${counts.pruned} pruned, ${counts.undecided} undecided, ${counts.components} components, ${counts.cycles} cycles.`;
      sheet?.refresh();
      if (picked >= 0) pick(picked, false);
    }, 250);
  };
  const set = cut => { threshold.set(cut); show(); };
  slider.addEventListener("input", () => set(threshold.stops[slider.value]));
  number.addEventListener("change", () => { if (number.value !== "" && Number.isFinite(Number(number.value))) set(Number(number.value)); else show(); });
  byId("to-run").addEventListener("click", () => { threshold.toRun(); show(); });
  byId("to-median").hidden = threshold.median === null;
  byId("to-median").addEventListener("click", () => set(threshold.median));
  for (const box of Object.values(shownState)) box.addEventListener("change", dress);
  show();
}

function showScene() {
  if (!data.scene || vessels.rows === 0) {
    const why = byId("no-scene");
    why.textContent = data.no_scene || "There is no vessel to draw.";
    why.hidden = false;
    byId("stage").hidden = byId("colouring").hidden = true;
    document.querySelector(".toggles").hidden = true;
    return;
  }
  scene = new SceneView(data.scene);
  listen(scene, row => pick(row), by => pick((picked + by + vessels.rows + (picked < 0 && by < 0 ? 1 : 0)) % vessels.rows));
  colourOf = colouring();
  const toggle = (id, shown, isOne) => {
    const box = byId(id);
    byId(`${id}-label`).hidden = !data.scene.markers.some(([kind]) => isOne(kind));
    box.checked = scene[shown];
    box.addEventListener("change", () => { scene[shown] = box.checked; dress(); });
  };
  toggle("markers", "markersShown", kind => !CUTS.has(kind));
  toggle("cuts", "cutsShown", kind => kind === "cut");
  toggle("suggested", "cutsShown", kind => kind === "suggested");
  byId("picture").addEventListener("click", () => make("a", { href: scene.canvas.toDataURL(), download: "vessels.png" }).click());
  dress();
}

showAll(showFacts, showTables, showScene, showThreshold, showFigures, showRun);
