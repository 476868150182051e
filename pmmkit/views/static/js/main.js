// The page: places, the state, long work, keys.

import { el, refill } from "./dom.js";
import { begin } from "./begin.js";
import { frozen, get, post, wordsOf } from "./api.js";
import { LANGUAGES, language, setTitles, setWords, t, titleOf } from "./words.js";
import { num } from "./format.js";
import { showData } from "./data.js";
import { showDerivatives } from "./derivatives.js";
import { showWhere } from "./where.js";
import { showMissing } from "./missing.js";
import { showShip } from "./ship.js";
import { toldAfter, toldBefore } from "./sections.js";
import { printAll } from "./print.js";

const PLACES = { data: showData, derivatives: showDerivatives, where: showWhere, missing: showMissing, ship: showShip };
const EVERY = 250;

const page = document.getElementById("page");
const parts = { header: el("header"), nav: el("nav", { "aria-label": "pmmkit" }), main: el("main", { tabindex: -1 }), rail: el("footer", { class: "rail" }) };

const app = {
  state: null,
  selected: null,
  marked: null,
  pair: [],
  intake: null,
  draft: null,
  count: null,
  of: 0,
  known: new Map(),
  problem: "",
  now: () => app.count ?? app.state.steps.length,
  once(key, work) {
    if (!app.known.has(key)) {
      app.known.set(key, work().catch((problem) => {
        app.known.delete(key);
        throw problem;
      }));
    }
    return app.known.get(key);
  },
  // Of several campaigns the one that is looked at; of the first is asked as if there were one.
  tests: () => app.state.campaigns?.[app.of] ?? app.state,
  mine: () => (app.of ? { of: app.of } : {}),
  misfit: () => app.once(`misfit ${app.of} ${app.now()}`, () => get("misfit", { count: app.now(), ...app.mine() })),
  history: (run) => app.once(`run ${app.of} ${app.now()} ${run}`, () => get("run", { run, count: app.now(), ...app.mine() })),
  missing: () => app.once("missing", () => get("missing")),
  fall: () => app.once("fall", () => get("fall")),
  turns: () => app.once("turns", () => get("turns")),
  trials: () => app.once("trials", () => get("trials")),
  range: () => app.once("range", () => get("range")),
  // What an action is asked, by name: what its command line and its help are made of.
  settings: (of) => app.once(`settings ${of}`, async () => Object.fromEntries((await get("settings", { of })).map((item) => [item.name, item]))),
  checks: () => app.once(`checks ${app.of}`, () => get("checks", app.mine())),
  runs: (first) => app.once(`runs ${app.of} ${first}`, () => get("runs", { first, ...app.mine() })),
  derivatives: () => app.once(`derivatives ${app.of}`, () => get("derivatives", app.mine())),
  places: () => Object.keys(app.state.places ?? PLACES),
  about: () => (app.state.runs ? t(app.state.model ? "about" : "about_tests", { runs: app.state.runs, model: app.state.model }) : ""),
  told: (name) => (frozen ? get(`told ${name}`) : null),
  draws: (name) => app.state.places?.[name] ?? true,
  busy: () => app.state.job.stand === "running",
  running: (name) => app.busy() && app.state.job.name === name,
  redraw: () => drawPlace(),
  refresh: () => refresh(),
  async act(what, more = {}) {
    app.problem = "";
    try {
      await post(what, { revision: app.state.revision, ...more });
    } catch (problem) {
      app.problem = problem.message;
    }
    await refresh();
  },
};

async function refresh() {
  const before = app.state;
  app.state = await get("state");
  setTitles(app.state.titles);
  const job = app.state.job;
  const changed = !before || before.revision !== app.state.revision || before.opened !== app.state.opened
    || (before.job.stand === "running" && job.stand !== "running");
  if (changed) {
    app.known.clear();
    app.count = null;
    if (app.of >= (app.state.campaigns?.length ?? 1)) app.of = 0;
  }
  if (job.stand === "failed" && before?.job.stand === "running") app.problem = job.text;
  drawFrame();
  if (changed || app.problem || before?.job.stand !== job.stand) await drawPlace();
  if (job.stand === "running") setTimeout(() => refresh().catch(lost), EVERY);
}

function lost() {
  app.problem = t("lost");
  refill(parts.main, message());
  setTimeout(() => refresh().catch(lost), 8 * EVERY);
}

function place() {
  const name = location.hash.slice(1);
  const there = app.places();
  return [name, "where", "derivatives", "missing"].find((own) => there.includes(own)) ?? there[0];
}

function drawFrame() {
  const state = app.state;
  refill(parts.header,
    el("span", { class: "brand" }, "pmmkit"),
    el("h1", {}, state.opened ? state.title : t("workbench")),
    state.opened ? el("span", { class: "about" }, app.about()) : null,
    state.opened && state.campaigns?.length > 1 ? campaignChoice(state.campaigns) : null,
    el("div", { class: "tools" }, languageChoice(), themeChoice(),
      frozen || !state.opened ? null : el("a", { class: "button", href: "api/frozen", download: "workbench.html" }, t("save_file"))));
  refill(parts.nav, state.opened ? el("ul", {}, app.places().map((name, i) =>
    el("li", {}, el("a", { href: `#${name}`, "aria-current": place() === name ? "page" : null }, el("kbd", { "aria-hidden": "true" }, i + 1), t(`place_${name}`))))) : "");
  parts.nav.classList.toggle("hidden", !state.opened);
  drawRail(state);
}

function drawRail(state) {
  const steps = state.steps ?? [];
  const empty = state.opened ? frozen && !steps.length && !state.commands.length : state.job.stand !== "running";
  parts.rail.classList.toggle("hidden", empty);
  refill(parts.rail,
    el("ol", { "aria-label": t("steps"), tabindex: 0 },
      el("li", { class: steps.length ? "" : "last" }, t("base")),
      steps.map((step, i) => el("li", { class: i === steps.length - 1 ? "last" : "", title: step.note }, step.campaign ? t("fault_of", { effect: titleOf(step.effect), campaign: step.campaign }) : titleOf(step.effect)))),
    steps.length && !frozen ? el("button", { disabled: app.busy(), on: { click: () => app.act("undo") } }, t("undo")) : null,
    state.commands?.length ? el("button", { on: { click: showCommands } }, t("commands")) : null,
    jobBar(state.job));
}

function jobBar(job) {
  if (job.stand !== "running") return null;
  const what = job.text || t(`job_${job.name}`);
  const left = job.left === null ? "" : ` · ${t("left", { seconds: num(job.left, 2) })}`;
  return el("div", { class: "job", role: "status" },
    el("span", {}, `${what} · ${num(job.seconds, 2)} s${left}`),
    job.total ? el("progress", { max: job.total, value: job.done, "aria-label": what }) : el("progress", { "aria-label": what }),
    el("button", { on: { click: () => app.act("cancel") } }, t("cancel")));
}

function showCommands() {
  const dialog = el("dialog", { "aria-label": t("commands") },
    el("div", { class: "stack" },
      el("div", { class: "head" }, el("h2", {}, t("commands")), el("span", { class: "soft small" }, t("commands_about"))),
      el("ol", { class: "commands" }, app.state.commands.map((item) => el("li", {}, el("code", {}, item.line),
        el("button", { on: { click: () => navigator.clipboard.writeText(item.line) } }, t("copy"))))),
      el("div", {}, el("button", { class: "primary", on: { click: () => dialog.close() } }, t("close")))));
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

function message() {
  return app.problem ? el("p", { class: "message", role: "alert" }, app.problem) : null;
}

// What went wrong, what is damaged, and that something was worked out from an older file.
function messages() {
  const state = app.state;
  const old = state.outdated && !frozen && !app.running("again");
  return [message(), ...(state.faults ?? []).map((text) => el("p", { class: "message", role: "alert" }, text)),
    old ? el("div", { class: "message old", role: "status" }, el("p", {}, t("outdated")), el("button", { class: "primary", disabled: app.busy(), on: { click: () => app.act("again") } }, t("again"))) : null];
}

async function drawPlace() {
  const state = app.state;
  document.title = state.opened ? `${t(`place_${place()}`)} · ${state.title}` : t("workbench");
  if (!state.opened) return void refill(parts.main, ...messages(), begin(app));
  const root = el("div", { class: "stack" });
  const waiting = setTimeout(() => refill(root, el("p", { class: "soft", role: "status" }, t("computing"))), 150);
  const content = el("div", { class: "stack" });
  const asked = place();
  refill(parts.main, ...messages(), root);
  try {
    const told = await app.told(asked);
    const drawn = () => {
      clearTimeout(waiting);
      if (place() === asked) root.replaceWith(...toldBefore(told), content, ...toldAfter(told));
    };
    if (app.draws(asked)) await PLACES[asked](content, app, drawn);
    else drawn();
  } catch (problem) {
    refill(root, el("p", { class: "message", role: "alert" }, problem.message));
  } finally {
    clearTimeout(waiting);
  }
}

function kept(key, value) {
  try {
    if (value === undefined) return localStorage.getItem(`pmmkit ${key}`);
    localStorage.setItem(`pmmkit ${key}`, value);
  } catch {
    // A page opened from disk may have no storage: the choice lasts until it is closed.
  }
  return null;
}

function campaignChoice(campaigns) {
  const choice = el("select", {
    class: "campaign", "aria-label": t("looked_at"), title: t("looked_at"),
    on: { change: () => { app.of = Number(choice.value); app.selected = null; app.marked = null; drawPlace(); } },
  }, campaigns.map((own, i) => el("option", { value: i, selected: i === app.of }, own.title)));
  return choice;
}

function themeChoice() {
  const now = document.documentElement.dataset.theme ?? "";
  const next = { "": "dark", dark: "light", light: "" }[now];
  return el("button", {
    title: t("theme"),
    on: { click: () => { setTheme(next); drawFrame(); drawPlace(); } },
  }, t(`theme_${now || "auto"}`));
}

function setTheme(name) {
  if (name) document.documentElement.dataset.theme = name;
  else delete document.documentElement.dataset.theme;
  kept("theme", name);
}

function languageChoice() {
  const choice = el("select", {
    "aria-label": t("language"),
    on: { change: async () => { await useLanguage(choice.value); drawFrame(); await drawPlace(); } },
  }, Object.entries(LANGUAGES).map(([code, name]) => el("option", { value: code, lang: code, selected: code === language() }, name)));
  return choice;
}

async function useLanguage(code) {
  const [own, english] = await Promise.all([wordsOf(code), wordsOf("en")]);
  setWords(code, own, english);
  kept("language", code);
}

function keys(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || /INPUT|SELECT|TEXTAREA/.test(event.target.tagName)) return;
  const name = app.state?.opened && app.places()[Number(event.key) - 1];
  if (name) location.hash = name;
}

async function start() {
  setTheme(kept("theme") ?? "");
  await useLanguage(kept("language") ?? "en");
  page.replaceWith(parts.header, parts.nav, parts.main, parts.rail);
  addEventListener("hashchange", () => { app.problem = ""; drawFrame(); parts.main.focus({ preventScroll: true }); scrollTo(0, 0); drawPlace(); });
  addEventListener("keydown", keys);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawPlace());
  await refresh();
  if (frozen) printAll(app, PLACES);
}

start().catch((problem) => page.isConnected ? refill(page, el("p", { class: "message" }, problem.message)) : lost());
