// Place 2: the derivatives, with what determines each.

import { el, refill, svg } from "./dom.js";
import { t, titleOf } from "./words.js";
import { num } from "./format.js";
import { frozen } from "./api.js";
import { roomOf, ticks } from "./linear.js";

const CHANNELS = ["X", "Y", "N", "K"];

export async function showDerivatives(root, app, shown) {
  const found = await app.derivatives();
  shown();
  if (app.tests().kind !== "captive") return void refill(root, el("p", { class: "panel soft" }, t("captive_alone")));
  if (!found) return void refill(root, question(app));
  const detail = el("section", { class: "panel", "aria-live": "polite", "aria-label": t("derivative") });
  const table = el("section", { class: "panel" });
  const choose = (row) => {
    app.derivative = row.name;
    for (const line of table.querySelectorAll("tr[data-name]")) line.setAttribute("aria-selected", line.dataset.name === row.name ? "true" : "false");
    drawDetail(detail, found, row);
  };
  refill(table,
    el("div", { class: "head" }, el("h2", {}, t("place_derivatives")),
      el("span", { class: "soft small" }, t("derivatives_about", { system: found.system, structure: found.structure }))),
    frozen ? null : chooser(app),
    frozen ? null : judged(found),
    el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": t("place_derivatives") }, grid(found, choose)),
    el("p", { class: "soft small" }, found.about, found.reference ? ` ${t("reference", { name: found.reference })}` : null));
  refill(root, el("div", { class: "two wide-left" }, table, detail));
  choose(found.rows.find((row) => row.name === app.derivative) ?? found.rows.find((row) => row.name === "Yv") ?? found.rows[0]);
}

// What stands against them, as the command line says it; a report has it at a glance.
function judged(found) {
  const shade = { "not usable": "finding error", "usable with doubts": "finding warning" }[found.use] ?? "soft small";
  return el("div", {}, found.reasons.length ? el("ul", { class: "small" }, found.reasons.map((text) => el("li", {}, text))) : null, el("p", { class: shade }, found.verdict));
}

function question(app) {
  return el("section", { class: "panel" }, el("h2", {}, t("reduce_title")), el("p", {}, t("reduce_about")), frozen ? null : chooser(app));
}

function chooser(app) {
  const choice = el("select", { "aria-label": t("structure") }, app.state.structures.map((name) => el("option", { value: name, selected: name === "abkowitz3" }, name)));
  return el("p", { class: "head" }, choice, el("button", { class: "primary", disabled: app.busy(), on: { click: () => app.act("reduce", { structure: choice.value, ...app.mine() }) } }, t("reduce")));
}

function grid(found, choose) {
  return el("table", { class: "plain" },
    el("thead", {}, el("tr", {}, el("th", { scope: "col" }, found.factor > 1 ? "× 10³" : ""), found.speeds.map((speed) => el("th", { scope: "col" }, speed)), found.reference ? el("th", { scope: "col" }, t("published")) : null)),
    CHANNELS.map((channel) => {
      const rows = found.rows.filter((row) => row.name.startsWith(channel));
      return rows.length ? el("tbody", {}, rows.map((row) => el("tr", { "data-name": row.name, "aria-selected": "false" },
        el("th", { scope: "row" }, el("button", { class: "link", on: { click: () => choose(row) } }, row.name)),
        row.values.map((item) => el("td", {}, (item.told ?? "–").replaceAll("-", "−"))),
        found.reference ? el("td", { class: "soft" }, published(row.published, found.factor)) : null))) : null;
    }));
}

function published(values, factor) {
  const ends = [values[0], values.at(-1)].map((value) => num(factor * value, 4));
  return !values.length ? "" : ends[0] === ends[1] ? ends[0] : ends.join(" … ");
}

function drawDetail(root, found, row) {
  // An empty panel leaves its room to the table: the plot is measured beside its title.
  refill(root, el("h2", {}, row.name));
  root.append(
    forest(root, found, row),
    el("div", { class: "pair" },
      el("div", {}, el("h3", {}, t("determined_by")), row.runs.length
        ? el("table", { class: "plain" }, el("tbody", {}, row.runs.map((item) => el("tr", {}, el("th", { scope: "row" }, item.run), el("td", {}, `${item.share > 0 ? "+" : ""}${num(item.share, 2)}`)))))
        : el("p", { class: "soft small" }, "–"), el("p", { class: "soft small" }, t("determined_about"))),
      el("div", {}, el("h3", {}, t("trades")), row.trades.length
        ? el("table", { class: "plain" }, el("tbody", {}, row.trades.map((item) => el("tr", {}, el("th", { scope: "row" }, item.name), el("td", {}, num(item.correlation, 2))))))
        : el("p", { class: "soft small" }, t("trades_none")))));
}

// By speed: all tests together, then each family alone, with 95 % intervals.
function forest(detail, found, row) {
  const lines = found.speeds.flatMap((speed, k) => [
    { title: speed, own: row.values[k], first: true, published: row.published[k] ?? row.published[0] },
    ...row.families.filter((family) => family.values[k]).map((family) => ({ title: titleOf(family.title), own: family.values[k] })),
  ]).filter((line) => line.own && line.own.value !== null);
  if (!lines.length) return el("p", { class: "soft" }, "–");
  const main = lines.filter((line) => line.first);
  const spread = Math.max(...main.map((line) => (line.own.high - line.own.low) || Math.abs(line.own.value) * 0.1));
  const low = Math.min(...main.map((line) => line.own.value)) - 3 * spread;
  const high = Math.max(...main.map((line) => line.own.value)) + 3 * spread;
  const [left, width, height] = [150, roomOf(detail), 24];
  const at = (value) => left + ((Math.min(Math.max(value, low), high) - low) / (high - low)) * (width - left - 20);
  const root = svg("svg", { viewBox: `0 0 ${width} ${height * lines.length + 26}`, role: "img", "aria-label": t("forest", { name: row.name }) });
  lines.forEach((line, i) => {
    const y = height * i + 14;
    const kind = line.first ? "model" : "measured";
    root.append(
      svg("text", { class: line.first ? "ink" : "", x: left - 12, y: y + 4, "text-anchor": "end" }, line.title),
      svg("line", { class: kind, x1: at(line.own.low ?? line.own.value), x2: at(line.own.high ?? line.own.value), y1: y, y2: y }),
      svg("circle", { class: `mark ${kind}`, cx: at(line.own.value), cy: y, r: line.first ? 4 : 3 }),
    );
    if (line.first && line.published !== undefined && line.published !== null) {
      root.append(svg("path", { class: "overlay", d: `M${at(line.published) - 4} ${y - 4}l8 8m0 -8l-8 8` }));
    }
  });
  const base = height * lines.length + 20;
  for (const value of ticks(found.factor * low, found.factor * high, 4)) root.append(svg("text", { x: at(value / found.factor), y: base, "text-anchor": "middle" }, num(value, 4)));
  return el("div", { class: "plot" }, el("h3", {}, t("forest_about")), root);
}
