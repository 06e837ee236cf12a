// Tables sort by the column whose head is clicked: by number where it begins with one, empty cells last.
"use strict";

function figureOf(text) {
  const match = /^[^\w.+-]*([+-]?(?:\d{1,3}(?:,\d{3})+|\d+)?\.?\d*(?:e[+-]?\d+)?)/i.exec(text.trim());
  return match && /\d/.test(match[1]) ? parseFloat(match[1].replaceAll(",", "")) : NaN;
}

function compare(a, b, sign) {
  if (a.text === "" || b.text === "") return (a.text === "") - (b.text === "");
  const numbers = !isNaN(a.value) && !isNaN(b.value);
  if (numbers && a.value !== b.value) return sign * (a.value - b.value);
  if (isNaN(a.value) !== isNaN(b.value)) return isNaN(a.value) ? 1 : -1;
  return sign * a.text.localeCompare(b.text, "en", {numeric: true});
}

function sortBy(table, column) {
  const heads = [...table.tHead.rows[0].cells];
  const order = heads[column].getAttribute("aria-sort") === "ascending" ? "descending" : "ascending";
  heads.forEach((head) => head.removeAttribute("aria-sort"));
  heads[column].setAttribute("aria-sort", order);
  const rows = [...table.tBodies[0].rows].map((row) => {
    const text = row.cells[column] ? row.cells[column].textContent.trim() : "";
    return {row, text, value: figureOf(text)};
  });
  rows.sort((a, b) => compare(a, b, order === "ascending" ? 1 : -1));
  table.tBodies[0].append(...rows.map((entry) => entry.row));
}

for (const table of document.querySelectorAll("table")) {
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => sortBy(table, column));
    const filled = [...table.tBodies[0].rows].map((row) => row.cells[column]).filter((cell) => cell && !/^[-–]?$/.test(cell.textContent.trim()));
    if (filled.length && filled.every((cell) => !isNaN(figureOf(cell.textContent)) && cell.textContent.length < 24)) {
      filled.forEach((cell) => cell.classList.add("number"));
      head.querySelector("button").style.textAlign = "right";
    }
  });
}

// Pairs: left of the bar the truth, right of it the approximation that is chosen, its error beside.
for (const pair of document.querySelectorAll(".pair")) {
  const view = pair.querySelector(".view"), range = pair.querySelector("input"), select = pair.querySelector("select");
  const place = (percent) => view.style.setProperty("--at", `${percent}%`);
  range.addEventListener("input", () => place(range.value));
  const drag = (event) => {
    const box = view.getBoundingClientRect();
    range.value = Math.min(100, Math.max(0, 100 * (event.clientX - box.left) / box.width));
    place(range.value);
  };
  view.addEventListener("pointerdown", (event) => { view.setPointerCapture(event.pointerId); drag(event); });
  view.addEventListener("pointermove", (event) => { if (event.buttons & 1) drag(event); });
  select.addEventListener("change", () => {
    for (const part of pair.querySelectorAll("[data-choice]")) part.hidden = part.dataset.choice !== select.value;
  });
}
