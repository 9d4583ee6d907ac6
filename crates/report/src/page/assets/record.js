// How a run was made: its input and warnings, the command to repeat it, its notes, and its record.
function showSource(warnings) {
  const { input, willis } = data.record;
  byId("origin").textContent = `${input.path} (${input.format}, ${input.units}). Made by willis ${willis}.`;
  byId("warnings").hidden = warnings.length === 0;
  byId("warnings").append(...warnings.map(text => make("li", { text })));
}

// A section of the record, with nested objects as one list.
function recordPart(title, part) {
  const flat = (prefix, object) => Object.entries(object).flatMap(([key, value]) => {
    const name = prefix ? `${prefix}: ${key}` : key;
    if (value === null) return [];
    if (Array.isArray(value)) return [[name, value.length > 40 ? `${value.length} entries` : value.map(v => typeof v === "object" ? JSON.stringify(v) : shown(v, 7)).join(", ")]];
    return typeof value === "object" ? flat(name, value) : [[name, shown(value, 7)]];
  });
  return make("section", {}, make("h3", { text: title }), pairs(flat("", part)));
}

function showRun() {
  const { record } = data, box = byId("command");
  box.value = record.command;
  byId("copy").addEventListener("click", async () => {
    box.select();
    let done = false;
    try {
      await navigator.clipboard.writeText(box.value);
      done = true;
    } catch {
      done = document.execCommand("copy");
    }
    byId("copied").textContent = done ? "Copied." : "Selected: press Ctrl-C or Cmd-C to copy.";
  });
  byId("notes").append(...(record.notes || []).map(text => make("li", { text })));
  const parts = Object.entries(record).filter(([, part]) => part && typeof part === "object" && !Array.isArray(part));
  const loose = Object.entries(record).filter(([name, part]) => name !== "command" && (typeof part !== "object" || part === null));
  byId("record").append(recordPart("run", Object.fromEntries(loose)), ...parts.map(([name, part]) => recordPart(name.replaceAll("_", " "), part)));
  (record.classes || []).forEach(part => byId("record").append(recordPart(`class ${part.class}`, part)));
}
