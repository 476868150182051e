// What a campaign file still lacks, asked in a short form; what is wrong is said beside its field.

import { el, refill } from "./dom.js";
import { t } from "./words.js";

const PAUSE = 500;
const OPEN = ["needed", "answered"];

export function answersForm(draw, own, page) {
  const parts = new Map();
  const rest = el("div", {});
  const acts = el("div", { class: "stack", css: { gap: ".6rem" } });
  const text = el("pre", { class: "scroll small", tabindex: 0, "aria-label": t("drafted_text") });
  let pause = null;

  const ask = (item) => {
    const id = `answer ${item.name}`;
    const input = item.options.length
      ? el("select", { name: id, "aria-describedby": `${id} said` }, el("option", { value: "" }, item.guess ? `${item.guess} (${t("guessed")})` : "…"), item.options.map((own) => el("option", { value: own, selected: own === item.answer }, own)))
      : el("input", { type: "text", name: id, value: item.answer, placeholder: item.guess, "aria-describedby": `${id} said`, autocomplete: "off", spellcheck: "false", maxlength: 120 });
    input.setAttribute("aria-label", `${item.run ? `${item.run}: ` : ""}${labelOf(item)}`);
    const said = el("small", { id: `${id} said`, class: "said" });
    const again = (now) => {
      if (input.value) own.answers[item.name] = input.value;
      else delete own.answers[item.name];
      clearTimeout(pause);
      pause = setTimeout(() => draw.look({ answered: true }), now ? 0 : PAUSE);
    };
    input.addEventListener("input", () => again(false));
    parts.set(item.name, { input, said });
    return { input, said };
  };

  const single = page.fields.filter((item) => !item.run);
  const shown = (item) => OPEN.includes(item.state) || item.key === "ship.mass" || item.key === "ship.volume";
  const needed = single.filter((item) => shown(item) && item.key !== "ship.name");
  const others = single.filter((item) => !needed.includes(item) && item.key !== "ship.name");
  const row = (item) => {
    const { input, said } = ask(item);
    return el("label", { class: "ask" }, el("span", {}, labelOf(item)), input, said);
  };
  const fields = el("div", { class: "asks" }, page.new ? [title(draw, own), ship(draw, own)] : null, needed.map(row));
  const runs = runsTable(page.fields.filter((item) => item.run), ask, own, draw);
  const guessed = others.length ? el("details", {}, el("summary", {}, t("guessed_too", { count: others.length })), el("div", { class: "asks" }, others.map(row))) : null;

  const update = (now) => {
    for (const item of now.fields) {
      const part = parts.get(item.name);
      if (!part) continue;
      part.input.setAttribute("aria-invalid", item.error ? "true" : "false");
      const hint = item.state === "needed" ? t("needed") : item.state === "guessed" || item.state === "estimated" ? `${t("guessed")}: ${item.why}` : item.state === "off" && item.guess ? `${t("taken_as", { guess: item.guess })}: ${item.why}` : "";
      refill(part.said, item.error ? el("span", { class: "unmet" }, item.error) : hint);
    }
    refill(rest, now.faults.map((one) => el("p", { class: "finding error" }, one)));
    refill(text, now.text);
    refill(acts, actions(draw, own, now));
  };
  const root = el("section", { class: "panel", "aria-label": t("campaign_file") },
    el("div", { class: "head" }, el("h2", {}, t("campaign_file")), el("span", { class: "soft small" }, page.new ? t("campaign_about") : t("campaign_there"))),
    fields, runs, guessed, rest, acts,
    el("details", {}, el("summary", {}, t("drafted_text")), text));
  update(page);
  return { root, update };
}

function labelOf(item) {
  const word = t(`field_${item.key}`);
  return word === `field_${item.key}` ? `${item.key.split(".").at(-1)}: ${item.text}` : word;
}

function title(draw, own) {
  const input = el("input", { type: "text", name: "answer campaign.title", value: own.answers["campaign.title"] ?? "", placeholder: own.into || own.folder.split(/[\\/]/).at(-1), maxlength: 80, on: { input: () => { own.answers["campaign.title"] = input.value; } } });
  return el("label", { class: "ask" }, el("span", {}, t("title")), input, el("small", { class: "said" }));
}

function ship(draw, own) {
  const node = el("select", { name: "ship", on: { change: () => { own.ship = node.value; draw.look(); } } },
    el("option", { value: "" }, t("ship_own")), draw.app.state.ships.map((name) => el("option", { value: name, selected: name === own.ship }, name)));
  return el("label", { class: "ask" }, el("span", {}, t("ship")), node, el("small", { class: "said" }, own.ship ? t("ship_scale") : ""));
}

// Questions of single runs: a row a run, a column a question, and one line that answers for all.
function runsTable(fields, ask, own, draw) {
  if (!fields.length) return null;
  const keys = [...new Set(fields.map((item) => item.key))];
  const runs = [...new Set(fields.map((item) => item.run))];
  const of = new Map(fields.map((item) => [item.name, item]));
  const find = (run, key) => fields.find((item) => item.run === run && item.key === key);
  const all = (key) => {
    const first = fields.find((item) => item.key === key);
    const give = (value) => {
      for (const item of of.values()) if (item.key === key) own.answers[item.name] = value;
      draw.look();
    };
    const input = first.options.length
      ? el("select", { "aria-label": t("for_all", { key }), on: { change: () => give(input.value) } }, el("option", { value: "" }, t("for_all", { key: "" })), first.options.map((x) => el("option", { value: x }, x)))
      : el("input", { type: "text", "aria-label": t("for_all", { key }), placeholder: t("for_all", { key: "" }), on: { change: () => give(input.value) } });
    return input;
  };
  return el("div", { class: "scroll runs-asked", tabindex: 0, role: "region", "aria-label": t("of_runs") },
    el("table", { class: "plain" },
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, t("run")), keys.map((key) => el("th", { scope: "col" }, labelOf(fields.find((item) => item.key === key))))),
        runs.length > 1 ? el("tr", {}, el("td", {}), keys.map((key) => el("td", {}, all(key)))) : null),
      el("tbody", {}, runs.map((run) => el("tr", {}, el("th", { scope: "row" }, run), keys.map((key) => {
        const item = find(run, key);
        if (!item) return el("td", {});
        const { input, said } = ask(item);
        return el("td", {}, input, said);
      }))))));
}

function actions(draw, own, page) {
  const missing = page.fields.filter((item) => item.state === "needed").length;
  const wrong = page.fields.some((item) => item.error);
  const write = el("button", { class: page.complete && !page.changed ? "" : "primary", disabled: wrong || (!page.new && !page.changed), on: { click: () => draw.look({ write: true }) } }, page.new ? t("write_campaign") : t("change_campaign"));
  const base = el("select", { "aria-label": t("base_of"), name: "base", on: { change: () => { own.model = base.value; } } },
    el("option", { value: "" }, t("base_reduced")), el("optgroup", { label: t("structure") }, draw.app.state.structures.map((name) => el("option", { value: name, selected: name === own.model }, name))),
    el("optgroup", { label: t("ship") }, draw.app.state.ships.map((name) => el("option", { value: name, selected: name === own.model }, name))));
  const open = el("button", { class: "primary", disabled: !page.complete, on: { click: () => draw.app.act("open", { campaign: own.folder, model: own.model }) } }, t("open"));
  return [
    own.written ? el("p", { role: "status" }, el("span", { class: "met" }, "✓ "), t("written", { file: own.written })) : null,
    missing ? el("p", { class: "soft", role: "status" }, t("still_needed", { count: missing })) : null,
    el("div", { class: "line" }, page.new || page.changed ? write : null, page.new || page.changed ? null : [base, open]),
    page.new ? el("p", { class: "soft small" }, el("code", {}, `pmmkit new-campaign ${own.folder}`)) : null,
  ].filter(Boolean);
}
