// Files of one layout: their channels, each with a picture, and what it is, to be chosen.

import { el } from "./dom.js";
import { t } from "./words.js";
import { num, unitOf } from "./format.js";
import { picture } from "./spark.js";
import { choose } from "./choose.js";

export function layouts(draw, own, page) {
  const others = Object.entries(page.others);
  return el("section", { class: "panel", "aria-label": t("files") },
    el("div", { class: "head" }, el("h2", {}, t("files")), el("span", { class: "soft small" }, page.new ? t("files_about") : t("files_stated"))),
    page.problems.map((text) => el("p", { class: "finding warning" }, text)),
    page.passed_over ? el("p", { class: "finding warning" }, t("passed_over", { count: page.passed_over })) : null,
    page.campaigns.map((item) => el("p", {}, el("b", {}, item.file), ` ${item.problem || item.title}`)),
    page.groups.map((group) => layout(draw, own, page, group)),
    others.length ? el("p", { class: "soft small" }, t("other_files", { list: others.map(([suffix, count]) => `${count} ${suffix}`).join(", ") })) : null);
}

function layout(draw, own, page, group) {
  const more = group.files.slice(1);
  return el("article", { class: "layout stack", css: { gap: ".5rem" } },
    el("div", {}, el("h3", { class: "ink" }, group.file, more.length ? el("span", { class: "soft" }, ` ${t("alike", { count: group.count - 1 })}`) : null),
      el("p", { class: "soft small" }, `${group.words}. ${group.clock}`)),
    group.apart ? el("p", { class: "finding" }, t("columns_apart")) : null,
    more.length ? el("details", { class: "small" }, el("summary", {}, t("all_files", { count: group.count })), el("p", { class: "wrap" }, group.files.join(", "), group.count > group.files.length ? " …" : "")) : null,
    el("div", { class: "channels", role: "table", "aria-label": group.file },
      el("div", { class: "channel headings", role: "row" }, ["channel", "picture", "is", "unit", "sign", "why"].map((key) => el("span", { role: "columnheader" }, t(`head_${key}`)))),
      group.columns.map((column) => channel(draw, own, page, group, column))),
    group.more_columns ? el("p", { class: "soft small" }, t("more_columns", { count: group.more_columns })) : null);
}

function channel(draw, own, page, group, column) {
  const names = group.kind === "table" ? { ...page.vocabulary.table, ...page.vocabulary.history } : page.vocabulary.history;
  const key = `${group.file} ${column.column}`;
  const chosen = own.choices.find((x) => x.file === group.file && x.column === column.column);
  const name = column.name;
  const say = (change) => choose(draw, { file: group.file, column: column.column, name, unit: column.chosen_unit || null, sign: chosen?.sign ?? null, ...change });
  const what = select(group.apart, `is ${key}`, t("is_what", { name: column.label }), [["", t("not_used")], ...Object.keys(names).map((own) => [own, meant(own)])], name,
    (value) => say({ name: value, unit: null, sign: null }));
  const units = name ? [...new Set([column.unit, column.chosen_unit, ...(names[name] ?? [])])].filter(Boolean) : [];
  const unit = units.length ? select(group.apart, `unit ${key}`, t("unit_of", { name: column.label }), units.map((own) => [own, unitOf(own) || own]), column.chosen_unit || column.unit || names[name]?.[0], (value) => say({ unit: value === column.unit ? null : value })) : el("span", {});
  const sign = name && name !== "t" ? select(group.apart, `sign ${key}`, t("sign_of", { name: column.label }), [["1", t("sign_plus")], ["-1", t("sign_minus")]], String(column.sign), (value) => say({ sign: Number(value) })) : el("span", {});
  return el("div", { class: `channel${name ? "" : " unused"}`, role: "row" },
    el("span", { role: "cell", class: "title" }, el("b", {}, column.label), column.unit ? el("span", { class: "soft" }, ` [${column.unit}]`) : null,
      el("small", { class: "soft" }, column.numbers ? ` ${num(column.low)} … ${num(column.high)}` : ` ${t("no_numbers")}`)),
    el("span", { role: "cell" }, column.values.length ? picture({ name: column.label, unit: column.unit, ...column }, { span: (column.t.at(-1) ?? 1) - column.t[0], begin: column.t[0] }) : null),
    el("span", { role: "cell" }, what), el("span", { role: "cell" }, unit), el("span", { role: "cell" }, sign),
    el("span", { role: "cell", class: "soft small why" }, name ? column.reason : column.perhaps ? t("perhaps", { name: column.perhaps, why: column.reason }) : column.remark));
}

function meant(name) {
  const word = t(`name_${name}`);
  return word === `name_${name}` ? name : `${name} · ${word}`;
}

function select(fixed, name, label, options, value, act) {
  const node = el("select", { name, "aria-label": label, on: { change: () => act(node.value) } },
    options.map(([own, text]) => el("option", { value: own, selected: own === value }, text)));
  node.disabled = fixed;
  return node;
}
