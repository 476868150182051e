// Place 1: the tests as they were read, what was used of them, and what the checks say.

import { el, refill, svg } from "./dom.js";
import { t } from "./words.js";
import { num, unitOf } from "./format.js";

export async function showData(root, app, shown) {
  const findings = await app.checks();
  const cards = el("div", { class: "grid-runs" });
  const more = el("p", {});
  refill(root,
    el("section", { class: "panel", "aria-label": t("checks") }, el("h2", {}, t("checks")),
      findings?.length ? findings.map(finding) : el("p", { class: "soft" }, t("checks_calm"))),
    el("section", { class: "panel", "aria-label": t("tests") },
      el("div", { class: "head" }, el("h2", {}, t("tests")), el("span", { class: "soft small" }, t("window_about"))),
      cards, more));
  shown();
  await append(cards, more, app, 0);
}

async function append(cards, more, app, first) {
  refill(more, el("span", { class: "soft", role: "status" }, t("computing")));
  const page = await app.runs(first);
  if (!page) return;
  cards.append(...page.runs.map((run) => card(run, app)));
  const next = first + page.runs.length;
  refill(more, next < page.total && page.runs.length
    ? el("button", { on: { click: () => append(cards, more, app, next) } }, t("more_runs", { shown: next, total: page.total })) : null,
  page.excluded.length ? el("details", {}, el("summary", {}, t("excluded", { count: page.excluded.length })),
    page.excluded.map((item) => el("p", { class: "small" }, el("b", {}, item.run), `: ${item.reason}`))) : null);
}

function finding(item) {
  return el("div", { class: `finding ${item.severity}` }, el("p", {}, item.message),
    item.remedy ? el("p", { class: "soft small" }, item.remedy) : null,
    item.runs?.length ? el("p", { class: "soft small" }, item.runs.slice(0, 8).join(", "), item.runs.length > 8 ? " …" : "") : null);
}

function card(run, app) {
  const open = () => {
    app.selected = run.channels.length ? { run: run.run, channel: run.channels[0].name } : app.selected;
    location.hash = "where";
  };
  return el("article", { class: "card stack", css: { gap: ".35rem" } },
    el("div", {}, el("b", {}, run.title), el("div", { class: "small" }, run.words),
      el("button", { class: "link small", title: t("selected_run"), on: { click: open } }, run.run)),
    run.error ? el("p", { class: "finding error" }, run.error) : null,
    run.findings.map((item) => el("p", { class: `finding small ${item.severity}` }, item.message)),
    run.channels.map((channel) => spark(channel, run)),
    el("p", { class: "soft small" }, run.source, run.seconds ? ` · ${num(run.seconds)} s` : ""),
    run.corrections.map((text) => el("p", { class: "soft small" }, text)));
}

function spark(channel, run) {
  const span = channel.high - channel.low || 1;
  const most = run.seconds || 1;
  const d = channel.values.map((value, i) => (value === null ? "" : `${i ? "L" : "M"}${((channel.t[i] / most) * 200).toFixed(1)} ${(24 - ((value - channel.low) / span) * 22).toFixed(1)}`)).join("");
  const picture = svg("svg", { viewBox: "0 0 200 26", preserveAspectRatio: "none", role: "img", "aria-label": `${channel.name} ${num(channel.low)} … ${num(channel.high)} ${unitOf(channel.unit)}` });
  if (run.window) {
    const at = run.window.map((x) => (x / most) * 200);
    picture.append(svg("rect", { x: at[0], y: 0, height: 26, width: Math.max(at[1] - at[0], 0) }));
  }
  picture.append(svg("path", { d: d.replace(/^L/, "M") }));
  return el("div", { class: "spark", title: `${num(channel.low)} … ${num(channel.high)} ${unitOf(channel.unit)}` },
    el("span", {}, `${channel.name} `, el("small", {}, unitOf(channel.unit))), picture);
}
