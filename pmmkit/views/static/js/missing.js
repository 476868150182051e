// Place 4: what is missing. Candidates, what each would do, and how the error falls.

import { el, refill, svg } from "./dom.js";
import { t, titleOf } from "./words.js";
import { fixed, num, unitOf } from "./format.js";
import { recordPlots } from "./recordplots.js";
import { roomOf } from "./linear.js";
import { legend, runPlots } from "./runplots.js";
import { turnPanel } from "./sailed.js";
import { frozen } from "./api.js";
import { ownPanel } from "./own.js";
import { coveragePanel } from "./coverage.js";
import { chosenCell } from "./where.js";

export async function showMissing(root, app, shown) {
  const [asked, fall] = await Promise.all([app.missing(), app.fall()]);
  const found = asked?.drawn ? overOne(asked, asked.drawn[app.of]) : asked;
  // What is pointed at before the run is there is drawn when it comes.
  const view = { asked: app.pair, show: () => {}, draw: (asked) => { view.asked = asked; view.show(asked); } };
  const right = el("div", { class: "stack keeps" });
  const left = el("div", { class: "stack" });
  refill(root, el("div", { class: "two" }, left, right));
  const fresh = found?.since === 0;
  refill(left, fresh ? null : question(app, found), found?.candidates.length ? answer(found, app, view) : null, found ? rivals(found) : null, found ? hidden(found) : null, ownPanel(app, found));
  const turns = el("section", { class: "panel", "aria-label": t("turn") });
  const run = el("section", { class: "panel", "aria-label": t("selected_run") }, el("p", { class: "soft" }, t("computing")));
  refill(right, run, turns);
  shown();
  const room = roomOf(run);
  right.prepend(...(fall ? fall.campaigns ?? [fall] : []).map((own) => waterfall(own, room)));
  if (found?.covered?.length) right.append(coveragePanel(found.covered, room));
  view.show = await runView(run, app, fresh ? found : null);
  view.show(view.asked);
  // The turn of a page that asks about no model that sails is of another one.
  if (app.state.model) await turnPanel(turns, app);
  else turns.remove();
}

// Of several campaigns: what candidates would do to the runs of the one that is looked at.
function overOne(found, { shares, overlays, base }) {
  const candidates = found.candidates.map((item) => ({ ...item, share: shares[item.effect] ?? null }));
  return { ...found, overlays, base, candidates };
}

function question(app, before) {
  const running = app.running("diagnose");
  return el("section", { class: "panel" },
    el("h2", {}, t(before ? "ask_again_title" : "ask_title")),
    el("p", {}, t(before?.candidates.length ? "ask_again_about" : "ask_about")),
    frozen ? null : el("button", { class: before?.candidates.length ? "" : "primary", disabled: app.busy(), on: { click: () => app.act("diagnose") } }, running ? t("asking") : t(before ? "ask_again" : "ask")));
}

function answer(found, app, view) {
  const drawn = Object.keys(found.overlays).length > 0;
  return el("section", { class: "panel", "aria-label": t("candidates") },
    el("div", { class: "head" }, el("h2", {}, t(found.since ? "asked_before" : "candidates")), found.since || !drawn ? null : el("span", { class: "soft small hint" }, t("hover_hint"))),
    el("p", {}, found.sentence),
    found.formula ? found.formula.remarks.map((text) => el("p", { class: "small" }, text)) : null,
    found.remarks.length ? el("details", {}, el("summary", {}, t("remarks")), found.remarks.map((text) => el("p", { class: "soft small" }, text))) : null,
    el("ol", { class: "candidates" }, found.candidates.map((item) => candidate(item, app, view, drawn))));
}

function candidate(item, app, view, drawn) {
  const preview = () => view.draw([item.effect]);
  const leave = () => view.draw(app.pair);
  const name = el("button", { class: "link", title: t("show_effect", { effect: titleOf(item.effect) }), on: { focus: preview, click: preview } }, titleOf(item.effect));
  const tick = item.share && drawn ? el("input", {
    type: "checkbox", checked: app.pair.includes(item.effect), "aria-label": t("compare_effect", { effect: titleOf(item.effect) }), value: item.effect,
    on: { change: (event) => pairUp(event.target, app, view) },
  }) : null;
  return el("li", { on: { mouseenter: preview, mouseleave: leave } },
    el("span", { class: "name" }, name,
      item.named ? el("span", { class: "tag named" }, t("named")) : null,
      item.kind === "fault" ? el("span", { class: "tag fault" }, item.campaign ? t("of_campaign", { campaign: item.campaign }) : t("fault")) : null),
    frozen || !item.offered ? null : el("button", { class: item.named ? "primary" : "", disabled: app.busy(), "aria-label": t(item.kind === "fault" ? "correct_effect" : "add_effect", { effect: titleOf(item.effect) }), on: { click: () => app.act("add", { effect: item.effect, campaign: item.campaign ?? "" }) } },
      item.kind === "fault" ? t("correct") : t("add")),
    el("p", { class: "summary" }, item.summary, item.kind === "fault" ? ` ${t("fault_about")}` : ""),
    item.share ? meter(t("takes_away"), item.share) : null,
    el("p", { class: "summary" }, `${t(item.votes?.length > 1 ? "all_together" : "evidence")}: `, el("b", {}, t(`weight_${item.weight.replaceAll(" ", "_")}`)), item.reason ? ` · ${item.reason}` : ` (${item.evidence})`),
    item.votes?.length > 1 ? item.votes.map((vote) => el("p", { class: "summary" }, `${vote.campaign}: ${vote.evidence}`)) : null,
    item.said ? el("p", { class: "summary" }, item.said) : null,
    item.share ? el("p", { class: "summary number" }, Object.entries(item.share.channels).map(([channel, share]) => `${t(`channel_${channel}`)} ${percent(share)}`).join(" · ")) : null,
    item.lost ? el("p", { class: "summary" }, t("lost_motion")) : null,
    item.rivals.length ? el("p", { class: "summary" }, t("resembles", { names: item.rivals.map(titleOf).join(", ") })) : null,
    item.test ? el("p", { class: "summary" }, t("to_be_sure", { test: item.test })) : null,
    item.coefficients.length ? coefficients(item.coefficients) : null,
    tick ? el("label", { class: "summary tick" }, tick, t("compare")) : null);
}

// Two at most stand beside each other: a third takes the place of the first.
function pairUp(box, app, view) {
  const others = app.pair.filter((effect) => effect !== box.value);
  app.pair = box.checked ? [...others, box.value].slice(-2) : others;
  for (const own of box.closest("ol").querySelectorAll("input[type=checkbox]")) own.checked = app.pair.includes(own.value);
  view.draw(app.pair);
}

function beside(items) {
  if (items.length < 2) return null;
  const row = (title, give) => el("tr", {}, el("th", { scope: "row" }, title), items.map((item) => el("td", {}, give(item))));
  return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": t("side_by_side") },
    el("table", { class: "plain beside" },
      el("thead", {}, el("tr", {}, el("th", {}, el("span", { class: "sr" }, t("measure"))), items.map((item) => el("th", { scope: "col" }, titleOf(item.effect))))),
      el("tbody", {},
        row(t("takes_away"), (item) => percent(item.share.all)),
        Object.keys(items[0].share.channels).map((channel) => row(t(`channel_${channel}`), (item) => percent(item.share.channels[channel]))),
        row(t("evidence"), (item) => item.evidence),
        row(t("separating_test"), (item) => item.test || "–"))));
}

function percent(share) {
  return `${fixed(100 * Math.max(share, -9.99), 0)} %`;
}

// The share of the misfit that goes, with a mark where noise alone is left.
function meter(label, { all, noise }) {
  const at = (share) => `${100 * Math.min(Math.max(share ?? 0, 0), 1)}%`;
  const level = noise === null || noise <= 0 ? null : el("div", { class: "level", css: { left: at(noise) }, title: t("noise_level", { level: percent(noise) }) });
  return el("div", { class: "meter" }, el("span", {}, label),
    el("div", { class: "track" }, el("div", { class: "fill", css: { width: at(all) } }), level), el("b", {}, percent(all)));
}

function coefficients(rows) {
  return el("details", { class: "summary" }, el("summary", {}, t("coefficients")),
    el("table", { class: "plain" },
      el("thead", {}, el("tr", {}, [t("coefficient"), t("value"), "± 95 %", t("usual")].map((text) => el("th", { scope: "col" }, text)))),
      el("tbody", {}, rows.map((row) => el("tr", {}, el("th", { scope: "row" }, row.name), el("td", {}, num(row.value)), el("td", {}, num(row.half, 2)), el("td", {}, num(row.typical, 2)))))));
}

function rivals(found) {
  if (found.sets.length < 2 && !found.suspected.length) return null;
  return el("section", { class: "panel" }, el("h2", {}, t("rivals")),
    el("ul", { class: "sentences" },
      found.sets.slice(1).map((set) => el("li", {}, `${set.effects.map(titleOf).join(" + ")}: ${set.odds > 0.7 ? t("as_likely") : t("odds_against", { odds: num(1 / set.odds, 2) })}`)),
      found.suspected.map((item) => el("li", {}, t(item.agrees ? "carried" : "suspected", { effect: titleOf(item.effect), run: item.run })))));
}

function hidden(found) {
  if (!found.hidden.length && !found.untold.length) return null;
  return el("section", { class: "panel" },
    found.hidden.length ? el("details", {}, el("summary", {}, t("hidden", { count: found.hidden.length })),
      el("ul", { class: "sentences calm" }, found.hidden.map((item) => el("li", {}, el("b", {}, titleOf(item.effect)), `: ${item.why}`,
        item.size === null ? "" : `; ${t("could_hide", { size: num(item.size, 2) })}`)))) : null,
    found.untold.length ? el("details", {}, el("summary", {}, t("untold", { count: found.untold.length })),
      el("ul", { class: "sentences calm" }, found.untold.map((text) => el("li", {}, text)))) : null);
}

// The run that is looked at, with the candidate under the pointer drawn over it.
async function runView(root, app, found) {
  const misfit = await app.misfit();
  const chosen = misfit && chosenCell(app, misfit);
  const history = chosen && await app.history(chosen.run);
  if (!history) {
    root.remove();
    return () => {};
  }
  app.selected = chosen;
  const { run, channel } = chosen;
  const base = found?.base?.[run];
  const plots = el("div");
  const keys = el("div", { "aria-live": "polite" });
  refill(root,
    el("div", { class: "head" }, el("h2", {}, `${t(`channel_${channel}`)} · ${history.title}, ${history.words}`),
      el("a", { class: "small right", href: "#where" }, t("another_run"))),
    keys, plots);
  let shown;
  const draw = (asked) => {
    const items = asked.map((effect) => found?.candidates.find((item) => item.effect === effect)).filter((item) => item?.share);
    const effects = items.map((item) => item.effect);
    if (effects.join() === shown) return;
    shown = effects.join();
    refill(keys, legend(effects.map(titleOf), base ? "base_fitted" : "model"), beside(items));
    const overlays = effects.map((effect) => found.overlays[effect]);
    if (history.kind === "free") recordPlots(plots, history, { base, overlays: overlays.map((own) => own[run]) });
    else runPlots(plots, history, channel, { overlays, compact: true });
  };
  return draw;
}

function waterfall(fall, width) {
  const steps = fall.steps;
  const most = Math.max(...steps.map((step) => step.error));
  const unit = fall.unit === "deg" ? "°" : ` ${fall.unit}`;
  const [left, right, row, top] = [width < 500 ? 135 : 190, 70, 34, 8];
  const height = top + row * steps.length + 22;
  const at = (x) => left + (x / most) * (width - left - right);
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": t("fall") });
  steps.forEach((step, i) => {
    const y = top + row * i;
    root.append(
      svg("text", { class: i ? "" : "ink", x: left - 8, y: y + 20, "text-anchor": "end" }, i ? `+ ${titleOf(step.step)}` : t("base")),
      svg("rect", { class: i ? "bar" : "bar first", x: left, y: y + 6, height: 19, width: Math.max(at(step.error) - left, 1.5), rx: 2 }),
      svg("text", { class: "ink", x: at(step.error) + 6, y: y + 20 }, `${num(step.error)}${unit}`),
    );
  });
  const level = steps.at(-1).level;
  if (level !== null) {
    root.append(
      svg("line", { class: "level", x1: at(level), x2: at(level), y1: top, y2: height - 20 }),
      svg("text", { x: at(level), y: height - 5, "text-anchor": "middle" }, t("noise_level", { level: `${num(level)}${unit}` })),
    );
  }
  const channels = Object.keys(steps[0].channels);
  return el("section", { class: "panel", "aria-label": t("fall") },
    el("div", { class: "head" }, el("h2", {}, fall.title ? `${t("fall")} · ${fall.title}` : t("fall")), el("span", { class: "soft small" }, t(`fall_about_${fall.of}`))),
    el("div", { class: "plot" }, root),
    el("details", {}, el("summary", {}, t("by_channel")),
      el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": t("by_channel") }, el("table", { class: "plain" },
        el("thead", {}, el("tr", {}, el("th", { scope: "col" }, t("after")), channels.map((name) => el("th", { scope: "col" }, `${t(`channel_${name}`)} [${unitOf(steps[0].channels[name].unit)}]`)))),
        el("tbody", {}, steps.map((step) => el("tr", {}, el("th", { scope: "row" }, titleOf(step.step)), channels.map((name) => el("td", {}, num(step.channels[name].error)))))))),
      el("p", { class: "soft small" }, fall.how), fall.remarks.map((text) => el("p", { class: "soft small" }, text))));
}

