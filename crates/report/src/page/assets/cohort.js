// Builds the page of a cohort.
const subjects = table(data.table);
const names = subjects.find("subject"), status = subjects.find("status");
const good = upTo(subjects.rows).filter(row => status.at(row) === "ok");
const bad = row => status.at(row) !== "ok";
const page = row => data.pages?.[row] ?? `${names.at(row)}/${data.opens}`;
names.address = row => bad(row) ? null : page(row).endsWith(".html") ? wayTo(page(row)) : encoded(page(row));
// The variant leads to the drawing of the circle.
const variants = subjects.find("variant");
if (variants) variants.address = row => bad(row) || variants.at(row) === "" ? null : names.address(row).replace(/(#.*)?$/, "#circle");
subjects.mark = row => bad(row) ? "failed" : null;
// Columns of long texts come last.
const late = ["input", "error"];
subjects.columns.sort((a, b) => late.includes(a.name) - late.includes(b.name));
subjects.filterBy = "name, error, …";

const undecided = subjects.find("undecided");

// Why a subject needs a person; empty where it does not.
function reasons(row) {
  if (bad(row)) return [`failed: ${subjects.find("error").at(row)}`];
  const why = subjects.find("needs_person")?.at(row);
  return why ? why.split("; ") : [];
}

function showSummary() {
  const open = good.filter(row => reasons(row).length > 0).length, words = [make("b", { text: `${count(good.length, "subject")} of ${grouped(subjects.rows)} done` })];
  if (data.failed > 0) words.push(", ", make("b", { text: `${grouped(data.failed)} failed` }));
  const needs = make("b", { text: open === 0 ? "none needs a person" : `${grouped(open)} need${open === 1 ? "s" : ""} a person` });
  if (good.length > 0) words.push(good.length < subjects.rows ? "; of those done " : "; ", needs);
  words.push(".");
  const mean = name => {
    const column = subjects.find(name), values = column ? good.map(row => column.at(row)).filter(Number.isFinite) : [];
    return values.length ? values.reduce((a, b) => a + b) / values.length : NaN;
  };
  const means = [["connections kept of", mean("kept")], ["candidates", mean("candidates")]];
  if (means.every(([, x]) => Number.isFinite(x))) words.push(` On average ${shown(means[0][1], 3)} of ${shown(means[1][1], 3)} possible connections are kept`, Number.isFinite(mean("expected_wrong")) ? `; of all that is kept ${shown(mean("expected_wrong"), 2)} are expected to be wrong.` : ".");
  byId("answer-words").append(...words);
  byId("origin").textContent = `Made by willis ${data.willis}.`;
}

// A card a subject: its picture, its name, and why it needs a person.
function showPersons() {
  const all = upTo(subjects.rows), open = all.filter(row => reasons(row).length > 0);
  const order = [...open, ...all.filter(row => reasons(row).length === 0)];
  byId("persons").hidden = subjects.rows === 0;
  byId("persons-heading").textContent = open.length ? "Subjects that need a person" : "Subjects";
  byId("persons-note").textContent = open.length === 0 ? "No subject needs a person." : `${grouped(open.length)} of ${grouped(subjects.rows)}, the most uncertain first, then the others. A picture opens the page of its subject.`;
  const card = row => {
    const address = names.address(row), picture = data.pictures?.[row], why = reasons(row), variant = variants?.at(row);
    const name = address ? make("a", { href: address, text: names.at(row) }) : make("span", { text: names.at(row) });
    const image = picture && address ? make("a", { href: address, tabindex: "-1", "aria-hidden": "true" }, make("img", { src: `${encoded(picture)}#svgView(viewBox(${data.thumbnail}))`, alt: "", loading: "lazy", width: 184, height: 216 })) : null;
    return make("article", { class: `card${bad(row) ? " failed" : why.length ? " open" : ""}` }, ...[image, make("h3", {}, name),
      variant ? make("p", {}, make("a", { href: variants.address(row), text: variant })) : null,
      why.length ? make("ul", {}, ...why.map(text => make("li", { text }))) : make("p", { class: "quiet", text: undecided?.at(row) > 0 ? `nothing to check: ${count(undecided.at(row), "open connection")}, of which none would change the variant` : "nothing to check" })].filter(Boolean));
  };
  showCards(order, card);
  if (data.walks) new Walk(order.filter(row => !bad(row) && page(row).endsWith(".html")));
}

function showFailures() {
  const error = subjects.find("error"), failed = upTo(subjects.rows).filter(bad);
  byId("failed").hidden = failed.length === 0;
  byId("failures").append(...failed.slice(0, 100).map(row => make("li", {}, make("b", { text: names.at(row) }), `: ${error.at(row)}`)));
  if (failed.length > 100) byId("failures").append(make("li", { text: `and ${failed.length - 100} more: see the table` }));
}

const sheet = new Sheet(subjects, [], () => {});

// The table holds the subjects of the chosen bar and of the chosen variant.
let ofBar = null;
function filterRows() {
  const variant = byId("variant").value;
  const all = upTo(subjects.rows);
  sheet.only(!ofBar && variant === "" ? null : new Set(all.filter(row => (!ofBar || ofBar.has(row)) && (variant === "" || variants.at(row) === variant))));
}

function showVariants() {
  const counts = new Map();
  for (const row of variants ? good : []) if (variants.at(row) !== "") counts.set(variants.at(row), (counts.get(variants.at(row)) || 0) + 1);
  byId("by-variant").hidden = counts.size === 0;
  const sorted = [...counts].sort((a, b) => b[1] - a[1] || (a[0] < b[0] ? -1 : 1));
  byId("variant").append(make("option", { value: "", text: "all" }), ...sorted.map(([text, n]) => make("option", { value: text, text: `${text} (${grouped(n)})` })));
  byId("variant").addEventListener("change", filterRows);
}

function showDistribution() {
  const choice = byId("column"), skip = ["subject", "input", "status", "error"];
  const columns = subjects.columns.filter(c => !skip.includes(c.name));
  byId("distribution").hidden = columns.length === 0 || good.length === 0;
  choice.replaceChildren(...columns.map((c, at) => make("option", { value: at, text: c.name })));
  const show = () => {
    const column = columns[choice.value];
    if (!column) return;
    ofBar = null;
    filterRows();
    const counted = showBars(byId("bars"), column, good, bar => { ofBar = bar && new Set(bar.rows); filterRows(); });
    const without = good.length - counted;
    byId("distribution-note").textContent = count(counted, "subject") + (without ? `, ${grouped(without)} without this figure` : "") + ". Choose a bar to filter the table.";
  };
  const first = ["variant", "sparsity", "kept"].map(name => columns.findIndex(c => c.name === name)).find(at => at >= 0);
  choice.value = first ?? 0;
  choice.addEventListener("change", show);
  show();
}

function showRun() {
  byId("command").value = data.command;
  const entries = Object.entries(data.parameters).filter(([, v]) => v !== null && v !== false && !(Array.isArray(v) && v.length === 0));
  byId("record").append(pairs(entries.map(([name, value]) => [name.replaceAll("_", " "), Array.isArray(value) ? value.join(", ") : shown(value, 7)])));
}

showAll(showSummary, showPersons, showFailures, showVariants, () => byId("sheet").append(sheet.element), showDistribution, showRun);
