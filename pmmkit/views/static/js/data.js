// Place 1: the tests as they were read, what was used of them, and what the checks say.

import { el, refill } from "./dom.js";
import { frozen } from "./api.js";
import { t } from "./words.js";
import { bytes, num, unitOf } from "./format.js";
import { picture } from "./spark.js";
import { openRecord } from "./record.js";
import { intake } from "./intake.js";

export async function showData(root, app, shown) {
  const findings = await app.checks();
  const cards = el("div", { class: "grid-runs" });
  const more = el("p", {});
  refill(root,
    el("section", { class: "panel", "aria-label": t("checks") }, el("h2", {}, t("checks")),
      findings?.length ? findings.map((item) => finding(item, app)) : el("p", { class: "soft" }, t("checks_calm"))),
    el("section", { class: "panel", "aria-label": t("tests") },
      el("div", { class: "head" }, el("h2", {}, t("tests")), el("span", { class: "soft small" }, t("window_about"))),
      cards, more),
    frozen ? null : beside(app),
    frozen ? null : files(app));
  shown();
  await append(cards, more, app, 0);
}

// Campaigns of one ship that are asked together; another one begins anew.
function beside(app) {
  const where = el("input", { type: "text", name: "beside", "aria-label": t("beside"), placeholder: t("folder_any"), spellcheck: "false" });
  const take = (event) => {
    event.preventDefault();
    if (where.value.trim()) app.act("beside", { campaign: where.value.trim() });
  };
  return el("section", { class: "panel", "aria-label": t("campaigns") },
    el("h2", {}, t("campaigns")),
    el("ul", { class: "plain-list" }, app.state.campaigns.map((own, of) => el("li", {}, el("b", {}, own.title), ` · ${t(`kind_${own.kind}`)} · ${t("about_tests", { runs: own.runs })} `,
      app.state.campaigns.length > 1 ? el("button", { "aria-label": t("take_off_campaign", { campaign: own.title }), disabled: app.busy(), on: { click: () => app.act("without", { of }) } }, t("take_off")) : null))),
    el("form", { class: "line", on: { submit: take } }, where, el("button", { disabled: app.busy() }, t("beside"))),
    el("p", { class: "soft small" }, t("beside_about")));
}

function files(app) {
  const inside = el("div", {});
  const about = el("details", { class: "panel", open: Boolean(app.intake && !app.intake.written), on: { toggle: () => { if (about.open && !inside.firstChild) refill(inside, intake(app)); } } },
    el("summary", {}, t("more_files")), inside);
  return about;
}

async function append(cards, more, app, first) {
  refill(more, el("span", { class: "soft", role: "status" }, t("computing")));
  let page = null;
  try {
    page = await app.runs(first);
  } catch (problem) {
    return void refill(more, el("span", { class: "message", role: "alert" }, problem.message));
  }
  if (!page) return void refill(more);
  const made = page.runs.map((run) => card(run, app));
  cards.append(...made);
  if (first && made.length) made[0].querySelector("button")?.focus();
  const next = first + page.runs.length;
  refill(more, next < page.total && page.runs.length
    ? el("button", { on: { click: () => append(cards, more, app, next) } }, t("more_runs", { shown: next, total: page.total })) : null,
  page.total ? null : el("span", {}, t("no_runs")),
  page.excluded.length ? el("details", {}, el("summary", {}, t("excluded", { count: page.excluded.length })),
    page.excluded.map((item) => el("p", { class: "small" }, el("b", {}, item.run), `: ${item.reason}`))) : null);
}

function finding(item, app) {
  return el("div", { class: `finding ${item.severity}` }, el("p", {}, item.message),
    item.remedy ? el("p", { class: "soft small" }, item.remedy) : null,
    item.runs?.length ? el("p", { class: "soft small" }, item.runs.slice(0, 8).flatMap((run, i) => [i ? ", " : "",
      frozen ? run : el("button", { class: "link", on: { click: () => openRecord(app, run) } }, run)]), item.runs.length > 8 ? " …" : "") : null);
}

function card(run, app) {
  const readable = run.kind === "history" && !run.error;
  const open = () => {
    app.selected = run.channels.length ? { run: run.run, channel: run.channels[0].name } : app.selected;
    location.hash = "where";
  };
  return el("article", { class: "card stack", css: { gap: ".35rem" } },
    el("div", {}, el("b", {}, run.title), el("div", { class: "small" }, run.words),
      el("button", { class: "link small", title: t("selected_run"), on: { click: open } }, run.run)),
    run.error ? el("p", { class: "finding error" }, run.error) : null,
    run.large ? el("p", { class: "small" }, t("large", { size: bytes(run.large) })) : null,
    run.findings.map((item) => el("p", { class: `finding small ${item.severity}` }, item.message)),
    run.channels.map((channel) => spark(channel, run)),
    run.channels.length && !run.window ? el("p", { class: "finding small warning" }, run.reason) : null,
    el("p", { class: "soft small" }, run.source, run.seconds ? ` · ${num(run.seconds)} s` : "", run.stated ? ` · ${t("window_stated", { reason: run.stated.reason })}` : ""),
    run.corrections.filter((text) => !run.stated || !text.endsWith(`: ${run.stated.reason}`)).map((text) => el("p", { class: "soft small" }, text)),
    readable && !frozen ? el("button", { class: "small-button", "aria-label": `${t("record")}: ${run.run}`, on: { click: () => openRecord(app, run.run) } }, run.large ? t("draw_it") : t("record")) : null);
}

function spark(channel, run) {
  return el("div", { class: "spark", title: `${num(channel.low)} … ${num(channel.high)} ${unitOf(channel.unit)}` },
    el("span", {}, `${channel.name} `, el("small", {}, unitOf(channel.unit))),
    picture(channel, { span: run.seconds, window: run.window, marks: run.marks }));
}
