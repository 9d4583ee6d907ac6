// A slider in the place of the list of variants where these are the times of a cycle.
function cycleSlider(variant, colourings) {
  const slider = make("input", { type: "range", id: "cycle", min: 0, step: 1, "aria-label": "time in the cycle" });
  const label = byId("variant-label");
  label.append(slider);
  slider.addEventListener("input", () => {
    variant.value = slider.value;
    variant.dispatchEvent(new Event("change"));
  });
  return chosen => {
    const over = colourings[chosen]?.name === "flow over the cycle";
    slider.hidden = !over;
    slider.max = Math.max(variant.options.length - 1, 0);
    slider.value = variant.value;
  };
}
