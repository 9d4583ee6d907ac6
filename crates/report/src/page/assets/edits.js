// Edits of the graph by places: a vessel joined, vessels that meet parted, a vessel deleted. Places come from clicks in the view, or are typed.
const EDITS = { join: "Joined", part: "Parted", delete: "Deleted" };
// What to click, by how many places there are in the group that is being made, and how many groups before it.
const GUIDES = {
  join: here => here === 0 ? "Click where the vessel begins." : here === 1 ? "Click where it ends, or places on its way." : "Add it, or click on.",
  part: (here, groups) => here === 0 ? `Click ${groups ? "the vessels that go together instead" : "vessels that go together"}, a little outside of where they touch.` : groups ? "Add it, click on, or begin another group." : "Click on, then begin the next group.",
  delete: here => here === 0 ? "Click the vessel that is none." : "Add it.",
};

class Edits {
  constructor(decisions, scene) {
    Object.assign(this, { decisions, scene });
    this.kind = byId("edit-kind");
    this.places = byId("edit-places");
    this.panel = byId("edits");
    this.panel.addEventListener("toggle", () => this.show());
    this.kind.addEventListener("change", () => { this.places.value = ""; this.show(); });
    this.places.addEventListener("input", () => this.show());
    byId("edit-group").addEventListener("click", () => { this.places.value = `${this.places.value.trim()} | `; this.show(); });
    byId("edit-clear").addEventListener("click", () => { this.places.value = ""; this.show(); });
    byId("edit-add").addEventListener("click", () => this.add());
    this.show();
  }

  // Whether clicks in the view are places of an edit.
  get open() {
    return this.panel.open;
  }

  // A place of the view, mm, as the next of the edit.
  take(place) {
    const text = place.map(x => Number(x.toFixed(3))).join(" "), before = this.places.value.trim();
    this.places.value = this.kind.value === "delete" || !before ? text : /\|$/.test(before) ? `${before} ${text}` : `${before} + ${text}`;
    this.show();
  }

  // The groups of places as they are typed: lists of [x, y, z]; null where one is no place.
  get groups() {
    const place = text => { const words = text.trim().split(/\s+/); return words.length === 3 && words.every(word => word !== "" && Number.isFinite(Number(word))) ? words.map(Number) : null; };
    return this.places.value.split("|").map(group => group.trim() === "" ? [] : group.split("+").map(place));
  }

  // What is wrong with the places; empty where they make an edit.
  get fault() {
    const { groups } = this, kind = this.kind.value;
    if (groups.flat().includes(null)) return "A place is three numbers of mm, x y z; + stands between places, | between groups.";
    if (groups.some(group => group.length === 0)) return " ";
    if (kind === "part") return groups.length > 1 ? "" : " ";
    return groups.length === 1 && (kind === "delete" ? groups[0].length === 1 : groups[0].length > 1) ? "" : " ";
  }

  add() {
    if (this.fault) return;
    this.decisions.edit(this.kind.value, this.groups.map(group => group.map(place => place.join(" ")).join(" + ")).join(" | "));
    this.places.value = "";
    this.show();
  }

  show() {
    const { groups, fault } = this, kind = this.kind.value, all = this.decisions.edits;
    byId("edit-guide").textContent = fault.trim() || GUIDES[kind](groups.at(-1).length, groups.length - 1);
    byId("edit-group").hidden = kind !== "part";
    byId("edit-group").disabled = groups.at(-1).length === 0 || groups.flat().includes(null);
    byId("edit-add").disabled = Boolean(fault);
    byId("edit-list").replaceChildren(...all.map(({ decision, places }, at) => {
      const remove = make("button", { type: "button", text: "Remove", "aria-label": `Remove edit ${at + 1}: ${decision}` });
      remove.addEventListener("click", () => { this.decisions.removeEdit(at); byId("edit-kind").focus(); });
      return make("li", {}, make("b", { text: EDITS[decision] }), " ", make("small", { text: places }), " ", remove);
    }));
    byId("edit-note").hidden = all.length === 0;
    if (!this.scene) return;
    // Places that are not added yet have the number of their group.
    this.scene.overlay.places = this.open ? groups.flatMap((group, at) => group.filter(Boolean).map(place => ({ at: place, text: kind === "part" ? String.fromCharCode(65 + at % 26) : "" }))) : [];
    for (const { decision, places } of this.open ? all : []) {
      for (const text of places.split(/[|+]/)) this.scene.overlay.places.push({ at: text.trim().split(/\s+/).map(Number), text: decision });
    }
    this.scene.paint();
  }
}
