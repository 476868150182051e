// The page before anything is open: the demonstration, files that are dropped, a folder.

import { el } from "./dom.js";
import { t } from "./words.js";
import { intake } from "./intake.js";

export function begin(app) {
  const { state } = app;
  if (state.job.stand === "running") return el("section", { class: "panel begin" }, el("h2", {}, t("opening")), el("p", { class: "soft" }, state.job.text || t("job_open")));
  return el("div", { class: "stack begin-wide" },
    el("section", { class: "panel" },
      el("h2", {}, t("begin")),
      el("p", {}, t("begin_about")),
      el("p", {}, el("button", { class: "primary", on: { click: () => app.act("open", { campaign: state.demonstration }) } }, t("demonstration")))),
    intake(app));
}
