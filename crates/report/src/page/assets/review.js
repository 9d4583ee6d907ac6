// What a person is asked: what is undecided, what a part goes on to that nothing connects, and what is probably wrong about much; what a right answer is
// expected to put right most first.
const A_PAGE = 50;

class Review {
  // `goes(row)` flies to a connection.
  constructor(threshold, decisions, vessels, goes) {
    Object.assign(this, { threshold, decisions, vessels, goes });
    this.shown = A_PAGE;
    this.current = -1;
    // The lines of the list, by row.
    this.lines = new Map();
    this.words = "";
    this.order = "consequence";
    this.refresh();
  }

  // Finds again what is open: after a decision, or at another threshold. What was decided or said comes last, the latest first.
  refresh() {
    const { threshold } = this, question = threshold.questions(), gap = this.vessels.find("length_mm"), made = [...this.decisions.made.keys()].reverse();
    const has = row => !this.words || this.name(row).toLowerCase().includes(this.words);
    const by = { consequence: a => -a.gain, probability: a => -threshold.figureOf(a.row), gap: a => gap.at(a.row), place: () => 0 }[this.order];
    const asked = this.decisions.asked(question);
    this.total = asked.length;
    this.open = asked.filter(item => has(item.row)).sort((a, b) => by(a) - by(b) || a.row - b.row);
    this.items = [...this.open, ...made.filter(has).map(question)];
  }

  // The next or previous that is open; from the one that was decided or is open no more, the first.
  step(by) {
    const { open } = this;
    if (!open.length) return this.decisions.tell(() => ({ willis: "next" }));
    const at = open.findIndex(item => item.row === this.current);
    this.goes(open[at < 0 ? (by > 0 ? 0 : open.length - 1) : (at + by + open.length) % open.length].row);
  }

  // The list knows which connection is selected.
  select(row) {
    this.lines.get(this.current)?.classList.remove("current");
    this.current = row;
    const line = this.lines.get(row);
    line?.classList.add("current");
    line?.scrollIntoView({ block: "nearest" });
  }

  // What a connection is called: by its label or by the arteries that it joins, and by its row.
  name(row) {
    const label = this.vessels.find("label")?.at(row), kind = this.vessels.find("origin")?.at(row);
    const what = `${{ contact: "contact", observed: "vessel" }[kind] ?? "connection"} ${row}`;
    if (label) return `${label}, ${what}`;
    const [a, b] = this.threshold.ends.map(of => this.labelAt(of[row]));
    return a && b ? a === b ? `${a}, ${what}` : `${a} to ${b}, ${what}` : a || b ? `${a || b}, ${what}` : what;
  }

  // The name of the observed vessels at a node, where they have one.
  labelAt(node) {
    if (!this.labels) {
      const { threshold } = this;
      this.labels = new Map();
      for (let row = 0; row < threshold.rows; row++) {
        const label = threshold.isObserved(row) ? nameOf(row) : "";
        for (const of of label ? threshold.ends : []) {
          const here = this.labels.get(of[row]);
          this.labels.set(of[row], here === undefined || here === label ? label : "");
        }
      }
    }
    return this.labels.get(node) ?? "";
  }

  figure(row) {
    const { threshold } = this, p = threshold.chance(row);
    if (!Number.isNaN(p)) return isChance(p);
    return `${threshold.name.split(" ").at(-1)} = ${withUnit(shown(threshold.values[row], 3), threshold.unit)}`;
  }

  line({ row, hangs, closes, loose, loop, touch }) {
    const { threshold } = this, { decision, comment } = this.decisions.of(row);
    const gap = this.vessels.find("length_mm").at(row), rivals = threshold.rivals(row).length, observed = threshold.isObserved(row);
    // A question about a place, and not whether the vessel is there.
    const isPlace = !threshold.uncertain[row] || touch > 0;
    const depend = hangs > 0 ? `${shown(hangs, 2)} mm of vessel depend on it` : closes ? "closes a loop" : "nothing else depends on it";
    const words = [observed || threshold.isContact(row) ? null : `gap ${shown(gap, 2)} mm`, loose ? `nothing connects ${shown(loose, 2)} mm of vessel` : loop ? `in a loop of ${shown(loop, 2)} mm` : depend,
      touch ? "do vessels only touch there?" : isPlace ? "where does it go on?" : observed ? null : rivals ? count(rivals, "alternative") : "no alternative", comment];
    const rank = this.vessels.find("rank")?.at(row);
    const go = make("button", { type: "button", class: "go", click: () => this.goes(row) },
      make("span", { class: "rank", text: rank > 0 ? rank : "" }), " ", make("b", { text: this.name(row) }), " ", make("span", { class: "chance", text: { accept: "accepted", reject: "rejected", unsure: "unsure" }[decision] ?? (isPlace ? "" : this.figure(row)) }), " ", make("small", { text: words.filter(Boolean).join(" · ") }));
    const choose = (text, label, which) => make("button", { type: "button", text, "aria-pressed": decision === which, "aria-label": `${label} ${this.name(row)}`, title: label, class: which,
      click: () => this.decisions.decide([row], decision === which ? null : which) });
    return make("li", { class: decision || null, "data-row": row, "data-state": threshold.state(row) },
      go, isPlace ? "" : make("span", { class: "choose" }, choose("✓", "Accept", "accept"), choose("✗", "Reject", "reject")));
  }

  // What the list depends on beside the decisions.
  get setting() {
    return `${this.threshold.now} ${this.threshold.asRun}`;
  }

  show() {
    this.settingShown = this.setting;
    this.refresh();
    const list = byId("review-list"), { items, open } = this, { made, history, stored, edits } = this.decisions;
    const here = document.activeElement?.closest?.("#review-list li")?.dataset.row, which = document.activeElement?.className;
    this.lines = new Map([...open.slice(0, this.shown), ...items.slice(open.length)].map(item => [item.row, this.line(item)]));
    list.replaceChildren(...this.lines.values());
    if (here !== undefined) list.querySelector(`li[data-row="${here}"] .${which}`)?.focus();
    this.lines.get(this.current)?.classList.add("current");
    const all = this.total, first = byId("review-order").selectedOptions[0].dataset.says;
    byId("review-note").textContent = items.length === 0 ? this.words ? "None has this name." : "Nothing: every connection is decided." :
      open.length === 0 && !this.words ? "All are decided. Download the decisions, and give them to willis infer --decisions." :
      `${this.words ? `${grouped(open.length)} of ` : ""}${grouped(all)} open, ${first} first.${scene ? " Keys: n next, a accept, r reject, x unsure, u undo." : ""}`;
    byId("review-tools").hidden = all < 8 && !this.words;
    const more = byId("review-more");
    more.hidden = open.length <= this.shown;
    more.textContent = `Show all (${grouped(open.length - this.shown)} more)`;
    byId("decided").hidden = made.size + edits.length === 0;
    const many = decision => [...made.values()].filter(of => of.decision === decision).length;
    const said = [["accept", "accepted"], ["reject", "rejected"], ["unsure", "unsure"]].map(([name, word]) => many(name) && `${grouped(many(name))} ${word}`).filter(Boolean).join(", ");
    const sum = [said, edits.length && count(edits.length, "edit")].filter(Boolean).join(", ");
    byId("decided-note").textContent = `${sum ? `${sum}. ` : ""}${stored ? "Kept in this browser." : "This browser keeps nothing: download them before the page is left."} Probabilities beside a decision follow from it.`;
    for (const button of [byId("undo"), byId("decide-undo")]) button.disabled = history.length === 0;
  }

  // The ways to pair the vessels at a place; each is taken as one decision.
  pairings(row) {
    const ways = this.decisions.ways(row), of = name => this.decisions.paired.find(name)?.at ?? (() => "");
    const rowsIn = text => String(text).split(" ").filter(Boolean).map(Number);
    if (!ways.length) return null;
    const [accept, reject, contacts] = ["accept", "reject", "contacts"].map(of);
    const line = way => {
      const edit = this.decisions.partOf(way), all = [[accept(way), "accept"], [reject(way), "reject"], [edit && contacts(way), "unsure"]];
      const made = all.every(([rows, decision]) => rowsIn(rows).every(at => this.decisions.of(at).decision === decision)) && (!edit || this.decisions.edits.some(of => of.places === edit));
      const click = () => this.decisions.pair(all.flatMap(([rows, decision]) => rowsIn(rows).map(at => [at, made ? null : decision])), made ? "" : edit, ways.map(way => this.decisions.partOf(way)));
      const take = make("button", { type: "button", click, text: of("vessels")(way), "aria-pressed": made, "aria-label": `Pair vessels ${of("vessels")(way)}`, disabled: !edit && all.every(([rows]) => !rowsIn(rows).length) });
      return make("li", {}, take, " ", make("small", { text: [Number.isNaN(of("probability")(way)) ? "" : isChance(of("probability")(way)), of("taken")(way) ? "taken by the run" : "", edit ? "an edit" : ""].filter(Boolean).join(" · ") }));
    };
    return make("div", { class: "pairings" }, make("p", { text: "Which vessels are one here (+), and which only touch (|):" }), make("ul", {}, ...ways.map(line)));
  }

  // The connection with its alternatives: probability, gap, bends and radii.
  alternatives(row, shape) {
    const { threshold } = this;
    const all = [row, ...threshold.rivals(row).sort((a, b) => threshold.chance(b) - threshold.chance(a) || threshold.values[b] - threshold.values[a])].slice(0, 12);
    const evidence = all.some(other => !Number.isNaN(threshold.chance(other)));
    const heads = ["nr.", evidence ? "P" : threshold.name.split(" ").at(-1), "gap mm", "bend °", "radii mm", ""];
    const line = other => {
      const { bends, radii } = shape.junction(other, threshold);
      const go = make("button", { type: "button", click: () => this.goes(other), text: other, "aria-label": this.name(other), disabled: other === row });
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
