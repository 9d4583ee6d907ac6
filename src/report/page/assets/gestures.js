// Mouse, touch and keys in the view. `picks(row)` is called with the vessel under a click, `steps(by)` to go to the next or previous one.
function listen(scene, picks, steps) {
  const { canvas, camera } = scene, fingers = new Map();
  let moved = 0;
  const fromMiddle = event => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
  };
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    if (fingers.size === 0) moved = 0;
    fingers.set(event.pointerId, fromMiddle(event));
  });
  canvas.addEventListener("pointermove", event => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = fromMiddle(event), [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.hypot(dx, dy);
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const apart = p => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      camera.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      camera.pan(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) camera.pan(dx, dy);
    else camera.orbit(0.008 * dx, 0.008 * dy);
    fingers.set(event.pointerId, now);
    scene.paint();
  });
  const leave = event => {
    const mine = fingers.delete(event.pointerId);
    if (!mine || fingers.size > 0 || event.type !== "pointerup" || moved > 5 || event.button > 0) return;
    picks(scene.at(...fromMiddle(event), event.pointerType === "touch" ? 14 : 5));
  };
  canvas.addEventListener("pointerup", leave);
  canvas.addEventListener("pointercancel", leave);
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;
    camera.zoom(Math.exp(-0.0015 * Math.min(Math.max(event.deltaY * lines, -300), 300)), ...fromMiddle(event));
    scene.paint();
  }, { passive: false });

  const turn = Math.PI / 24, step = 30;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const views = {
    fit: () => camera.fit(), z: () => camera.look("z"), y: () => camera.look("y"), x: () => camera.look("x"),
    in: () => camera.zoom(1.25), out: () => camera.zoom(0.8),
  };
  const keys = {
    "+": views.in, "=": views.in, "-": views.out, _: views.out, 0: () => camera.look(camera.home),
    n: () => steps(1), p: () => steps(-1), Escape: () => picks(-1),
  };
  canvas.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    if (arrow && event.shiftKey) camera.pan(step * arrow[0], step * arrow[1]);
    else if (arrow) camera.orbit(turn * arrow[0], turn * arrow[1]);
    else if (Object.hasOwn(keys, event.key)) keys[event.key]();
    else return;
    event.preventDefault();
    scene.paint();
  });
  for (const button of document.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => { views[button.dataset.view](); scene.paint(); });
  }
}
