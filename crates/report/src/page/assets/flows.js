// What a simulation changed, and which way blood flows, beside the vessels.
const MOST_ARROWS = 300;

class Flows {
  constructor(scene, vessels, tables) {
    const rows = title => { const of = tables.find(t => t.title === title); return Array.from({ length: of?.rows ?? 0 }, (_, at) => name => of.find(name).at(at)); };
    Object.assign(this, { scene, vessels });
    this.reversed = new Set(rows("Reversed flows").map(of => of("edge")));
    this.changed = rows("Perturbations").map(of => ({ at: scene.shape.middle(of("edge")), text: of("kind"), strong: true }));
    const long = vessels.find("length_mm");
    this.rows = upTo(vessels.rows).sort((a, b) => long.at(b) - long.at(a) || a - b).slice(0, MOST_ARROWS);
    this.rows.push(...[...this.reversed].filter(row => !this.rows.includes(row)));
  }

  // Shows the flows after the change, or before it.
  show(before) {
    const flow = !before && this.vessels.find("flow_mL_per_min_perturbed") || this.vessels.find("flow_mL_per_min"), { overlay, shape } = this.scene;
    overlay.changes = before ? [] : this.changed;
    overlay.arrows = this.rows.filter(row => Math.abs(flow.at(row)) > 1e-9).map(row => {
      const { at, towards } = shape.course(row).at(0), sign = Math.sign(flow.at(row)), reversed = !before && this.reversed.has(row);
      return { at, towards: towards.map(d => sign * d), reversed, text: reversed ? "reversed" : "", strong: true };
    });
  }
}
