// The menus of the leaderboards. Everything shown was worked out before: a menu chooses another part
// of it, a filter leaves lines out, a question chooses the setting of each codec and the order.
const told = JSON.parse(document.getElementById("boards").textContent);
const machine = document.getElementById("machine");
const kind = document.getElementById("kind");

const make = (tag, text, more = {}) => Object.assign(document.createElement(tag), {textContent: text}, more);

function Leaderboard(section, views) {
  const [part, access, floor, all] = ["part", "access", "floor", "all"].map(name => section.querySelector("." + name));
  const answers = Array.from(section.querySelectorAll(".answer"));
  const table = section.querySelector("table");
  const headings = Array.from(table.tHead.rows[0].cells);
  let asked = 0;

  const value = (line, column) => { const cell = line[2][column]; return cell.length > 1 && cell[1] !== null ? cell[1] : undefined; };
  // Lines with the figure first, by it, then by rate; the sort keeps what is equal in its order.
  const better = ([, column, smaller]) => (a, b) => {
    const [x, y] = [value(a, column), value(b, column)];
    if ((x === undefined) !== (y === undefined)) return x === undefined ? 1 : -1;
    if (x !== undefined && x !== y) return smaller ? x - y : y - x;
    const [p, q] = [value(a, told.rate) ?? Infinity, value(b, told.rate) ?? Infinity];
    return p === q ? 0 : p - q;
  };

  function kept(lines) {
    const least = floor === null || floor.value === "" ? -Infinity : floor.value === "exact" ? 1e9 : Number(floor.value);
    return lines.filter(line => (access.value === "" || told.codecs[line[0]][2] === access.value) &&
      (least === -Infinity || (value(line, told.psnr) ?? -Infinity) >= least));
  }

  function fillCell(cell, [text = "", sort = null, detail = "", href = ""]) {
    cell.className = "num";
    if (sort !== null) cell.dataset.sort = sort;
    if (href) cell.append(make("a", text, {href})); else cell.textContent = text;
    if (detail) cell.append(" ", make("small", detail));
  }

  function lineOf([codec, setting, cells]) {
    const line = document.createElement("tr");
    const [id, page, reach] = told.codecs[codec];
    const head = make("th", "", {scope: "row"});
    head.append(make("a", id, {href: page}));
    if (setting) head.append(" ", make("small", setting));
    line.append(head, make("td", reach));
    for (const one of cells) fillCell(line.insertCell(), one);
    return line;
  }

  function markBest(lines) {
    told.questions.forEach(([, column, smaller]) => {
      const known = lines.filter(line => told.codecs[line[0]][0] !== told.plain).map(line => value(line, column)).filter(x => x !== undefined);
      const best = smaller ? Math.min(...known) : Math.max(...known);
      lines.forEach((line, at) => {
        if (value(line, column) === best && told.codecs[line[0]][0] !== told.plain) table.tBodies[0].rows[at].cells[column + 2].classList.add("best");
      });
    });
  }

  function show() {
    const view = views.find(one => one.clock === Number(machine.value));
    const chosen = view ? view.parts[part.value === "" ? 0 : Number(part.value)] : {volumes: "", pages: [], left: "", lines: []};
    const lines = kept(chosen.lines);
    answers.forEach((button, at) => {
      const question = told.questions[at];
      const first = lines.slice().sort(better(question)).find(line => told.codecs[line[0]][0] !== told.plain && value(line, question[1]) !== undefined);
      const psnr = first && told.psnr in first[2] ? first[2][told.psnr][0] : "exact";
      button.querySelector("strong").textContent = first ? told.codecs[first[0]][0] : "";
      button.querySelector(".figure").textContent = first ?
        first[2][question[1]][0] + " " + question[3] + (psnr && psnr !== "exact" ? ", " + psnr + " dB" : "") : "not measured";
      button.setAttribute("aria-pressed", at === asked);
    });
    const ordered = lines.slice().sort(better(told.questions[asked]));
    const seen = new Set();
    const shown = all.checked ? ordered : ordered.filter(line => !seen.has(line[0]) && seen.add(line[0]));
    table.tBodies[0].replaceChildren(...shown.map(lineOf));
    markBest(shown);
    headings.forEach(one => one.removeAttribute("aria-sort"));
    const [, column, smaller] = told.questions[asked];
    headings[column + 2].setAttribute("aria-sort", smaller ? "ascending" : "descending");
    const number = chosen.pages.length;
    section.querySelector(".over").textContent = !view ? "Nothing of this kind was measured there." :
      (number > 1 ? "Geometric means over " + number + " data sets that all of these codecs have: " + chosen.volumes + "." : "One data set: " + chosen.volumes + ".") +
      (all.checked ? " All settings." : " Of each codec the setting that is best at the question.");
    section.querySelector(".left").textContent = chosen.left ? "In no mean, since not measured on all of these data sets: " + chosen.left + "." : "";
  }

  function fillParts() {
    const view = views.find(one => one.clock === Number(machine.value));
    const before = part.selectedOptions.length ? part.selectedOptions[0].textContent : "";
    part.replaceChildren(...(view ? view.parts : []).map((one, at) => make("option", one.title, {value: at})));
    const same = Array.from(part.options).find(one => one.textContent === before);
    if (same) part.value = same.value;
  }

  answers.forEach((button, at) => button.addEventListener("click", () => { asked = at; show(); }));
  for (const control of [part, access, floor, all]) if (control) control.addEventListener("change", show);
  return () => { fillParts(); show(); };
}

const boards = Array.from(document.querySelectorAll("section.board"), section => Leaderboard(section, told.boards[Number(section.dataset.board)]));
const refresh = () => boards.forEach(one => one());
machine.addEventListener("change", refresh);
if (kind) kind.addEventListener("change", () => {
  for (const section of document.querySelectorAll("section.board")) section.hidden = kind.value !== "" && section.dataset.kind !== kind.value;
});
refresh();
