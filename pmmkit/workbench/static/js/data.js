// Place 1: the tests as they were read, and what the checks say of them.

import { el, refill } from "./dom.js";
import { t } from "./words.js";

export async function showData(root, app, shown) {
  const findings = await app.checks();
  shown();
  refill(root, el("section", { class: "panel" }, el("h2", {}, t("checks")),
    findings?.length ? findings.map((item) => el("p", { class: `finding ${item.severity}` }, item.message)) : el("p", { class: "soft" }, t("checks_calm"))));
}
