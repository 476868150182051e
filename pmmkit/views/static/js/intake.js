// Files that are dropped, or a folder: what they are, and the campaign file that is made of them.

import { el, refill } from "./dom.js";
import { t } from "./words.js";
import { get, post, send } from "./api.js";
import { layouts } from "./layouts.js";
import { answersForm } from "./answers.js";

const fresh = () => ({ folder: "", into: "", choices: [], answers: {}, ship: "", page: null, kept: [], refused: [], written: "", model: "" });

export function intake(app) {
  app.intake ??= fresh();
  const root = el("div", { class: "stack" });
  const said = el("div", { class: "stack", "aria-live": "polite" });
  const found = el("div", { class: "stack" });
  const draw = { said, found, app, look: (more) => look(draw, more) };
  root.append(taker(draw), said, found);
  tell(draw);
  if (app.intake.page) show(draw);
  return root;
}

function taker(draw) {
  const { app } = draw;
  const files = el("input", { type: "file", multiple: true, id: "files", on: { change: () => take(draw, [...files.files]) } });
  const zone = el("div", { class: "drop", on: {
    dragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    dragleave: () => zone.classList.remove("over"),
    drop: (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      take(draw, filesOf(event.dataTransfer), event.dataTransfer);
    },
  } }, el("p", {}, el("b", {}, t("drop_here"))), el("p", { class: "soft small" }, t("drop_about")), el("label", { class: "button", for: "files" }, t("choose_files")), files);
  const where = el("input", { type: "text", "aria-label": t("folder"), placeholder: t("folder_any"), name: "campaign", spellcheck: "false", value: app.intake.into ? "" : app.intake.folder || (app.state.opened ? app.state.campaign : "") });
  const earlier = el("div", {});
  get("incoming").then((sets) => refill(earlier, sets.filter((own) => own.files.length).map((own) => el("p", { class: "small" },
    el("button", { class: "link", on: { click: () => begun(draw, own.folder, own.into) } }, t("dropped_before", { name: own.into, count: own.files.length })))))).catch(() => {});
  return el("section", { class: "panel", "aria-label": t("own_tests") },
    el("h2", {}, t("own_tests")), zone, earlier,
    el("form", { class: "line", on: { submit: (event) => { event.preventDefault(); begun(draw, where.value, ""); } } },
      where, el("button", {}, t("look")),
      el("button", { type: "button", on: { click: () => app.act("open", { campaign: where.value }) } }, t("open"))),
    el("p", { class: "soft small" }, t("look_about")));
}

// A folder that is dropped has no content of its own: it is told to be named instead.
function filesOf(transfer) {
  const items = [...(transfer.items ?? [])];
  const whole = items.filter((item) => item.webkitGetAsEntry?.()?.isDirectory);
  return whole.length ? items.filter((item) => !whole.includes(item)).map((item) => item.getAsFile()).filter(Boolean) : [...transfer.files];
}

function begun(draw, folder, into) {
  draw.app.intake = { ...fresh(), folder, into };
  tell(draw);
  return look(draw);
}

async function take(draw, files, transfer) {
  const own = draw.app.intake;
  // Files of a campaign that is written, or of a named folder, are left alone: these are a new set.
  if (own.folder && (!own.into || own.page?.new === false)) Object.assign(own, fresh());
  own.refused = [];
  if (transfer && files.length < (transfer.items?.length ?? 0)) own.refused.push(t("drop_folder"));
  let number = 0;
  for (const file of files) {
    number += 1;
    refill(draw.said, el("p", { class: "soft", role: "status" }, t("taking", { name: file.name, number, count: files.length })));
    try {
      const kept = await send("drop", { into: own.into, name: file.name }, file);
      Object.assign(own, { into: kept.into, folder: kept.folder });
      own.kept.push(kept.name);
    } catch (problem) {
      own.refused.push(problem.message);
    }
  }
  tell(draw);
  if (own.folder) await look(draw);
}

function tell(draw) {
  const own = draw.app.intake;
  refill(draw.said,
    own.refused.length ? el("div", { class: "message", role: "alert" }, own.refused.map((text) => el("p", {}, text))) : null,
    own.kept.length ? el("p", { class: "small soft" }, t("taken", { count: own.kept.length, folder: own.folder })) : null);
}

const asked = (own) => ({ folder: own.folder, choices: own.choices, answers: own.answers, ship: own.ship });

// Ask anew what the files are; the answer to an older question is passed over.
async function look(draw, more = {}) {
  const own = draw.app.intake;
  const number = (own.number = (own.number ?? 0) + 1);
  if (!own.page) refill(draw.found, el("p", { class: "soft", role: "status" }, t("looking")));
  try {
    const page = await post(more.write ? "campaign" : "look", asked(own));
    if (number !== own.number || own !== draw.app.intake) return;
    const before = own.page;
    own.page = page;
    own.fault = "";
    if (page.written) Object.assign(own, { written: page.written, choices: [], answers: {}, ship: "" });
    if (more.answered && before && draw.form) draw.form.update(page);
    else show(draw);
  } catch (problem) {
    if (number !== own.number || own !== draw.app.intake) return;
    own.fault = problem.message;
    if (more.choice) own.choices = own.choices.filter((x) => x !== more.choice);
    show(draw);
  }
}

function show(draw) {
  const { app, found } = draw;
  const own = app.intake;
  const name = document.activeElement?.getAttribute("name");
  const within = found.contains(document.activeElement);
  const page = own.page;
  draw.form = page ? answersForm(draw, own, page) : null;
  refill(found,
    own.fault ? el("p", { class: "message", role: "alert" }, own.fault.split("\n").flatMap((line) => [line, el("br")])) : null,
    page ? layouts(draw, own, page) : null,
    draw.form?.root);
  if (name && within) [...found.querySelectorAll("[name]")].find((node) => node.getAttribute("name") === name)?.focus();
}
