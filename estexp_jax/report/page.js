"use strict";
// A click on a table's heading sorts by that column; another one turns the order round. What has no number stays last.
const keyOf = (cell, isNumber) => {
  const text = cell.textContent.trim();
  if (!isNumber) return text;
  const value = parseFloat(text.replace(/^[<>]\s*/, ""));
  return text.startsWith("<") ? value - 1e-6 : text.startsWith(">") ? value + 1e-6 : value;
};
const sortBy = (table, column, turn) => {
  const isNumber = table.tHead.rows[0].cells[column].classList.contains("number");
  const compare = (a, b) => {
    if (!isNumber) return turn * a.localeCompare(b, "en", { numeric: true });
    if (isNaN(a) || isNaN(b)) return isNaN(a) - isNaN(b);
    return turn * (a - b);
  };
  const rows = [...table.tBodies[0].rows].map((row) => [keyOf(row.cells[column], isNumber), row]);
  rows.sort((a, b) => compare(a[0], b[0])).forEach(([, row]) => table.tBodies[0].append(row));
};
for (const table of document.querySelectorAll("table.sortable")) {
  if (table.tBodies[0].rows.length < 2) continue;
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.title = "Sort by this column";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const turn = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", turn > 0 ? "ascending" : "descending");
      sortBy(table, column, turn);
    });
  });
}
// A click on a figure shows it large, to be moved about where it is larger than the window; Escape or a click closes it.
const large = document.createElement("dialog");
large.className = "large";
large.addEventListener("click", () => large.close());
document.body.append(large);
for (const image of document.querySelectorAll("figure img")) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "zoom";
  button.title = "Enlarge this figure";
  image.replaceWith(button);
  button.append(image);
  button.addEventListener("click", () => {
    const copy = image.cloneNode();
    const close = document.createElement("button");
    close.type = "button";
    close.textContent = "Close";
    large.replaceChildren(close, copy);
    large.showModal();
  });
}
// A button copies a command. Files of one's own disk may be refused the clipboard: then the text is marked, and copied so.
for (const command of document.querySelectorAll("pre.command")) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "copy";
  button.textContent = "Copy";
  command.append(button);
  button.addEventListener("click", async () => {
    const code = command.querySelector("code");
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(code);
      button.textContent = document.execCommand("copy") ? "Copied" : "Marked";
    }
    setTimeout(() => (button.textContent = "Copy"), 2000);
  });
}
// What is folded on a screen is printed.
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => (part.open = true)));
