"use strict";
// Tables with class "sortable": each heading becomes a button that sorts by its column; above each
// table a field filters lines, but where the table has data-unfiltered.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  const headings = Array.from(table.tHead.rows[0].cells);
  const key = (line, column) => {
    const cell = line.cells[column];
    return cell.dataset.sort === undefined ? cell.textContent.trim() : Number(cell.dataset.sort);
  };
  // Numbers before texts before nothing, whichever the direction.
  const compare = (a, b, direction) => {
    if ((a === "") !== (b === "")) return a === "" ? 1 : -1;
    if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
    return direction * (typeof a === "number" ? a - b : a.localeCompare(b, "en", {numeric: true}));
  };
  headings.forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => {
      const ascending = heading.getAttribute("aria-sort") !== "ascending";
      headings.forEach(one => one.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      const sorted = Array.from(body.rows).map((line, at) => ({line, at, value: key(line, column)}));
      sorted.sort((a, b) => compare(a.value, b.value, ascending ? 1 : -1) || a.at - b.at);
      body.append(...sorted.map(one => one.line));
    });
  });
  if (body.rows.length < 6 || "unfiltered" in table.dataset) continue;
  const label = document.createElement("label");
  label.className = "filter";
  const field = document.createElement("input");
  field.type = "search";
  const found = document.createElement("output");
  label.append("Filter ", field, " ", found);
  table.closest(".scroll").before(label);
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    const lines = Array.from(body.rows);
    let shown = 0;
    for (const line of lines) {
      const text = line.textContent.toLowerCase();
      line.hidden = !words.every(word => text.includes(word));
      shown += !line.hidden;
    }
    found.textContent = words.length ? shown + " of " + lines.length : "";
  });
}
addEventListener("beforeprint", () => { for (const part of document.querySelectorAll("details")) part.open = true; });
