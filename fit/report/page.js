"use strict";
(() => {
  const $$ = (what, within = document) => Array.from(within.querySelectorAll(what));
  const metric = document.getElementById("choose-metric");
  const lobes = document.getElementById("choose-lobes");
  const materials = document.getElementById("filter-materials");
  const models = document.getElementById("filter-models");
  const errors = $$("table.errors");
  const value = (cell) => {
    if (cell.tagName === "TH") return cell.textContent;
    const numbers = (cell.dataset.v || "").split(" ");
    const text = numbers.length > 1 ? numbers[metric.selectedIndex] : numbers[0];
    return text ? Number(text) : Infinity;
  };
  const compare = (a, b) => typeof a === "string" ? a.localeCompare(b, undefined, {numeric: true}) : a === b ? 0 : a - b;
  const sort = (table, column, descending) => {
    const rows = Array.from(table.tBodies[0].rows);
    rows.sort((a, b) => {
      const x = value(a.cells[column]), y = value(b.cells[column]);
      // What is missing comes last, whichever way.
      if (x === Infinity || y === Infinity) return x === y ? 0 : x === Infinity ? 1 : -1;
      return descending ? compare(y, x) : compare(x, y);
    });
    table.tBodies[0].append(...rows);
  };
  for (const table of $$("table.sortable"))
    $$("thead button", table).forEach((button, column) => button.addEventListener("click", () => {
      const head = button.parentElement;
      const descending = head.getAttribute("aria-sort") === "ascending";
      $$("thead th", table).forEach((th) => th.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", descending ? "descending" : "ascending");
      sort(table, column, descending);
    }));
  const words = (input) => input.value.toLowerCase().split(/[\s,]+/).filter((word) => word);
  const matches = (wanted, text) => wanted.length === 0 || wanted.some((word) => text.toLowerCase().includes(word));
  const filter = () => {
    const of_materials = words(materials), of_models = words(models);
    for (const section of $$(".lobes"))
      section.hidden = lobes.value !== "" && section.dataset.lobes !== lobes.value;
    for (const table of errors) {
      const shown = Array.from(table.tHead.rows[0].cells, (th, i) => i === 0 || matches(of_models, th.textContent));
      for (const row of table.rows)
        Array.from(row.cells).forEach((cell, i) => { cell.hidden = !shown[i]; });
      for (const row of table.tBodies[0].rows)
        row.hidden = !matches(of_materials, row.cells[0].textContent);
    }
    for (const card of $$(".card"))
      card.hidden = !matches(of_materials, card.dataset.name);
  };
  const format = (x) => Number(x).toPrecision(4).replace(/e([+-])(\d)$/, "e$10$2");
  const show = () => {
    for (const table of errors) {
      for (const row of table.tBodies[0].rows) {
        const cells = Array.from(row.cells).slice(1);
        const least = Math.min(...cells.map(value));
        for (const cell of cells) {
          if (!cell.dataset.v) continue;
          cell.textContent = format(value(cell));
          cell.classList.toggle("best", value(cell) === least);
        }
      }
      const foot = table.tFoot.rows[0];
      Array.from(foot.cells).slice(1).forEach((cell, i) => {
        const all = Array.from(table.tBodies[0].rows, (row) => value(row.cells[i + 1])).filter(Number.isFinite);
        cell.textContent = all.length ? format(all.reduce((a, b) => a + b, 0) / all.length) : "–";
      });
    }
  };
  for (const section of $$(".lobes")) lobes.add(new Option(section.dataset.lobes));
  $$(".tools").forEach((tools) => {
    tools.hidden = false;
    tools.addEventListener("submit", (event) => event.preventDefault());
  });
  for (const input of [materials, models]) input.addEventListener("input", filter);
  lobes.addEventListener("change", filter);
  metric.addEventListener("change", show);
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = $$("details:not([open])");
    closed.forEach((details) => { details.open = true; });
  });
  addEventListener("afterprint", () => closed.forEach((details) => { details.open = false; }));
})();
