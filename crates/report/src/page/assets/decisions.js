// What a spreadsheet would take for a formula: in a table it has an apostrophe before it, as in all tables that willis writes.
const FORMULA = /^'*[=+\-@\t\r＝＋－＠]/;

// What a person decides: connections that are accepted, rejected, or that the reader is unsure of, with comments and undo. They stay in the
// browser, and are the list that `willis infer --decisions` takes.
class Decisions {
  // `changed` is called after each change.
  constructor(threshold, vessels, nodes, changed) {
    Object.assign(this, { threshold, vessels, changed });
    const id = nodes?.find("id"), axes = ["x_mm", "y_mm", "z_mm"].map(name => nodes?.find(name));
    this.placeOf = node => axes.every(Boolean) ? axes.map(axis => axis.at(node)).join(" ") : "";
    this.idOf = node => String(id ? id.at(node) : node);
    // By row `{decision, when, who, comment}`, in the order of the decisions.
    this.made = new Map();
    // What to take back: `{rows, edits}`, pairs of a row and what was there before it, and the edits before, where they changed.
    this.history = [];
    this.saved = true;
    // What earlier decisions made certain is part of the list.
    for (const { edge, accepted, when, who, comment } of data.record.parameters?.decisions?.made || []) {
      this.made.set(edge, { decision: accepted === null ? "unsure" : accepted ? "accept" : "reject", when, who, comment: comment || "" });
    }
    // Edits of the graph are kept as they are: `{decision, places, when, who, comment}`.
    this.edits = (data.record.parameters?.decisions?.edits || []).map(({ edit, ...of }) => ({ decision: edit.split(" ")[0], places: edit.slice(edit.indexOf(" ") + 1), ...of }));
    const { input, graph } = data.record;
    this.key = `willis ${input?.sha256} ${graph?.sha256 ?? ""}`;
    this.restored = this.restore();
    this.isFirst = true;
    this.follow();
    this.isFirst = false;
    // Another tab with this page decided; what it kept is what holds here, too.
    window.addEventListener("storage", ({ key, newValue }) => {
      if (key !== this.key) return;
      if (newValue === null) Object.assign(this, { made: new Map(), history: [], edits: [] });
      else this.restore();
      this.follow();
      this.changed();
    });
    // A page of a cohort that shows this one may keep what was decided.
    window.addEventListener("message", ({ source, data: said }) => {
      if (source !== parent || said?.willis !== "load" || this.made.size + this.edits.length) return;
      try { this.load(said.csv); } catch { /* A list for another graph. */ }
    });
    window.addEventListener("beforeunload", event => { if (!this.saved && !this.stored) event.preventDefault(); });
  }

  // Takes up what this browser has of the same graph; whether there was any.
  restore() {
    try {
      const { made, history, edits } = JSON.parse(localStorage.getItem(this.key)) ?? {};
      if (!made || !edits || made.some(([row]) => !this.threshold.uncertain[row])) return false;
      Object.assign(this, { made: new Map(made), history, edits });
      return made.length + edits.length > 0;
    } catch {
      return false;
    }
  }

  // The answer follows, and the browser keeps it; a browser that keeps nothing asks before the page is left.
  follow() {
    this.threshold.decided = new Map([...this.made].filter(([, of]) => of.decision !== "unsure" && of.decision !== "").map(([row, of]) => [row, of.decision === "accept"]));
    this.threshold.again();
    try {
      if (this.made.size || this.history.length) localStorage.setItem(this.key, JSON.stringify({ made: [...this.made], history: this.history, edits: this.edits }));
      else localStorage.removeItem(this.key);
      this.stored = true;
    } catch {
      this.stored = false;
    }
    this.tell(() => ({ willis: "decisions", csv: this.csv(), made: this.made.size + this.edits.length, open: this.asked().length, isFirst: this.isFirst }));
  }

  // What is asked and nothing is said of yet, as `question` tells it; a place where vessels may only touch is answered by an edit, too.
  asked(question = this.threshold.questions()) {
    const edits = new Set(this.edits.map(of => of.places)), isAnswered = row => this.ways(row).some(way => edits.has(this.partOf(way)));
    return upTo(this.threshold.rows).filter(row => !this.made.has(row)).map(question).filter(item => item.asked && !(item.touch && isAnswered(item.row)));
  }

  // The rows of the table of pairings for a contact, or for a vessel that stands for a place where vessels may only touch.
  ways(row) {
    const table = this.paired ??= tables.find(t => t.find("taken")) ?? null, touches = this.threshold.touch[row] > 0;
    if (!table || !(touches || this.threshold.isContact(row))) return [];
    const [contacts, vessels] = ["contacts", "vessels"].map(name => table.find(name)), is = text => String(text).split(/[^0-9]+/).includes(String(row));
    return upTo(table.rows).filter(way => touches ? !contacts?.at(way) && is(vessels.at(way)) : contacts && is(contacts.at(way)));
  }

  // The places of the edit for a way; empty where there is none.
  partOf(way) {
    return String(this.paired.find("part")?.at(way) ?? "").trim();
  }

  // Tells the page of a cohort that shows this one.
  tell(what) {
    if (parent !== window) parent.postMessage(what(), "*");
  }

  // Decides rows alike: "accept", "reject", "unsure", or null to leave them open again.
  decide(rows, decision) {
    this.put(rows.map(row => [row, this.after(row, decision)]));
  }

  // What is said of a row once it is decided so; its comment stays.
  after(row, decision) {
    const comment = this.made.get(row)?.comment ?? "";
    return decision || comment ? this.now({ decision: decision ?? "", comment }) : null;
  }

  // What is said here and now.
  now(what) {
    return { who: byId("who").value.trim(), when: new Date().toISOString().replace(/\.\d+/, ""), ...what };
  }

  comment(row, text) {
    const before = this.made.get(row);
    if (text === (before?.comment ?? "")) return;
    const one = this.now({ decision: "", ...before, comment: text });
    this.put([[row, text || one.decision ? one : null]]);
  }

  // Changes rows, and the edits where there are to be others, as one step that can be taken back.
  put(rows, edits) {
    this.history.push({ rows: rows.map(([row]) => [row, this.made.get(row) ?? null]), edits: edits && this.edits });
    this.set({ rows, edits });
  }

  edit(decision, places) {
    this.put([], [...this.edits, this.now({ decision, places })]);
  }

  // Decides how vessels pair where they touch, in one step: contacts, and an edit of these places in place of others, if there is one.
  pair(rows, places, others) {
    const rest = this.edits.filter(of => !others.includes(of.places));
    const isEdited = Boolean(places) || rest.length < this.edits.length;
    if (places) rest.push(this.now({ decision: "part", places }));
    this.put(rows.map(([row, decision]) => [row, this.after(row, decision)]), isEdited ? rest : undefined);
  }

  removeEdit(at) {
    this.put([], this.edits.filter((_, i) => i !== at));
  }

  set({ rows, edits }) {
    if (edits) this.edits = edits;
    for (const [row, of] of rows) {
      this.made.delete(row);
      if (of) this.made.set(row, of);
    }
    this.saved = this.made.size + this.edits.length === 0;
    this.follow();
    this.changed();
  }

  // Takes the last step back; its first row, or -1.
  undo() {
    const last = this.history.pop();
    if (!last) return -1;
    this.set(last);
    return last.rows[0]?.[0] ?? -1;
  }

  of(row) {
    return this.made.get(row) ?? { decision: "", comment: "" };
  }

  // The list as CSV, in the order of the vessels. What only has a comment is unsure.
  csv() {
    const who = byId("who").value.trim();
    const cell = text => {
      const flat = String(text).replace(/[\r\n]+/g, " "), plain = FORMULA.test(flat) ? `'${flat}` : flat;
      return /[",]/.test(plain) ? `"${plain.replaceAll('"', '""')}"` : plain;
    };
    // A space before a minus, which is no formula then.
    const spaced = places => places.replace(/^-/, " -");
    const line = ([row, of]) => {
      const p = this.threshold.probability?.[row];
      const places = ["node_a", "node_b"].map(name => this.placeOf(this.vessels.find(name).at(row)));
      return [row, ...this.idsOf(row), of.decision || "unsure", Number.isNaN(p) ? "" : p ?? "", of.who || who, of.when, of.comment, data.record.input.sha256, spaced(places.every(Boolean) ? places.join(" + ") : "")].map(cell).join(",");
    };
    const edit = of => ["", "", "", of.decision, "", of.who || who, of.when, of.comment ?? "", data.record.input.sha256, spaced(of.places)].map(cell).join(",");
    return ["edge,id_a,id_b,decision,probability,who,when,comment,input_sha256,places", ...[...this.made].sort(([a], [b]) => a - b).map(line), ...this.edits.map(edit)].join("\n") + "\n";
  }

  idsOf(row) {
    return ["node_a", "node_b"].map(name => this.idOf(this.vessels.find(name).at(row)));
  }

  download() {
    save(new Blob([this.csv()], { type: "text/csv" }), `${nameOfInput()}-decisions.csv`);
    this.saved = true;
  }

  // Takes a list as `csv` writes it; a fault in it is thrown, and then nothing changes.
  load(text) {
    const [head, ...lines] = rowsOf(text), at = name => head.indexOf(name), needs = ["edge", "id_a", "id_b", "decision"];
    for (const name of needs) if (at(name) < 0) throw new Error(`there is no column ${name}; expected ${needs.join(",")}`);
    const changes = new Map(), edits = [];
    lines.forEach((cells, i) => {
      const fault = what => { throw new Error(`row ${i + 1}: ${what}`); };
      const cell = name => { const text = at(name) < 0 ? "" : cells[at(name)] ?? ""; return text[0] === "'" && FORMULA.test(text) ? text.slice(1) : text; };
      const row = Number(cell("edge")), decision = cell("decision");
      if (cell("input_sha256") && cell("input_sha256") !== data.record.input.sha256) fault("it was decided on another input");
      if (["join", "part", "delete"].includes(decision)) return edits.push({ decision, places: cell("places").trim(), who: cell("who"), when: cell("when"), comment: cell("comment") });
      if (!/^\d+$/.test(cell("edge")) || !this.threshold.uncertain[row]) fault(`edge "${cell("edge")}" is no connection that can be decided here`);
      const ids = this.idsOf(row);
      if (ids[0] !== cell("id_a") || ids[1] !== cell("id_b")) fault(`edge ${row} joins ${cell("id_a")} to ${cell("id_b")} in the list, and ${ids.join(" to ")} here`);
      if (!["accept", "reject", "unsure"].includes(decision)) fault(`decision "${decision}"; expected accept, reject or unsure`);
      if (changes.has(row)) fault(`edge ${row} comes again; expected one decision an edge`);
      changes.set(row, { decision, who: cell("who"), when: cell("when"), comment: cell("comment") });
    });
    if (edits.length || changes.size) this.put([...changes], edits.length ? edits : undefined);
    return changes.size + edits.length;
  }
}

// The cells of CSV by row, without rows that are empty.
function rowsOf(text) {
  const rows = [[""]];
  let quoted = false;
  for (const part of text.replace(/^\ufeff/, "").match(/"|,|\r?\n|[^",\r\n]+|\r/g) ?? []) {
    const row = rows.at(-1), last = row.length - 1;
    if (part === '"') {
      // A quote right after the end of a quoted part is a quote itself.
      if (!quoted && row.closed === last) row[last] += '"';
      quoted = !quoted;
      row.closed = quoted ? -1 : last;
    } else if (quoted || !/^[,\r\n]/.test(part)) row[last] += part;
    else if (part === ",") row.push("");
    else rows.push([""]);
  }
  return rows.filter(row => row.length > 1 || row[0] !== "");
}
