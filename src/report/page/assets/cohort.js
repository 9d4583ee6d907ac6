// Builds the page of a cohort.
const subjects = table(data.table);
const names = subjects.find("subject"), status = subjects.find("status");
const good = Array.from({ length: subjects.rows }, (_, row) => row).filter(row => status.at(row) === "ok");
const bad = row => status.at(row) !== "ok";
const page = row => data.pages?.[row] ?? `${names.at(row)}/${data.opens}`;
names.address = row => bad(row) ? null : page(row).split("/").map(encodeURIComponent).join("/");
subjects.mark = row => bad(row) ? "failed" : null;
// Columns of long texts come last.
const late = ["input", "error"];
subjects.columns.sort((a, b) => late.includes(a.name) - late.includes(b.name));
subjects.filterBy = "name, error, …";

function showSummary() {
  const mean = name => {
    const column = subjects.find(name);
    const values = column ? good.map(row => column.at(row)).filter(Number.isFinite) : [];
    return values.length ? values.reduce((a, b) => a + b) / values.length : NaN;
  };
  const facts = [["subjects", subjects.rows], ["done", good.length], ["failed", data.failed], ["candidates, mean", mean("candidates")],
    ["kept, mean", mean("kept")], ["undecided, mean", mean("undecided")], ["expected wrong connections, mean", mean("expected_wrong")],
    ["expected missed connections, mean", mean("expected_missed")]];
  byId("facts").append(...facts.filter(([, value]) => !Number.isNaN(value)).map(([name, value]) =>
    make("div", { class: name === "failed" && value > 0 ? "failed" : null }, make("dt", { text: name }), make("dd", { text: shown(value, 3) }))));
  byId("origin").textContent = `Made by willis ${data.willis}.`;
}

function showFailures() {
  const error = subjects.find("error"), failed = Array.from({ length: subjects.rows }, (_, row) => row).filter(bad);
  byId("failed").hidden = failed.length === 0;
  byId("failures").append(...failed.slice(0, 100).map(row => make("li", {}, make("b", { text: names.at(row) }), `: ${error.at(row)}`)));
  if (failed.length > 100) byId("failures").append(make("li", { text: `and ${failed.length - 100} more: see the table` }));
}

const sheet = new Sheet(subjects, [], () => {});

function showDistribution() {
  const choice = byId("column"), skip = ["subject", "input", "status", "error"];
  const columns = subjects.columns.filter(c => !skip.includes(c.name));
  byId("distribution").hidden = columns.length === 0 || good.length === 0;
  choice.replaceChildren(...columns.map((c, at) => make("option", { value: at, text: c.name })));
  const show = () => {
    const column = columns[choice.value];
    if (!column) return;
    sheet.only(null);
    const counted = showBars(byId("bars"), column, good, bar => sheet.only(bar && new Set(bar.rows)));
    const without = good.length - counted;
    byId("distribution-note").textContent = `${grouped(counted)} subjects` + (without ? `, ${grouped(without)} without this figure` : "") + ". Choose a bar to filter the table.";
  };
  const first = ["variant", "sparsity", "kept"].map(name => columns.findIndex(c => c.name === name)).find(at => at >= 0);
  choice.value = first ?? 0;
  choice.addEventListener("change", show);
  show();
}

function showRun() {
  byId("command").value = data.command;
  const entries = Object.entries(data.parameters).filter(([, v]) => v !== null && v !== false && !(Array.isArray(v) && v.length === 0));
  byId("record").append(make("dl", { class: "pairs" }, ...entries.flatMap(([name, value]) =>
    [make("dt", { text: name.replaceAll("_", " ") }), make("dd", { text: Array.isArray(value) ? value.join(", ") : shown(value, 7) })])));
}

showAll(showSummary, showFailures, () => byId("sheet").append(sheet.element), showDistribution, showRun);
