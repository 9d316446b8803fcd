// Elements from plain values. Text is always text: nothing that comes from a log is ever read as HTML.

export const by = (id) => document.getElementById(id);

/** An element with attributes (`on…` are listeners) and children; strings become text. */
export function h(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined).map((child) =>
    child instanceof Node ? child : document.createTextNode(String(child))));
  return node;
}

/** Replaces what stands in an element. */
export function fill(node, ...children) {
  node.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined).map((child) =>
    child instanceof Node ? child : document.createTextNode(String(child))));
}

/** A table with a caption; the first cell of each row is its head. */
export function table(caption, head, rows) {
  const isText = (index) => rows.some((row) => /\p{L}{3}/u.test(row[index]));
  return h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    h("table", {},
      h("caption", {}, caption),
      h("thead", {}, h("tr", {}, head.map((text, index) => h("th", { scope: "col", class: isText(index) ? "text" : null }, text)))),
      h("tbody", {}, rows.map((row) => h("tr", {}, row.map((cell, index) =>
        index === 0 ? h("th", { scope: "row" }, cell) : h("td", { class: isText(index) ? "text" : null }, cell)))))));
}

/** Something long, closed until it is asked for; `make` gives its content then, and each time again where it is `fresh`. */
export function later(summary, make, fresh = false) {
  const body = h("div");
  let made = false;
  return h("details", {
    ontoggle: (event) => {
      if (event.target.open && (fresh || !made)) {
        made = true;
        fill(body, make());
      }
    },
  }, h("summary", {}, summary), body);
}

/** Gives the text to the person as a file. */
export function save(name, text, type = "text/plain") {
  const address = URL.createObjectURL(new Blob([text], { type }));
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}
