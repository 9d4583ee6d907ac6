// Builds the page of a classification.
function showPhenotype() {
  const { input, willis } = data.record;
  byId("origin").textContent = `${input.path} (${input.format}, ${input.units}). Made by willis ${willis}.`;
  byId("circle").hidden = false;
  showCircle(data.phenotype, data.colours, null);
}

// Left and right rest on a frame that nobody stated.
function showFrame() {
  const note = (data.record.notes || []).find(text => text.startsWith("no frame is stated"));
  byId("warnings").hidden = !note;
  if (note) byId("warnings").append(make("li", { text: "Left and right are assumed: the file states no frame, and a mirrored file looks the same. --frame states it." }));
}

function showCollaterals() {
  const flows = table(data.collaterals);
  byId("collaterals").hidden = flows.rows === 0;
  if (flows.rows > 0) byId("sheet").append(new Sheet(flows, [], () => {}).element);
}

showAll(showPhenotype, showFrame, showCollaterals, showRun);
