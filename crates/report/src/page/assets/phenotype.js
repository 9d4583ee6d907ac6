// Builds the page of a classification.
function showPhenotype() {
  byId("circle").hidden = false;
  showCircle(data.phenotype, data.colours, null);
}

// One sentence: the variant, how sure it is, what would decide, what takes over.
function showAnswer() {
  const { phenotype, record } = data, known = phenotype.probabilities, deciding = known?.deciding.length ?? 0, out = known?.not_seen ?? [];
  const flows = table(data.collaterals), of = name => row => flows.find(name).at(row);
  const takes = upTo(flows.rows).filter(row => of("takes_over")(row)).map(row => `${of("artery")(row)} for ${of("occluded")(row)}`);
  byId("answer-words").append(make("b", { text: `${phenotype.words.replace(/^./, c => c.toUpperCase())}${known ? `, ${isChance(known.variant)}` : ""}` }),
    known ? deciding ? `; ${count(deciding, "open connection")} would change how sure that is` : "; no open connection changes that" : "; the vessels were taken as they stand",
    out.length ? `; too little is seen of ${out.join(", ")}` : "", takes.length ? `. The communicating artery that takes over: ${takes.join(", ")}` : "", ".");
  const frame = (record.notes || []).find(text => text.startsWith("no frame is stated")), said = frame?.replace(/^./, c => c.toUpperCase());
  const warnings = [frame && "Left and right are assumed: the file states no frame, and a mirrored file looks the same. --frame states it.", ...data.warnings.filter(text => text !== said)].filter(Boolean);
  showSource(warnings);
  byId("of-run").hidden = !data.run;
  if (data.run) byId("of-run").append(make("a", { href: wayTo(data.run, "circle"), text: "The run that was classified, with its vessels and connections" }));
}

function showCollaterals() {
  const flows = table(data.collaterals);
  byId("collaterals").hidden = flows.rows === 0;
  if (flows.rows > 0) byId("sheet").append(new Sheet(flows, [], () => {}).element);
}

showAll(showBack, showPhenotype, showAnswer, showCollaterals, showRun);
