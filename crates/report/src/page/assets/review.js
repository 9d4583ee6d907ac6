// What needs a person: the undecided connections, those of the largest consequence first.
const A_PAGE = 50;

class Review {
  // `goes(row)` flies to a connection.
  constructor(threshold, decisions, vessels, goes) {
    Object.assign(this, { threshold, decisions, vessels, goes });
    const hangs = threshold.hangs();
    const open = [...Array(threshold.rows).keys()].filter(row => threshold.open[row] || threshold.decided.has(row));
    // The consequence: how doubtful it is, times the length of what hangs on it.
    this.items = open.map(row => ({ row, hangs: hangs(row), weight: threshold.doubt(row) * (hangs(row) + vessels.find("length_mm").at(row)) }));
    this.items.sort((a, b) => b.weight - a.weight || a.row - b.row);
    this.shown = A_PAGE;
    this.at = -1;
  }

  // The next or previous of the list.
  step(by) {
    if (!this.items.length) return;
    this.at = this.at < 0 ? (by > 0 ? 0 : this.items.length - 1) : (this.at + by + this.items.length) % this.items.length;
    this.goes(this.items[this.at].row);
  }

  // The list knows which connection is selected.
  select(row) {
    const at = this.items.findIndex(item => item.row === row);
    if (at >= 0) this.at = at;
    for (const line of byId("review-list").children) line.classList.toggle("current", Number(line.dataset.row) === row);
    if (at >= 0) byId("review-list").children[at]?.scrollIntoView({ block: "nearest" });
  }

  // What a connection is called: by its labels, or by its row.
  name(row) {
    const label = this.vessels.find("label")?.at(row), kind = this.vessels.find("origin")?.at(row);
    return label || `${{ contact: "contact", observed: "vessel" }[kind] ?? "connection"} ${row}`;
  }

  figure(row) {
    const { threshold } = this, p = threshold.chance(row);
    if (!Number.isNaN(p)) return isChance(p);
    return `${threshold.name.split(" ").at(-1)} = ${withUnit(shown(threshold.values[row], 3), threshold.unit)}`;
  }

  line({ row, hangs }) {
    const { threshold } = this, state = threshold.state(row), said = threshold.decided.get(row);
    const gap = this.vessels.find("length_mm").at(row), rivals = threshold.rivals(row).length;
    const words = [this.vessels.find("origin")?.at(row) === "contact" ? null : `gap ${shown(gap, 2)} mm`, hangs > 0 ? `${shown(hangs, 2)} mm of vessel depend on it` : "closes a loop", rivals ? `${rivals} alternative${rivals > 1 ? "s" : ""}` : "no alternative"];
    const go = make("button", { type: "button", class: "go" },
      make("b", { text: this.name(row) }), " ", make("span", { class: "chance", text: said === undefined ? this.figure(row) : said ? "accepted" : "rejected" }), " ", make("small", { text: words.filter(Boolean).join(" · ") }));
    go.addEventListener("click", () => this.goes(row));
    const choose = (text, label, accepted) => {
      const button = make("button", { type: "button", text, "aria-pressed": said === accepted, "aria-label": `${label} ${this.name(row)}`, title: label, class: accepted ? "accept" : "reject" });
      button.addEventListener("click", () => this.decisions.decide(row, said === accepted ? null : accepted));
      return button;
    };
    return make("li", { class: said === undefined ? null : said ? "accepted" : "rejected", "data-row": row, "data-state": state },
      go, make("span", { class: "choose" }, choose("✓", "Accept", true), choose("✗", "Reject", false)));
  }

  show() {
    const list = byId("review-list"), { items } = this;
    const left = items.filter(item => !this.threshold.decided.has(item.row)).length;
    const here = document.activeElement?.closest?.("#review-list li")?.dataset.row, which = document.activeElement?.className;
    list.replaceChildren(...items.slice(0, this.shown).map(item => this.line(item)));
    if (here !== undefined) list.querySelector(`li[data-row="${here}"] .${which}`)?.focus();
    byId("review-note").textContent = items.length === 0 ? "Nothing: every connection is decided." :
      left === 0 ? "All are decided. Download the decisions, and give them to willis infer --decisions." :
      `${left === items.length ? grouped(left) : `${grouped(left)} of ${grouped(items.length)}`} connection${items.length > 1 ? "s" : ""}, those on which most depends first. Press n for the next, a to accept, r to reject, u to undo.`;
    const more = byId("review-more");
    more.hidden = items.length <= this.shown;
    more.textContent = `Show more (${grouped(items.length - this.shown)})`;
    const made = this.threshold.decided.size;
    byId("decided").hidden = made === 0;
    byId("decided-note").textContent = `${grouped(made)} decided. Probabilities beside a decision follow from it; a run with the decisions computes them anew.`;
    byId("undo").disabled = this.decisions.history.length === 0;
    if (this.at >= 0) for (const line of list.children) line.classList.toggle("current", Number(line.dataset.row) === items[this.at].row);
  }

  // The connection with its alternatives: probability, gap, bends and radii.
  alternatives(row, shape) {
    const { threshold } = this;
    const all = [row, ...threshold.rivals(row).sort((a, b) => threshold.chance(b) - threshold.chance(a) || threshold.values[b] - threshold.values[a])].slice(0, 12);
    const evidence = all.some(other => !Number.isNaN(threshold.chance(other)));
    const heads = ["nr.", evidence ? "P" : threshold.name.split(" ").at(-1), "gap mm", "bend °", "radii mm", ""];
    const line = other => {
      const { bends, radii } = shape.junction(other, threshold);
      const go = make("button", { type: "button", text: this.name(other).replace("connection ", ""), disabled: other === row });
      go.addEventListener("click", () => this.goes(other));
      const cells = [evidence ? chance(threshold.chance(other)) : shown(threshold.values[other], 3), shown(this.vessels.find("length_mm").at(other), 3),
        bends.map(b => Number.isNaN(b) ? "–" : Math.round(b)).join(", "), radii.map(r => Number.isNaN(r) ? "–" : shown(r, 2)).join(", "), threshold.state(other).split(",")[0]];
      return make("tr", { "aria-current": other === row ? "true" : null }, make("th", { scope: "row" }, go), ...cells.map(text => make("td", { text })));
    };
    const sum = all.reduce((sum, other) => sum + (threshold.chance(other) || 0), 0);
    const note = sum > 1 ? [make("p", { class: "quiet", text: "These P add up to more than 1: each says how often a connection like it is right, by itself." })] : [];
    return make("div", { class: "fit", tabindex: "0", role: "region", "aria-label": "Alternatives" }, make("table", { class: "alternatives" }, make("caption", { text: all.length > 1 ? "This connection and its alternatives; bends and radii are those at either end" : "This connection; it has no alternative" }),
      make("thead", {}, make("tr", {}, ...heads.map(text => make(text ? "th" : "td", { scope: text ? "col" : null, text })))), make("tbody", {}, ...all.map(line))), ...note);
  }
}
