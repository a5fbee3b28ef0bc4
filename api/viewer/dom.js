// Elements without a framework: a tag, attributes or listeners, children.

const SVG = "http://www.w3.org/2000/svg";

/** An HTML element. `on…` are listeners; true, false and null make attributes present or absent. */
export function html(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** An SVG element. */
export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.flat(Infinity).filter((child) => child != null && child !== false));
  return element;
}

/** A button with words, and what it does. */
export function button(words, onclick, attributes = {}) {
  return html("button", { type: "button", onclick, ...attributes }, words);
}

/** A select with a label; `options` are [value, words]. */
export function select(label, options, value, onchange) {
  const choice = html(
    "select",
    { onchange: () => onchange(choice.value) },
    options.map(([key, words]) => html("option", { value: key, selected: key === value }, words)),
  );
  return html("label", { class: "field" }, html("span", {}, label), choice);
}

/** A checkbox with a label. */
export function checkbox(label, checked, onchange) {
  const box = html("input", { type: "checkbox", checked, onchange: () => onchange(box.checked) });
  return html("label", { class: "check" }, box, label);
}

/** A table: names of columns, and rows of words or elements. On a narrow screen each row of a wide one becomes a list. */
export function table(caption, columns, rows) {
  const header = html("tr", { role: "row" }, columns.map((name) => html("th", { scope: "col", role: "columnheader" }, name)));
  const named = (cell, i) => html("td", { role: "cell", "data-column": columns[i] }, html("div", {}, cell));
  const body = rows.map(([first, ...others]) =>
    html("tr", { role: "row" }, html("th", { scope: "row", role: "rowheader" }, first), others.map((cell, i) => named(cell, i + 1))),
  );
  const isWide = columns.length > 3;
  const inside = html("table", { role: "table", class: isWide && "rows" }, html("caption", {}, caption), html("thead", { role: "rowgroup" }, header), html("tbody", { role: "rowgroup" }, body));
  return html("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": caption }, inside);
}

/** A word with its explanation, for the pointer, the finger and the keyboard. */
export function term(word, about) {
  return html("span", { class: "term", tabindex: "0", role: "note", "aria-label": `${word}: ${about}`, "data-about": about }, word);
}

/** Gives the reader a file. */
export function saveFile(name, content, type) {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const address = URL.createObjectURL(blob);
  html("a", { href: address, download: name }).click();
  // The browser takes the content before the next turn but one.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
