// Builds the page of a classification.
function showPhenotype() {
  const { input, willis } = data.record;
  byId("origin").textContent = `${input.path} (${input.format}, ${input.units}). Made by willis ${willis}.`;
  byId("circle").hidden = false;
  showCircle(data.phenotype, data.colours, null);
}

function showCollaterals() {
  const flows = table(data.collaterals);
  byId("collaterals").hidden = flows.rows === 0;
  if (flows.rows > 0) byId("sheet").append(new Sheet(flows, [], () => {}).element);
}

showAll(showPhenotype, showCollaterals, showRun);
