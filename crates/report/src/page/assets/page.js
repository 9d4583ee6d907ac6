// Builds the page of a run.
// Connections less probable than this are drawn only where they are asked for.
const UNLIKELY = 0.05;
const tables = data.tables.map(table);
const vessels = tables[0];
const threshold = data.threshold && vessels.rows > 0 ? new Threshold(data.threshold, vessels, tables.find(t => t.title === "Nodes")) : null;
const histogram = threshold && new Histogram(threshold);
const live = threshold ? [{ name: "state", text: true, at: row => threshold.state(row) }] : [];
const frame = data.record.input?.frame;
// What a vessel is called: by its label, else by the artery that geometry finds it to be; empty without one.
const nameOf = row => vessels.find("label")?.at(row) || vessels.find("artery")?.at(row) || "";
let scene = null, slices = null, flows = null, sheet = null, picked = -1, decisions = null, review = null, edits = null;

// Selects a vessel in all views; -1 clears the selection. Its row is that of the shown table, if rows are vessels, or of the first.
function pick(row, turn = true, reveal = turn) {
  picked = row;
  if (scene) {
    if (row < 0) scene.showAll();
    scene.pick(row);
    if (row >= 0 && reveal) scene.reveal(row);
  }
  sheet.pick(row, turn);
  showPicked();
}

function showPicked() {
  const place = byId("picked"), row = picked;
  review?.select(row);
  showChoice();
  if (row < 0) {
    place.replaceChildren(make("p", { class: "quiet", text: "No vessel is selected." }));
    return;
  }
  const of = sheet.table.ofVessels ? sheet.table : vessels;
  const label = nameOf(row);
  const rest = [...of.columns.filter(c => c.name !== "label" && !UNSHOWN.has(c.name)), ...live];
  const entries = rest.map(c => [c.name, shown(c.at(row), 7)]).filter(([, text]) => text !== "");
  const beside = threshold?.uncertain[row] && scene ? review.alternatives(row, scene.shape) : null;
  const figures = pairs(entries);
  const cuts = beside && slices ? slices.of(row, threshold.rivals(row).filter(other => !(threshold.chance(other) < UNLIKELY)), other => Boolean(threshold.kept[other])) : null;
  const pairings = review && scene ? review.pairings(row) : null;
  place.replaceChildren(...[make("h3", { text: label ? `Vessel ${row}: ${label}` : beside ? review.name(row).replace(/^./, c => c.toUpperCase()) : `Vessel ${row}` }), cuts, pairings, beside,
    beside ? make("details", { open: place.querySelector("details")?.open ?? false }, make("summary", { text: "All figures" }), figures) : figures].filter(Boolean));
}

// What can be decided on the selected vessel, under the view.
function showChoice() {
  const open = Boolean(decisions) && picked >= 0 && Boolean(threshold.uncertain[picked]);
  byId("decide").hidden = !open;
  if (!open) return;
  const { decision, comment } = decisions.of(picked);
  for (const button of document.querySelectorAll("[data-decide]")) button.setAttribute("aria-pressed", String(button.dataset.decide === decision));
  if (document.activeElement !== byId("comment")) byId("comment").value = comment;
}

// Decides on the selected connection, and goes on to the next.
function decideHere(decision) {
  const row = picked, again = decisions.of(row).decision === decision;
  decisions.decide([row], again ? null : decision);
  if (!again && review.open.length) review.step(1);
}

// Flies to an uncertain connection and shows its alternatives; to any other vessel as a selection does.
function goTo(row) {
  pick(row, true, false);
  if (!scene || !threshold?.uncertain[row]) { scene?.reveal(row); return; }
  const rivals = threshold.rivals(row);
  showChances(row);
  // Alternatives that are hardly probable do not widen the view.
  const likely = rivals.filter(one => threshold.probability === null || !(threshold.chance(one) < 0.03));
  scene.goTo(row, rivals, likely);
  scene.dress();
  if (byId("view").getBoundingClientRect().top < 0) byId("view").scrollIntoView({ block: "start" });
}

// How probable a connection and its alternatives are, beside them in the view.
function showChances(row) {
  const all = [row, ...threshold.rivals(row)].filter((one, at) => at === 0 || !(threshold.chance(one) < 0.02)).slice(0, 12);
  const text = one => all.length > 1 ? `${one}: ${review.figure(one)}` : review.figure(one);
  scene.overlay.chances = all.map(one => ({ at: scene.shape.middle(one), text: text(one), strong: one === row }));
}

// One sentence that says what was found.
function showAnswer() {
  const words = [], figure = (text, strong = true) => make(strong ? "b" : "span", { text });
  if (threshold) {
    const origins = vessels.find("origin"), uncertain = threshold.known.length ? upTo(vessels.rows).filter(row => threshold.uncertain[row]) : [];
    const candidates = uncertain.filter(row => origins?.at(row) !== "contact" && origins?.at(row) !== "observed"), contacts = uncertain.filter(row => origins?.at(row) === "contact");
    const observed = uncertain.length - candidates.length - contacts.length, { counts, expected } = threshold;
    const kept = candidates.filter(row => threshold.kept[row]).length;
    words.push(figure(candidates.length ? `${grouped(kept)} of ${count(candidates.length, "possible connection")} kept` : "There is no possible connection"));
    const cut = contacts.filter(row => !threshold.kept[row]).length;
    if (contacts.length) words.push(", ", figure(`${grouped(cut)} of ${count(contacts.length, "observed contact")} cut, ${grouped(contacts.length - cut)} kept`));
    if (observed) words.push(", ", figure(`${count(uncertain.filter(row => origins?.at(row) === "observed" && !threshold.kept[row]).length, "observed vessel")} pruned`));
    // As many as the list has.
    const asked = review.total;
    if (uncertain.length || asked) words.push("; ", figure(asked === 0 ? "no question for a person" : `${count(asked, "question")} for a person`));
    const about = x => x < 0.05 ? "none" : `about ${shown(x, x < 1 ? 1 : 2)}`;
    if (expected) words.push("; of all that is kept ", figure(`${about(expected.wrong)} expected to be wrong, ${about(expected.missed)} missed`, false));
    words.push(". ", figure(`The vessels form ${count(counts.components, "part")}${counts.cycles ? ` with ${count(counts.cycles, "loop")}` : ""}.`, false));
    if (threshold.decided.size) words.push(" ", figure(`${grouped(threshold.decided.size)} decided by a person.`, false));
    else if (!threshold.asRun && threshold.now !== threshold.cut) words.push(" ", figure("At another threshold than that of the run.", false));
  }
  words.push(...data.lead.map(([text, strong]) => figure(text, strong)));
  const phenotype = data.phenotype;
  if (phenotype) {
    const known = phenotype.probabilities;
    words.push(" ", make("a", { href: "#circle", text: `Circle of Willis: ${phenotype.words}${known ? ` (${isChance(known.variant)})` : ""}.` }));
  }
  byId("answer-words").hidden = words.length === 0;
  byId("answer-words").replaceChildren(...words);
}

function showFacts() {
  const tiles = data.facts.filter(([, value]) => value !== null).map(([name, value, unit]) => make("div", {}, make("dt", { text: name }), make("dd", {}, shown(value), " ", make("small", { text: unit }))));
  byId("facts").append(...tiles);
  showSource(data.warnings);
}

// Gives an image its source: an SVG is packed by gzip.
async function showPicture(image, { source, is_svg }) {
  if (!is_svg) return image.src = `data:image/png;base64,${source}`;
  const drawing = await new Response(new Blob([decoded("u8", source)]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  image.src = `data:image/svg+xml,${encodeURIComponent(drawing)}`;
}

function showFigures() {
  byId("figures").hidden = data.figures.length === 0;
  byId("pictures").append(...data.figures.map(figure => {
    const { title, caption, wide } = figure, image = make("img", { alt: caption });
    showPicture(image, figure);
    const enlarge = make("button", { type: "button", class: "enlarge", "aria-pressed": false, "aria-label": `Enlarge ${title}` }, image);
    const whole = make("figure", { class: wide ? "wide" : null }, enlarge, make("figcaption", {}, make("b", { text: title }), `. ${caption} Click to enlarge.`));
    enlarge.addEventListener("click", () => enlarge.setAttribute("aria-pressed", String(whole.classList.toggle("large"))));
    return whole;
  }));
}

function showTables() {
  const tabs = byId("tabs"), place = byId("sheet");
  const choose = at => {
    [...tabs.children].forEach((tab, i) => { tab.setAttribute("aria-selected", i === at); tab.tabIndex = i === at ? 0 : -1; });
    place.setAttribute("aria-labelledby", `tab-${at}`);
    sheet = new Sheet(tables[at], tables[at].ofVessels ? live : [], row => pick(row));
    place.replaceChildren(sheet.element);
    if (picked >= 0) pick(picked, false);
  };
  tabs.append(...tables.map((t, at) =>
    make("button", { type: "button", role: "tab", id: `tab-${at}`, "aria-controls": "sheet", text: `${t.title} (${grouped(t.rows)})`, click: () => choose(at) })));
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
  const by = byId("colour-by"), variant = byId("colour-variant");
  const options = (select, names) => select.replaceChildren(...names.map((text, i) => make("option", { value: i, text })));
  const usable = data.colourings.map(c => ({ ...c, variants: c.variants.filter(([, at, name]) => tables[at].find(name)) })).filter(c => c.variants.length);
  options(by, usable.map(c => c.name));
  const slide = cycleSlider(variant, usable);
  let colour = () => GREY;
  const choose = () => {
    const chosen = usable[by.value || 0];
    if (!chosen) return;
    const grey = row => chosen.uncertain_only && threshold && !threshold.uncertain[row];
    const each = chosen.variants.map(([, at, name]) => tables[at].find(name).values);
    const scale = scaleOf(chosen.scale, each.flatMap(values => Array.from(values).filter((_, row) => !grey(row))), chosen.legend);
    showScale(byId("colour-bar"), byId("colour-ticks"), scale);
    const parts = [];
    if (chosen.scale === "log") parts.push(chosen.uncertain_only ? "logarithmic; zero takes the lightest colour" : "magnitude, logarithmic; zero is grey");
    if (chosen.scale === "mixed") parts.push("colours of the inlets mixed by their shares");
    if (scale.clipped) parts.push(`values more than ${DECADES} decades below the largest take the lightest colour`);
    if (chosen.uncertain_only) parts.push("certain vessels are grey");
    const name = withUnit(chosen.name, chosen.unit && `(${chosen.unit})`);
    byId("colour-note").textContent = [name, ...parts].join("; ") + ".";
    flows?.show(chosen.variants[variant.value || 0][0] === "unperturbed");
    const values = each[variant.value || 0], decidedColour = chosen.variants[0][2] === "probability" && threshold;
    const none = x => Number.isNaN(x) || x === 0 && chosen.scale === "log" && !chosen.uncertain_only;
    colour = row => {
      const x = decidedColour && threshold.decided.size ? threshold.chance(row) : values[row];
      return grey(row) || none(x) ? GREY : scale.colour(x);
    };
    if (scene) scene.overlay.legend = { name, ticks: scale.ticks, colours: scale.bar };
    dress();
  };
  by.addEventListener("change", () => {
    const names = usable[by.value].variants.map(([name]) => name), before = variant.selectedOptions[0]?.textContent;
    options(variant, names);
    variant.value = Math.max(names.indexOf(before), 0);
    byId("variant-label").hidden = names.length < 2;
    slide(by.value);
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
  // Most of what the answer leaves out is hardly probable: it shows where it is asked for, or beside what is selected.
  const unlikely = of === "pruned" && !byId("show-unlikely").checked && row !== picked && !scene?.near?.has(row) && threshold.chance(row) < UNLIKELY && !decisions?.made.has(row);
  return (shownState[of].checked && !unlikely ? 0 : LOOK.hidden) | (threshold.kept[row] ? 0 : LOOK.pruned) | (threshold.open[row] ? LOOK.undecided : 0);
}

let colourOf = () => GREY;
function dress() {
  if (!scene) return;
  scene.certainShown = shownState.observed.checked;
  scene.dress(row => colourOf(row), look);
}

function showThreshold() {
  byId("threshold").hidden = byId("states").hidden = byId("fit-doubt").hidden = !threshold?.uncertain.some(Boolean);
  if (!threshold) return () => {};
  const slider = byId("slider"), number = byId("number");
  byId("rule").textContent = `${threshold.name} ${threshold.at_least ? "≥" : ">"} threshold`;
  byId("unit").textContent = threshold.unit;
  slider.max = Math.max(threshold.stops.length - 1, 0);
  slider.disabled = threshold.stops.length < 2;
  number.placeholder = "as the run decided";
  let waiting = 0;
  const show = () => {
    const { counts } = threshold, value = threshold.asRun ? "as the run decided" : threshold.now === null ? "none" : withUnit(shown(threshold.now), threshold.unit);
    for (const name of ["kept", "pruned", "undecided", "components", "cycles"]) byId(`count-${name}`).textContent = grouped(counts[name]);
    slider.value = threshold.stop();
    slider.setAttribute("aria-valuetext", value);
    number.value = threshold.asRun || threshold.now === null ? "" : threshold.now === threshold.cut ? threshold.round(threshold.stop()) : threshold.now;
    histogram.show(byId("histogram"));
    showAnswer();
    dress();
    // Announced, and updated in the table, when the slider rests.
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      byId("live").textContent = `Threshold ${value}: ${counts.kept} kept, ${counts.pruned} pruned, ${counts.undecided} undecided, ${counts.components} components, ${counts.cycles} cycles.`;
      sheet?.refresh();
      // Decisions have shown it already.
      if (review.setting !== review.settingShown) { review.show(); showAnswer(); }
      if (picked >= 0) showPicked();
    }, 250);
  };
  const set = cut => { threshold.set(cut); show(); };
  slider.addEventListener("input", () => set(threshold.round(Number(slider.value))));
  number.addEventListener("change", () => { if (number.value !== "" && Number.isFinite(Number(number.value))) set(Number(number.value)); else show(); });
  byId("to-run").addEventListener("click", () => { threshold.toRun(); show(); });
  byId("to-median").hidden = threshold.median === null;
  // The median in few digits, which keeps the same vessels.
  byId("to-median").addEventListener("click", () => {
    threshold.set(threshold.median);
    if (threshold.median === threshold.cut) show(); else set(threshold.round(threshold.stop()));
  });
  for (const box of [...Object.values(shownState), byId("show-unlikely")]) box.addEventListener("change", dress);
  byId("unlikely-label").hidden = threshold.probability === null;
  show();
  return show;
}

function takeBack() {
  const row = decisions.undo();
  if (row >= 0) goTo(row);
}

function showReview() {
  if (!threshold) return;
  const show = () => {
    review.show();
    edits.show();
    if (picked >= 0 && scene?.overlay.chances.length) showChances(picked);
    showThreshold.again();
    if (picked >= 0) showPicked();
  };
  decisions = new Decisions(threshold, vessels, tables.find(t => t.title === "Nodes"), show);
  review = new Review(threshold, decisions, vessels, goTo);
  edits = new Edits(decisions, scene);
  byId("review").hidden = !threshold.uncertain.some(Boolean) && review.total === 0;
  byId("review-more").addEventListener("click", () => { review.shown = Infinity; review.show(); });
  for (const id of ["undo", "decide-undo"]) byId(id).addEventListener("click", takeBack);
  byId("download").addEventListener("click", () => decisions.download());
  byId("decide-next").addEventListener("click", () => review.step(1));
  for (const button of document.querySelectorAll("[data-decide]")) button.addEventListener("click", () => decideHere(button.dataset.decide));
  byId("comment").addEventListener("change", () => decisions.comment(picked, byId("comment").value.trim()));
  byId("review-filter").addEventListener("input", () => { review.words = byId("review-filter").value.trim().toLowerCase(); review.show(); });
  byId("review-order").addEventListener("change", () => { review.order = byId("review-order").value; review.show(); });
  byId("many").hidden = threshold.probability === null;
  const many = (id, decision, fits) => byId(id).addEventListener("click", () => {
    const rows = review.open.map(item => item.row).filter(row => fits(threshold.chance(row)));
    if (rows.length) decisions.decide(rows, decision);
  });
  many("accept-many", "accept", p => p >= Number(byId("accept-from").value));
  many("reject-many", "reject", p => p <= Number(byId("reject-to").value));
  byId("load").addEventListener("change", async () => {
    const [file] = byId("load").files, note = byId("load-note");
    if (!file) return;
    try {
      const loaded = decisions.load(await file.text());
      note.textContent = `${count(loaded, "decision")} loaded from ${file.name}.`;
    } catch (fault) {
      note.textContent = `${file.name}: ${fault.message}. Nothing was loaded.`;
    }
    byId("load").value = "";
  });
  if (decisions.restored) byId("load-note").textContent = "Decisions that this browser kept are taken up.";
  byId("fit-doubt").addEventListener("click", () => {
    const rows = review.open.length ? review.open.map(item => item.row) : upTo(vessels.rows).filter(row => threshold.uncertain[row]);
    scene.showAll();
    dress();
    if (rows.length) scene.fly(scene.camera.fitting(rows.map(row => scene.shape.middle(row))));
  });
  review.show();
}

function showTooltip(row, x, y) {
  const tip = byId("tooltip");
  tip.hidden = !(row >= 0);
  if (tip.hidden) return;
  const label = nameOf(row), radius = vessels.find("radius_mm")?.at(row);
  const lines = [label ? `${label} (vessel ${row})` : `Vessel ${row}`];
  if (threshold?.uncertain[row]) lines.push(`${review.figure(row)}, ${threshold.state(row)}`);
  if (radius !== undefined) lines.push(`radius ${shown(radius, 2)} mm, length ${shown(vessels.find("length_mm").at(row), 3)} mm`);
  tip.replaceChildren(...lines.map(text => make("div", { text })));
  const [w, h] = scene.camera.size;
  tip.style.left = `${Math.min(x + w / 2 + 14, w - 190)}px`;
  tip.style.top = `${Math.min(y + h / 2 + 12, h - 70)}px`;
}

function showScene() {
  if (!data.scene || vessels.rows === 0) {
    const why = byId("no-scene");
    why.textContent = data.no_scene || "There is no vessel to draw.";
    why.hidden = false;
    byId("stage").hidden = true;
    return;
  }
  scene = new SceneView(data.scene, vessels, frame, data.segmentation);
  slices = threshold ? new Slices(data.segmentation, data.image_places, scene.shape, frame, scene.camera.along) : null;
  byId("sides-note").hidden = frame in ANATOMICAL;
  if (scene.sidesOfLabels) byId("sides-note").textContent = "The input states no frame: left and right in the view are those of the labels.";
  if (!(frame in ANATOMICAL)) for (const axis of ["y", "x", "z"]) document.querySelector(`[data-view=${axis}]`).textContent = axis;
  listen(scene, {
    pick: row => {
      if (edits?.open) { if (row >= 0) edits.take(scene.touched); }
      else if (threshold?.uncertain[row] && row >= 0) goTo(row);
      else pick(row);
    },
    hover: showTooltip,
    whole: () => { scene.showAll(); dress(); },
    step: by => {
      if (review?.items.length || parent !== window) review?.step(by);
      else pick((picked + by + vessels.rows + (picked < 0 && by < 0 ? 1 : 0)) % vessels.rows);
    },
    key: name => {
      const decision = { a: "accept", r: "reject", x: "unsure" }[name];
      if (name === "u" && decisions) { takeBack(); return true; }
      if (!decision || !decisions || !threshold.uncertain[picked]) return false;
      decideHere(decision);
      return true;
    },
  });
  flows = vessels.find("flow_mL_per_min") ? new Flows(scene, vessels, tables) : null;
  colourOf = colouring();
  const toggle = (id, isOne, change) => {
    const box = byId(id);
    byId(`${id}-label`).hidden = !isOne;
    box.addEventListener("change", () => { change(box.checked); dress(); });
  };
  const has = isOne => data.scene.markers.some(([kind]) => isOne(kind));
  toggle("markers", has(kind => !CUTS.has(kind)), on => { scene.markersShown = on; });
  toggle("cuts", has(kind => kind === "cut"), on => { scene.cutsShown = on; });
  toggle("suggested", has(kind => kind === "suggested"), on => { scene.cutsShown = on; });
  toggle("hull", Boolean(scene.hull), on => { scene.hullShown = on; });
  if (scene.hull) tellResolution(data.segmentation);
  toggle("names", scene.overlay.names.length > 0, on => { scene.overlay.namesShown = on; });
  toggle("flow", Boolean(flows), on => { scene.overlay.flowShown = on; });
  byId("markers").checked = scene.markersShown;
  byId("picture").addEventListener("click", () => make("a", { href: scene.picture().toDataURL(), download: `${[nameOfInput(), picked >= 0 ? review?.name(picked).replace(/\W+/g, "-") ?? picked : ""].filter(Boolean).join("-")}.png` }).click());
  dress();
}

// The name of the input without its folder and its endings.
function nameOfInput() {
  return data.record.input.path.split(/[\\/]/).at(-1).replace(/(\.[a-z]+)?(\.gz)?$/i, "") || "vessels";
}

// How fine the surface of the segmentation is.
function tellResolution({ affine, block }) {
  const sides = [0, 1, 2].map(axis => shown(Math.hypot(...affine.map(row => row[axis])), 2)).join(" × ");
  byId("hull-words").textContent = block > 1 ? `segmentation, in blocks of ${sides} mm` : "segmentation";
  byId("hull-note").textContent = ` The surface of the segmentation is smoothed by less than half a ${block > 1 ? "block" : "voxel"}; ${block > 1
    ? `it is drawn in blocks of ${block} × ${block} × ${block} voxels (${sides} mm), which thin vessels may fall between` : `its voxels are ${sides} mm`}.`;
}

function showPhenotype() {
  byId("circle").hidden = !data.phenotype;
  if (data.phenotype) showCircle(data.phenotype, data.colours, scene && goTo, review && (row => review.name(row)));
}

showAll(showBack, showFacts, showTables, showScene, showReview, () => { showThreshold.again = showThreshold(); }, showAnswer, showPhenotype, showFigures, showRun);
