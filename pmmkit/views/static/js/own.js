// An effect of one's own as text, checked while it is typed.

import { el, refill } from "./dom.js";
import { t } from "./words.js";
import { num } from "./format.js";
import { frozen, post } from "./api.js";

const PAUSE = 150;
const EXAMPLE = "Y: v*|v|*r; N: v*v*r";

export function ownPanel(app, found) {
  if (frozen) return null;
  const draft = app.draft ?? { name: "", text: "" };
  app.draft = draft;
  const said = el("div", { role: "status", id: "own-said" });
  const weigh = el("button", { disabled: true, on: { click: () => app.act("write", draft) } }, t("weigh"));
  const name = el("input", { type: "text", value: draft.name, "aria-label": t("own_name"), placeholder: t("own_name"), maxlength: 60, spellcheck: "false", autocomplete: "off" });
  const text = el("textarea", { rows: 3, "aria-label": t("own_terms"), "aria-describedby": "own-said", placeholder: EXAMPLE, maxlength: 2000, spellcheck: "false" }, draft.text);
  const tell = (valid, ...content) => {
    text.setAttribute("aria-invalid", valid === false ? "true" : "false");
    weigh.disabled = valid !== true || app.busy() || Boolean(app.state.own_error);
    refill(said, ...content);
  };
  let pause = null;
  let waiting = null;
  const check = async () => {
    waiting?.abort();
    waiting = new AbortController();
    if (!draft.text.trim()) return tell(null);
    const wrong = (message) => {
      const [head, ...place] = message.split("\n");
      tell(false, el("p", { class: "small" }, head), place.length ? el("pre", { class: "scroll small fault", tabindex: 0 }, place.map((line) => line.slice(4)).join("\n")) : null);
    };
    try {
      const found = await post("check", { name: draft.name || "mine", text: draft.text }, waiting.signal);
      if (found.error) wrong(found.error);
      else tell(draft.name ? true : null, coefficients(found.coefficients), draft.name ? null : el("p", { class: "soft small" }, t("own_nameless")));
    } catch (problem) {
      if (problem.name !== "AbortError") wrong(problem.message);
    }
  };
  const typed = () => {
    Object.assign(draft, { name: name.value.trim(), text: text.value });
    weigh.disabled = true;
    clearTimeout(pause);
    pause = setTimeout(check, PAUSE);
  };
  name.addEventListener("input", typed);
  text.addEventListener("input", typed);
  check();
  const again = (own) => el("button", { class: "link", title: own.text, on: { click: () => { Object.assign(draft, own); name.value = own.name; text.value = own.text; check(); text.focus(); } } }, own.name);
  return el("section", { class: "panel", "aria-label": t("own_effect") },
    el("h2", {}, t("own_effect")),
    el("p", { class: "soft small" }, t("own_about")),
    app.state.own_error ? el("div", { class: "message", role: "alert" }, el("p", {}, t("own_damaged")), el("pre", { class: "scroll small", tabindex: 0 }, app.state.own_error)) : null,
    el("div", { class: "own" }, name, text),
    said, weigh,
    found?.unasked?.length ? el("ul", { class: "sentences" }, found.unasked.map((item) => el("li", {}, t("own_unasked", { effect: item.effect, why: item.why })))) : null,
    found?.formula ? el("p", { class: "small" }, `${t("own_formula")}: `, found.formula.effects.flatMap((own, i) => [i ? ", " : "", again(own)])) : null,
    app.state.own.length ? el("p", { class: "small" }, `${t("own_kept")}: `, app.state.own.flatMap((own, i) => [i ? ", " : "", again(own)])) : null);
}

function coefficients(rows) {
  return el("p", { class: "small" }, el("span", { class: "met" }, "✓ "), t("own_understood"), " ",
    rows.map((row) => `${row.name} ≈ ${num(row.typical, 2)}`).join(", "));
}
