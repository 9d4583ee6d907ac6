// What a person decides: accepted and rejected connections, with undo, and the list that `willis infer --decisions` takes.
class Decisions {
  // `changed` is called after each change.
  constructor(threshold, vessels, nodes, changed) {
    Object.assign(this, { threshold, vessels, nodes, changed });
    this.when = new Map();
    this.history = [];
    this.saved = true;
    // What earlier decisions made certain is part of the list.
    for (const { edge, accepted, when, who } of data.record.parameters?.decisions?.made || []) {
      threshold.decided.set(edge, accepted);
      this.when.set(edge, { when, who });
    }
    if (threshold.decided.size) threshold.again();
    window.addEventListener("beforeunload", event => { if (!this.saved) event.preventDefault(); });
  }

  // Accepts (true), rejects (false) or leaves open again (null).
  decide(row, accepted) {
    this.history.push([row, this.threshold.decided.get(row) ?? null, this.when.get(row)]);
    this.put(row, accepted, { when: new Date().toISOString().replace(/\.\d+/, ""), who: byId("who").value.trim() });
  }

  undo() {
    const last = this.history.pop();
    if (!last) return -1;
    this.put(...last);
    return last[0];
  }

  put(row, accepted, by) {
    if (accepted === null) {
      this.threshold.decided.delete(row);
      this.when.delete(row);
    } else {
      this.threshold.decided.set(row, accepted);
      this.when.set(row, by);
    }
    this.saved = this.threshold.decided.size === 0;
    this.threshold.again();
    this.changed();
  }

  // The list as CSV, in the order of the vessels.
  csv() {
    const id = this.nodes?.find("id"), who = byId("who").value.trim();
    const cell = text => {
      const plain = String(text).replace(/[\r\n]+/g, " ").replace(/^(?=[=+@\t-])/, "'");
      return /[",]/.test(plain) ? `"${plain.replaceAll('"', '""')}"` : plain;
    };
    const line = row => {
      const ends = ["node_a", "node_b"].map(name => { const node = this.vessels.find(name).at(row); return id ? id.at(node) : node; });
      const by = this.when.get(row), p = this.threshold.probability?.[row];
      return [row, ...ends, this.threshold.decided.get(row) ? "accept" : "reject", Number.isNaN(p) ? "" : p ?? "", by.who || who, by.when, data.record.input.sha256].map(cell).join(",");
    };
    const rows = [...this.threshold.decided.keys()].sort((a, b) => a - b);
    return ["edge,id_a,id_b,decision,probability,who,when,input_sha256", ...rows.map(line)].join("\n") + "\n";
  }

  download() {
    const address = URL.createObjectURL(new Blob([this.csv()], { type: "text/csv" }));
    make("a", { href: address, download: "decisions.csv" }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
    this.saved = true;
  }
}
