// What a place tells in sentences, tables and figures, beside what it draws.

import { el } from "./dom.js";
import { t } from "./words.js";

// The first panel holds the largest numbers; `before` stands above what is drawn.
export function toldBefore(told) {
  if (!told) return [];
  const facts = told.facts.length
    ? el("dl", { class: "facts panel" }, told.facts.map((fact) => el("div", {}, el("dt", {}, fact.name), el("dd", {}, fact.value)))) : null;
  return [facts, ...told.before.map(panel)].filter((own) => own);
}

export function toldAfter(told) {
  if (!told) return [];
  const folded = told.folded.length
    ? el("section", { class: "panel", "aria-label": t("as_told") },
      el("details", {}, el("summary", {}, t("as_told")), el("div", { class: "stack" }, told.folded.map((own) => el("div", { class: "told" }, content(own)))))) : null;
  return [...told.after.map(panel), folded].filter((own) => own);
}

function panel(section) {
  return el("section", { class: "panel told", "aria-label": section.title || null }, content(section));
}

function content(section) {
  return [
    section.title ? el("h2", {}, section.title) : null,
    section.paragraphs.map((text) => el("p", { class: "prose" }, text)),
    section.points.length ? el("ul", { class: "prose points" }, section.points.map((text) => el("li", {}, text))) : null,
    section.findings.map(finding),
    section.tables.map((own) => table(own, section.title)),
    section.figures.map(picture),
  ].flat();
}

function finding(item) {
  return el("div", { class: `finding ${item.severity}` },
    el("p", {}, el("b", {}, item.severity), ` ${item.check}`), el("p", {}, item.message),
    item.runs ? el("p", { class: "soft small" }, item.runs) : null,
    item.remedy ? el("p", { class: "soft small" }, item.remedy) : null);
}

function table(own, title) {
  const wide = Math.max(own.head.length, ...own.groups.flatMap((group) => group.rows.map((row) => row.length)));
  const side = (i) => (own.texts.includes(i) ? "text" : null);
  const line = (row) => el("tr", {}, row.map((cell, i) => el(i ? "td" : "th", { class: side(i), scope: i ? null : "row" }, cellOf(cell))));
  return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": own.caption || title || t("value") },
    own.caption ? el("p", { class: "soft small" }, own.caption) : null,
    el("table", { class: "plain" },
      own.head.some((name) => name) ? el("thead", {}, el("tr", {}, own.head.map((name, i) => el(name ? "th" : "td", { class: side(i), scope: name ? "col" : null }, cellOf(name))))) : null,
      own.groups.map((group) => el("tbody", {},
        group.title ? el("tr", { class: "group" }, el("th", { colspan: wide, scope: "rowgroup" }, group.title)) : null,
        group.rows.map(line)))));
}

function cellOf(cell) {
  if (cell === null) return "–";
  return typeof cell === "string" ? cell : el("i", { class: "symbol" }, cell.letter, el("sub", {}, cell.below));
}

// A picture is shown as an image: nothing inside it can run or load.
function picture(own) {
  const caption = el("figcaption", { class: "soft small" }, own.caption);
  if (!own.svg) return el("figure", {}, el("p", { class: "soft" }, t(own.file ? "picture_left_out_file" : "picture_left_out", { file: own.file })), caption);
  const address = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(own.svg)}`;
  return el("figure", { class: own.narrow ? "narrow" : null }, el("img", { src: address, alt: own.alt }), caption);
}
