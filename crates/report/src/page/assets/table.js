// A table that sorts by any column, filters by text, and shows a page of its rows at a time.
const ROWS_A_PAGE = 100, ROWS_IN_PRINT = 3000;
// Columns that the page computes with and that the tables leave out.
const UNSHOWN = new Set(["uncertain", "loose_mm", "loop_mm", "touch_mm", "touch_gain_mm", "rank", "stated", "attached_a", "attached_b", "alone"]);

// A name that may go on in another line after each of its words.
const worded = name => name.split(/(?<=_)/).flatMap((word, at) => at ? [make("wbr"), word] : [word]);

class Sheet {
  // `live` are columns that change while the page is open; `picks(row)` is called with the vessel whose row was chosen.
  constructor(table, live, picks) {
    this.table = table;
    this.columns = [...table.columns.filter(c => !UNSHOWN.has(c.name)), ...live];
    this.live = live;
    this.picks = picks;
    this.order = Uint32Array.from({ length: table.rows }, (_, row) => row);
    this.by = null;
    this.page = 0;
    this.size = ROWS_A_PAGE;
    this.words = "";
    this.picked = -1;
    this.among = null;
    this.build();
    const printed = this.element.querySelector("table");
    // A print has all rows, and columns that would not fit on the paper as it is printed (its width in pixels, its letters to those here) are smaller.
    for (const [when, size] of [["beforeprint", ROWS_IN_PRINT], ["afterprint", ROWS_A_PAGE]]) {
      window.addEventListener(when, () => { if (this.element.isConnected) { this.size = size; this.show(); printed.style.zoom = when === "beforeprint" ? Math.min(1, 1046 / (0.6 * printed.offsetWidth)) : ""; } });
    }
  }

  build() {
    this.filter = make("input", { type: "search", id: "filter", placeholder: this.table.filterBy || "label, id, row …", autocomplete: "off" });
    this.filter.addEventListener("input", () => { this.words = this.filter.value.trim().toLowerCase(); this.page = 0; this.show(); });
    this.where = make("span", { role: "status" });
    const turn = (text, label, by) => make("button", { type: "button", text, "aria-label": label, click: () => { this.page += by; this.show(); } });
    [this.back, this.on] = [turn("‹", "Previous page", -1), turn("›", "Next page", 1)];
    this.head = make("tr", {}, ...this.columns.map(column => this.heading(column)));
    this.body = make("tbody");
    const table = make("table", { "aria-label": this.table.title }, make("thead", {}, this.head), this.body);
    this.element = make("div", {},
      make("div", { class: "row" }, make("label", { for: "filter", text: "Filter" }), this.filter, this.where, make("span", { class: "row pager" }, this.back, this.on)),
      make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": `${this.table.title}, rows` }, table));
    this.show();
  }

  heading(column) {
    const button = make("button", { type: "button", click: () => this.sort(column) }, ...worded(column.name));
    return make("th", { scope: "col", class: column.text ? "text" : null, "aria-sort": "none" }, button);
  }

  // Ascending first, then descending. Rows without a value always come last.
  sort(column, turns = true) {
    if (turns) this.falling = this.by === column ? !this.falling : false;
    this.by = column;
    const sign = this.falling ? -1 : 1;
    const values = Array.from({ length: this.table.rows }, (_, row) => column.at(row));
    const blank = column.text ? v => v === "" : v => Number.isNaN(v);
    const compare = column.text ? new Intl.Collator("en", { numeric: true }).compare : (a, b) => a - b;
    this.order.sort((a, b) => blank(values[a]) - blank(values[b]) || (blank(values[a]) ? 0 : sign * compare(values[a], values[b])) || a - b);
    [...this.head.children].forEach((th, i) => {
      const here = this.columns[i] === column;
      th.setAttribute("aria-sort", here ? this.falling ? "descending" : "ascending" : "none");
      th.firstElementChild.replaceChildren(...worded(this.columns[i].name + (here ? this.falling ? " ▼" : " ▲" : "")));
    });
    this.page = 0;
    this.show();
  }

  // The rows whose text or whole numbers contain the words of the filter.
  rows() {
    const chosen = this.among ? this.order.filter(row => this.among.has(row)) : this.order;
    if (!this.words) return chosen;
    const among = this.columns.filter(c => c.text || c.values && !(c.values instanceof Float32Array || c.values instanceof Float64Array));
    return chosen.filter(row => among.some(c => String(c.at(row)).toLowerCase().includes(this.words)));
  }

  show() {
    const rows = this.rows(), pages = Math.max(Math.ceil(rows.length / this.size), 1);
    this.page = Math.min(Math.max(this.page, 0), pages - 1);
    const first = this.page * this.size, shownRows = rows.slice(first, first + this.size);
    this.body.replaceChildren(...Array.from(shownRows, row => this.line(row)));
    this.where.textContent = rows.length ? `${grouped(first + 1)}–${grouped(first + shownRows.length)} of ${grouped(rows.length)}` : "no rows";
    this.back.disabled = this.page === 0;
    this.on.disabled = this.page === pages - 1;
  }

  line(row) {
    const cells = this.columns.map(column => {
      const value = column.at(row);
      const cell = { class: column.text ? "text" : null, title: column.text && value.length > 30 ? value : null };
      const address = column.address?.(row);
      return address ? make("td", cell, make("a", { href: address, text: shown(value) })) : make("td", { ...cell, text: shown(value) });
    });
    const line = make("tr", { class: this.table.mark?.(row) ?? null }, ...cells);
    if (this.table.ofVessels) {
      line.className = "vessel";
      line.dataset.row = row;
      line.setAttribute("aria-selected", row === this.picked);
      const first = cells[0], button = make("button", { type: "button", text: first.textContent, "aria-label": `Select vessel ${row}` });
      first.replaceChildren(button);
      line.addEventListener("click", () => this.picks(row));
    }
    return line;
  }

  // Marks the row of a vessel; `turn` also goes to its page.
  pick(row, turn) {
    if (!this.table.ofVessels) return;
    this.picked = row;
    const place = turn ? this.rows().indexOf(row) : -1;
    const page = Math.floor(place / this.size);
    if (place >= 0 && page !== this.page) { this.page = page; this.show(); }
    for (const line of this.body.children) line.setAttribute("aria-selected", Number(line.dataset.row) === row);
  }

  // Shows only these rows, or all.
  only(rows) {
    this.among = rows;
    this.page = 0;
    this.show();
  }

  // Live columns changed.
  refresh() {
    if (this.live.length === 0) return;
    if (this.by && this.live.includes(this.by)) this.sort(this.by, false);
    else this.show();
  }
}
