"""The figure: how often each vessel of the ring, and the whole of it, is above the median."""
import common
from circles import RING


def draw(folder, results, radii, epsilons):
    """One row a vessel, one column a candidate radius and ε."""
    plt = common.pyplot()
    if not plt:
        return
    columns = [(radius, epsilon) for radius in radii for epsilon in epsilons]
    groups = [[r["ring"] for r in results if (r["radius"], r["epsilon"]) == column] for column in columns]
    shares = [[100 * sum(ring[i] == "1" for ring in group) / len(group) for group in groups] for i in range(len(RING))]
    shares.append([100 * sum("0" not in ring for ring in group) / len(group) for group in groups])
    drawing, axis = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
    image = axis.imshow(shares, cmap="cividis_r", vmin=0, vmax=100, aspect="auto")
    for row, line in enumerate(shares):
        for column, share in enumerate(line):
            axis.text(column, row, f"{share:.0f}", ha="center", va="center", fontsize=8, color="white" if share > 45 else "black")
    axis.set_xticks(range(len(columns)), [f"ε {epsilon}" for _, epsilon in columns], fontsize=7)
    axis.set_yticks(range(len(shares)), [*RING, "whole ring"])
    axis.axhline(len(RING) - 0.5, color="white", lw=3)
    for edge in range(1, len(radii)):
        axis.axvline(edge * len(epsilons) - 0.5, color="white", lw=3)
    top = axis.secondary_xaxis("top")
    top.set_xticks([len(epsilons) * i + (len(epsilons) - 1) / 2 for i in range(len(radii))], [name.replace(", ", ",\n") for name in radii.values()], fontsize=8)
    for spines in (axis.spines, top.spines):
        spines[:].set_visible(False)
    axis.tick_params(length=0)
    top.tick_params(length=0)
    drawing.colorbar(image, ax=axis, label="above the median, % of geometries")
    drawing.savefig(folder / "survival.png", dpi=150)
