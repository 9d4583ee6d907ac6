// Mouse, touch and keys in the view. `acts` has `pick(row)`, `hover(row, x, y)`, `step(by)` and `key(name)`.
function listen(scene, acts) {
  const { canvas, camera } = scene, fingers = new Map();
  let moved = 0, hinted = 0;
  const fromMiddle = event => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
  };
  // One finger scrolls the page; more belong to the view.
  for (const kind of ["touchstart", "touchmove"]) {
    canvas.addEventListener(kind, event => { if (event.touches.length > 1) event.preventDefault(); }, { passive: false });
  }
  const hint = () => {
    const note = byId("touch-hint");
    note.hidden = false;
    clearTimeout(hinted);
    hinted = setTimeout(() => { note.hidden = true; }, 1200);
  };
  canvas.addEventListener("pointerdown", event => {
    if (event.pointerType !== "touch") canvas.setPointerCapture(event.pointerId);
    if (fingers.size === 0) moved = 0;
    fingers.set(event.pointerId, fromMiddle(event));
    acts.hover(-1);
  });
  let hovering = 0;
  canvas.addEventListener("pointermove", event => {
    const before = fingers.get(event.pointerId), now = fromMiddle(event);
    if (!before) {
      if (event.pointerType === "touch") return;
      cancelAnimationFrame(hovering);
      hovering = requestAnimationFrame(() => acts.hover(scene.at(...now, 4), ...now));
      return;
    }
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.hypot(dx, dy);
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    fingers.set(event.pointerId, now);
    if (event.pointerType === "touch" && !other) return;
    scene.halt();
    if (fingers.size > 2) camera.pan(dx / fingers.size, dy / fingers.size);
    else if (other) {
      const apart = p => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      camera.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      camera.orbit(0.005 * dx, 0.005 * dy);
    } else if (event.shiftKey || event.buttons & 6) camera.pan(dx, dy);
    else camera.orbit(0.008 * dx, 0.008 * dy);
    scene.move();
  });
  const leave = event => {
    const mine = fingers.delete(event.pointerId);
    if (event.type === "pointercancel" && event.pointerType === "touch" && fingers.size === 0) hint();
    if (!mine || fingers.size > 0 || event.type !== "pointerup" || moved > 5 || event.button > 0) return;
    acts.pick(scene.at(...fromMiddle(event), event.pointerType === "touch" ? 14 : 5));
  };
  canvas.addEventListener("pointerup", leave);
  canvas.addEventListener("pointercancel", leave);
  canvas.addEventListener("pointerleave", () => { cancelAnimationFrame(hovering); acts.hover(-1); });
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    scene.halt();
    const lines = event.deltaMode === 1 ? 16 : 1;
    camera.zoom(Math.exp(-0.0015 * Math.min(Math.max(event.deltaY * lines, -300), 300)), ...fromMiddle(event));
    scene.move();
  }, { passive: false });

  const turn = Math.PI / 24, step = 30;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const whole = view => () => { scene.halt(); acts.whole(); view(); };
  const views = {
    fit: whole(() => camera.fit()), z: whole(() => camera.look("z")), y: whole(() => camera.look("y")), x: whole(() => camera.look("x")),
    in: () => camera.zoom(1.25), out: () => camera.zoom(0.8),
  };
  const keys = {
    "+": views.in, "=": views.in, "-": views.out, _: views.out, 0: whole(() => camera.look(camera.home)), Escape: () => acts.pick(-1),
  };
  canvas.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    if (arrow || Object.hasOwn(keys, event.key)) scene.halt();
    if (arrow && event.shiftKey) camera.pan(step * arrow[0], step * arrow[1]);
    else if (arrow) camera.orbit(turn * arrow[0], turn * arrow[1]);
    else if (Object.hasOwn(keys, event.key)) keys[event.key]();
    else return;
    event.preventDefault();
    scene.paint();
  });
  // The keys of the list work where nothing else has the focus, in the view and in the list, but not in fields; a switch turns them off.
  document.addEventListener("keydown", event => {
    const { target } = event, isField = /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName) && target.type !== "checkbox";
    if (event.ctrlKey || event.metaKey || event.altKey || isField || !byId("letters").checked || target !== document.body && !target.closest("#stage, #review")) return;
    if (event.key === "n" || event.key === "p") acts.step(event.key === "n" ? 1 : -1);
    else if (!acts.key(event.key)) return;
    event.preventDefault();
  });
  for (const button of document.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => { views[button.dataset.view](); scene.paint(); });
  }
}
