// The data of the page: columns decoded into typed arrays.
const data = JSON.parse(byId("data").textContent);

const ARRAYS = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f64: Float64Array };

function decoded(kind, text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new ARRAYS[kind](bytes.buffer);
}
const numbers = (column, rows) =>
  column.kind === "row" ? Uint32Array.from({ length: rows }, (_, row) => row) : decoded(column.kind, column.data);

// A column: `at(row)` is a number or a text.
function column(source, rows) {
  if (source.kind === "text") {
    const which = numbers(source.rows, rows);
    return { name: source.name, text: true, at: row => source.words[which[row]] };
  }
  const values = numbers(source, rows);
  return { name: source.name, text: false, values, at: row => values[row] };
}

function table(source) {
  const columns = source.columns.map(c => column(c, source.rows));
  return { title: source.title, rows: source.rows, ofVessels: source.of_vessels, columns, find: name => columns.find(c => c.name === name) };
}

// The range of points of each vessel, and the points in mm: x, y, z and radius. Markers follow the vessels.
function geometry(source) {
  const whole = decoded("u16", source.points);
  const points = new Float32Array(whole.length);
  for (let i = 0; i < whole.length; i += 4) {
    for (let axis = 0; axis < 3; axis++) points[i + axis] = source.corner[axis] + whole[i + axis] * source.steps[0];
    points[i + 3] = whole[i + 3] * source.steps[1];
  }
  const rows = source.counts.kind === "row" ? 0 : decoded(source.counts.kind, source.counts.data);
  const starts = [0];
  for (const count of rows || []) starts.push(starts.at(-1) + count);
  const vessels = starts.length - 1;
  for (const _ of source.markers) starts.push(starts.at(-1) + 1);
  return { points, starts, vessels, markers: source.markers };
}
