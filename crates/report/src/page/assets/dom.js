// Elements and text. Data enters the page only through textContent and attributes, never as markup. A function is called at the event of its name.
const SVG = "http://www.w3.org/2000/svg";
const byId = id => document.getElementById(id);

function furnish(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") element.textContent = value;
    else if (typeof value === "function") element.addEventListener(name, value);
    // States of accessibility are words: "true", "false".
    else if (name.startsWith("aria-") && typeof value === "boolean") element.setAttribute(name, String(value));
    else if (value !== null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}
const make = (tag, attributes = {}, ...children) => furnish(document.createElement(tag), attributes, children);
const draw = (tag, attributes = {}, ...children) => furnish(document.createElementNS(SVG, tag), attributes, children);

// A figure as tables and labels show it; empty when there is none.
function shown(x, digits = 5) {
  if (typeof x !== "number") return x === null || x === undefined ? "" : String(x);
  if (Number.isNaN(x)) return "";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  if (Number.isInteger(x) && Math.abs(x) < 1e15) return (x < 0 ? "−" : "") + grouped(Math.abs(x));
  const size = Math.abs(x);
  const text = size >= 1e6 || size < 1e-3 ? x.toExponential(digits - 2) : String(Number(x.toPrecision(digits)));
  return text.replace("e+", "e").replaceAll("-", "−");
}
const grouped = x => x < 10000 ? String(x) : String(x).replace(/\B(?=(\d{3})+$)/g, "\u202f");

// The numbers from 0 to one less than n: the rows of a table.
const upTo = n => [...Array(n).keys()];

// What is listed under each key, in the order of `[key, item]`.
function listedBy(entries) {
  const lists = new Map();
  for (const [key, item] of entries) {
    if (!lists.has(key)) lists.set(key, []);
    lists.get(key).push(item);
  }
  return lists;
}

// `1 vessel`, `2 vessels`.
const count = (n, one) => `${grouped(n)} ${n === 1 ? one : `${one}s`}`;

const POWERS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const power = e => "10" + (e < 0 ? "⁻" : "") + [...String(Math.abs(e))].map(d => POWERS[d]).join("");
const withUnit = (text, unit) => unit && text ? `${text} ${unit}` : text;

// A list of names and what they stand for.
const pairs = entries => make("dl", { class: "pairs" }, ...entries.flatMap(([name, value]) => [make("dt", { text: name }), make("dd", { text: value })]));

// Saves something as a file of a name.
function save(blob, name) {
  const address = URL.createObjectURL(blob);
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// Shows the first cards of an order, and more of them on demand; `card(row)` makes one.
const CARDS = 24;
function showCards(order, card) {
  const button = byId("more-cards");
  let at = 0;
  const more = () => {
    byId("cards").append(...order.slice(at, at + CARDS).map(card));
    at += CARDS;
    button.hidden = at >= order.length;
    button.textContent = `Show more (${grouped(order.length - at)})`;
  };
  button.addEventListener("click", more);
  more();
}

// A path as an address.
const encoded = path => path.split("/").map(encodeURIComponent).join("/");

// The address of another page of the same folders, which then leads back here.
function wayTo(page, goal = "") {
  const steps = page.split("/"), up = steps.filter(step => step === "..").length, here = location.pathname.split("/").filter(Boolean).map(decodeURIComponent);
  // From that page: as many steps up as it lies down, and down as many as it lies up.
  const back = [...Array(steps.length - up - 1).fill(".."), ...here.slice(here.length - up - 1)].join("/");
  return `${encoded(page)}?from=${encodeURIComponent(back)}${goal ? `#${goal}` : ""}`;
}

// A link back to the page that led here; only to a page in a folder nearby.
function showBack() {
  const from = new URLSearchParams(location.search).get("from");
  if (from && /^(\.\.\/)*([^/:\\?#]+\/)*[^/:\\?#]+\.html$/.test(from)) byId("origin").before(make("p", {}, make("a", { id: "back", href: encoded(from), text: "‹ Back to where you came from" })));
}

// Shows the parts of a page in order, and the error if one fails.
function showAll(...parts) {
  try {
    for (const part of parts) part();
    document.documentElement.dataset.ready = "yes";
  } catch (error) {
    byId("failure").textContent = `A part of this page could not be shown: ${error.message}`;
    byId("failure").hidden = false;
    throw error;
  }
}
