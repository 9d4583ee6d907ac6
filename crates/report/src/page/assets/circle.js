// The Circle of Willis as a drawing: the patient's right is on the left, as a radiologist sees it; the front is at the top.
// Each segment: its course, where its text stands, and how the text is anchored. L and R mirror each other.
const RING_SEGMENTS = {
  "R-A1": { course: "M-92,-62 Q-70,-108 -20,-128", text: [-84, -126, "end"] },
  "R-PComm": { course: "M-92,-62 Q-104,10 -66,74", text: [-108, 16, "end"] },
  "R-P1": { course: "M-66,74 Q-30,44 0,52", text: [-40, 8, "middle"] },
  AComm: { course: "M-20,-128 L20,-128", text: [0, -104, "middle"] },
};
// The vessels around the ring, which are drawn for orientation: course, width, and place of the name.
const AROUND = {
  "R-ICA": { course: "M-92,-62 Q-112,-40 -116,-22", wide: 15, text: [-124, -16, "end"] },
  "R-M1": { course: "M-92,-62 Q-140,-92 -196,-78", wide: 11, text: [-196, -92, "start"] },
  "R-A2": { course: "M-20,-128 Q-26,-160 -14,-196", wide: 9, text: [-28, -188, "end"] },
  "R-P2": { course: "M-66,74 Q-110,84 -164,132", wide: 9, text: [-164, 116, "end"] },
  BA: { course: "M0,52 L0,132", wide: 13, text: [12, 112, "start"] },
  "R-VA": { course: "M0,132 Q-22,152 -48,192", wide: 9, text: [-54, 180, "end"] },
};
const OPPOSITE = { end: "start", start: "end", middle: "middle" };

// The parts with their names, those of the right mirrored for the left.
const ofBothSides = parts => Object.entries(parts).flatMap(([name, part]) => {
  if (!name.startsWith("R-")) return [{ name, ...part }];
  const [x, y, anchor] = part.text, course = part.course.replace(/(-?\d+),/g, (_, across) => `${-across},`);
  return [{ name, ...part }, { ...part, name: name.replace("R-", "L-"), course, text: [-x, y, OPPOSITE[anchor]] }];
});

// What is known of a segment: `probability` (null where the vessels were taken as they stand), `present` in the most probable variant,
// `notSeen` where nothing was seen and the probability is that of the prior, `hypoplastic` where it is thin.
function segmentState(phenotype, name) {
  const known = phenotype.probabilities, listed = field => [phenotype, known].some(of => of?.[field]?.includes(name));
  const [notSeen, hypoplastic, impossible] = ["not_seen", "hypoplastic", "impossible"].map(listed);
  return { name, probability: known?.segments[name] ?? null, present: phenotype.segments[name], notSeen, hypoplastic, impossible };
}

// A probability as it stands after "P": `= .35`, or `> .999`.
function isChance(p) {
  const text = chance(p);
  return /^[<>]/.test(text) ? `P ${text}` : `P = ${text}`;
}

// A probability in two or three figures; never a rounded 0 or 1.
function chance(p) {
  if (!Number.isFinite(p)) return "";
  if (p > 0.9995) return "> .999";
  if (p < 0.0005) return "< .001";
  return (p > 0.985 || p < 0.015 ? p.toFixed(3) : p.toFixed(2)).replace(/^0/, "");
}

function stateWords(state) {
  const words = [];
  if (state.notSeen) words.push("not seen");
  else if (!state.present) words.push(state.impossible ? "no candidate" : "absent");
  if (state.hypoplastic && state.present && !state.notSeen) words.push("hypoplastic");
  return words.join(", ");
}

function drawSegment(state, { course, text: [x, y, anchor] }, colours) {
  const wide = state.hypoplastic ? 6 : 13, named = state.probability !== null ? isChance(state.probability) : state.present ? "present" : "absent";
  const seen = !state.notSeen, fill = state.probability === null ? (state.present ? "var(--kept)" : "var(--paper)") : `rgb(${blend(colours, state.probability)})`;
  const whole = [state.name, named, stateWords(state)].filter((word, at, all) => word && all.indexOf(word) === at).join(", ");
  const line = (style) => draw("path", { d: course, fill: "none", "stroke-linecap": "butt", ...style });
  const strokes = seen
    ? [line({ stroke: "var(--mark)", "stroke-width": wide + 3, "stroke-dasharray": state.present ? null : "3 3" }), line({ stroke: "var(--paper)", "stroke-width": wide }),
      line({ stroke: fill, "stroke-width": state.present ? wide : wide - 3, "stroke-opacity": state.present ? 1 : 0.75 })]
    : [line({ stroke: "var(--quiet)", "stroke-width": 3, "stroke-dasharray": "7 6" })];
  const label = draw("text", { x, y, "text-anchor": anchor });
  label.append(draw("tspan", { x, class: "segment-name", text: state.name }));
  const under = state.probability !== null ? chance(state.probability) : "";
  const rest = [under, stateWords(state)].filter(Boolean);
  rest.forEach(text => label.append(draw("tspan", { x, dy: "1.15em", text })));
  return draw("g", { class: "segment", "data-segment": state.name, "data-state": stateWords(state) || "present" }, draw("title", { text: whole }), ...strokes, label);
}

// The drawing of a phenotype; `colours` is the colour map of probabilities.
function drawCircle(phenotype, colours) {
  const around = ofBothSides(AROUND).flatMap(({ name, course, wide, text: [x, y, anchor] }) => {
    const unseen = phenotype.segments[name] === false;
    return [draw("path", { d: course, fill: "none", stroke: "var(--vessel)", "stroke-width": unseen ? 3 : wide, "stroke-dasharray": unseen ? "7 6" : null, "stroke-linecap": "round" }),
      draw("text", { x, y, "text-anchor": anchor, class: "around", text: unseen ? `${name}: not seen` : name })];
  });
  const segments = ofBothSides(RING_SEGMENTS), states = segments.map(({ name }) => segmentState(phenotype, name));
  const ring = segments.map((segment, at) => drawSegment(states[at], segment, colours));
  const said = states.map(s => `${s.name} ${s.probability === null ? "" : chance(s.probability)} ${stateWords(s) || "present"}`).join("; ");
  const svg = draw("svg", { viewBox: "-214 -214 428 428", role: "img", "aria-label": `The Circle of Willis. ${said}.`, class: "circle" }, ...around, ...ring,
    draw("text", { x: -206, y: 6, class: "side", text: "R" }), draw("text", { x: 206, y: 6, class: "side", "text-anchor": "end", text: "L" }));
  return { svg, states };
}

// A list of the next most probable variants and of what would decide between them. `flies(row)` goes to a vessel, where there is a view;
// `called(row)` is its name.
function variantList(phenotype, flies, called) {
  const known = phenotype.probabilities, parts = [];
  const says = (words, p) => make("li", {}, words, " ", make("b", { text: isChance(p) }));
  if (!known) return [make("p", { class: "quiet", text: "The vessels were taken as they stand, so there are no probabilities. Classify the folder of a run to have them." })];
  const [, ...others] = known.variants;
  if (others.length) parts.push(make("h3", { text: "Next most probable" }), make("ol", { class: "variants" }, ...others.slice(0, 3).map(v => says(v.words, v.probability))));
  const deciding = known.deciding.slice(0, 5);
  if (deciding.length) {
    const item = d => {
      const name = called?.(d.edge) ?? `connection ${d.edge} (${d.id_a} to ${d.id_b})`;
      const go = flies ? make("button", { type: "button", text: name, click: () => flies(d.edge) }) : make("span", { text: name });
      const own = d.probability === null ? "" : `, ${isChance(d.probability)}`;
      return make("li", {}, go, `${own}: in ${chance(d.share)} of the plausible topologies; ${chance(d.variant_with)} of those with it have the variant, ${chance(d.variant_without)} of those without it`);
    };
    parts.push(make("h3", { text: "What would decide" }), make("ol", { class: "variants" }, ...deciding.map(item)));
  }
  return parts;
}

// Fills the section of a phenotype.
function showCircle(phenotype, colours, flies, called) {
  const { svg, states } = drawCircle(phenotype, colours);
  const known = phenotype.probabilities;
  const any = test => states.some(test);
  const notes = [known ? "Darker is more probable." : null, any(s => !s.present && !s.notSeen) ? "A dashed outline is a segment that the most probable variant lacks." : null,
    any(s => s.impossible && !s.present && !s.notSeen) ? "“No candidate”: the input does not have the segment, and no possible connection could make it, so that its P says nothing about the patient if the extraction missed it." : null,
    any(s => s.notSeen) ? "A grey dashed line is a segment that was not seen; its probability is what is usual." : null, any(s => s.hypoplastic) ? "A thin one is hypoplastic." : null];
  byId("circle-drawing").replaceChildren(svg, make("p", { class: "quiet", text: ["Seen as a radiologist sees it: the patient's right is on the left, the front is at the top.", ...notes].filter(Boolean).join(" ") }));
  byId("circle-words").replaceChildren(
    make("p", { class: "variant-words" }, make("b", { text: phenotype.words.replace(/^./, c => c.toUpperCase()) }), known ? ` ${isChance(known.variant)}` : ""),
    ...variantList(phenotype, flies, called));
}
