// A cohort from subject to subject, in order of need: the page of each in a frame, and what is decided on any of them, which this page keeps
// and saves as one archive.
class Walk {
  // `order`: rows of subjects with a page.
  constructor(order) {
    Object.assign(this, { order, at: -1, key: `willis cohort ${location.pathname} ${data.command}` });
    // By subject `{csv, made, open}`.
    const restore = () => { try { this.kept = new Map(JSON.parse(localStorage.getItem(this.key)) ?? []); } catch { this.kept = new Map(); } };
    restore();
    // Another tab with this page goes through subjects, too.
    window.addEventListener("storage", ({ key }) => { if (key === this.key) { restore(); this.show(); } });
    byId("walk-begin").hidden = order.length === 0;
    byId("walk-begin").addEventListener("click", () => this.go(Math.max(order.findIndex(row => !this.isDone(row)), 0)));
    byId("walk-back").addEventListener("click", () => this.go(this.at - 1));
    byId("walk-on").addEventListener("click", () => this.go(this.at + 1));
    byId("walk-end").addEventListener("click", () => { byId("walk").hidden = true; byId("walk-page").removeAttribute("src"); byId("walk-begin").focus(); });
    byId("walk-save").addEventListener("click", () => this.save());
    window.addEventListener("message", event => { if (event.source === byId("walk-page").contentWindow) this.hear(event.data); });
    this.show();
  }

  isDone(row) {
    const { made, open } = this.kept.get(names.at(row)) ?? {};
    return made > 0 && open === 0;
  }

  go(at) {
    const { order } = this;
    if (at < 0 || at >= order.length) return;
    this.at = at;
    this.row = order[at];
    byId("walk").hidden = false;
    byId("walk-page").src = encoded(page(this.row));
    byId("walk-heading").textContent = `${names.at(this.row)}, ${at + 1} of ${order.length}`;
    byId("walk-why").textContent = reasons(this.row).join("; ");
    byId("walk-back").disabled = at === 0;
    byId("walk-on").disabled = at === order.length - 1;
    byId("walk-note").textContent = "";
    byId("walk").scrollIntoView({ block: "start" });
    // Keys then belong to the subject.
    byId("walk-page").onload = () => byId("walk-page").contentWindow.focus();
  }

  // What the page of a subject says: its decisions, or that the reader wants the next one.
  hear({ willis, csv, made, open, isFirst } = {}) {
    if (willis === "next") return this.go(this.at + 1);
    if (willis !== "decisions") return;
    const subject = names.at(this.row), before = this.kept.get(subject);
    // A browser that keeps nothing for the page of the subject has it from here.
    if (isFirst && made === 0 && before?.made) return byId("walk-page").contentWindow.postMessage({ willis: "load", csv: before.csv }, "*");
    if (made) this.kept.set(subject, { csv, made, open }); else this.kept.delete(subject);
    try { localStorage.setItem(this.key, JSON.stringify([...this.kept])); } catch { /* As before. */ }
    byId("walk-note").textContent = `${count(made, "decision")}, ${grouped(open)} open${open === 0 ? ": n goes on to the next subject" : ""}.`;
    this.show();
  }

  show() {
    const made = [...this.kept.values()].reduce((sum, of) => sum + of.made, 0);
    byId("walk-save").hidden = made === 0;
    byId("walk-sum").textContent = made ? `${count(made, "decision")} on ${count(this.kept.size, "subject")} kept in this browser.` : "";
  }

  // One archive with SUBJECT-decisions.csv of each, of those without a decision too: a cohort wants one for every input.
  save() {
    const head = [...this.kept.values()][0].csv.split("\n")[0], files = this.order.map(row => [`${names.at(row)}-decisions.csv`, this.kept.get(names.at(row))?.csv ?? `${head}\n`]);
    save(zipped(files), "decisions.zip");
  }
}
