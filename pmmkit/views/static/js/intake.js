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
  const files = el("input", { type: "file", multiple: true, id: "files", on: { change: () => take(draw, [...files.files].map((file) => [file.name, file])) } });
  const folder = el("input", { type: "file", webkitdirectory: true, id: "folder", on: { change: () => take(draw, [...folder.files].map((file) => [file.webkitRelativePath, file])) } });
  const zone = el("div", { class: "drop", on: {
    dragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    dragleave: () => zone.classList.remove("over"),
    drop: (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      dropped(event.dataTransfer).then((found) => take(draw, found), (problem) => { app.intake.refused = [problem.message]; tell(draw); });
    },
  } }, el("p", {}, el("b", {}, t("drop_here"))), el("p", { class: "soft small" }, t("drop_about")),
  el("p", {}, folder, el("label", { class: "button", for: "folder" }, t("choose_folder")), " ", files, el("label", { class: "button", for: "files" }, t("choose_files"))));
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

// Files with their names, those of dropped folders with the names of the folders before them.
async function dropped(transfer) {
  // The entries are gone after the first pause.
  const entries = [...(transfer.items ?? [])].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  return entries.length ? (await Promise.all(entries.map(within))).flat() : [...transfer.files].map((file) => [file.name, file]);
}

async function within(entry) {
  if (entry.isFile) return [[entry.fullPath.slice(1), await new Promise((give, fail) => entry.file(give, fail))]];
  const reader = entry.createReader();
  const found = [];
  // A reader gives a hundred entries at a time.
  for (let some; (some = await new Promise((give, fail) => reader.readEntries(give, fail))).length;) found.push(...some);
  return (await Promise.all(found.map(within))).flat();
}

// The folder that holds all files is the set's own, and its title; hidden files are nobody's tests.
function unpacked(files) {
  const shown = files.filter(([name]) => !name.split("/").some((part) => part.startsWith(".")));
  const top = shown[0]?.[0].split("/")[0];
  if (!shown.every(([name]) => name.startsWith(`${top}/`))) return { title: "", files: shown };
  return { title: top ?? "", files: shown.map(([name, file]) => [name.slice(top.length + 1), file]) };
}

function begun(draw, folder, into) {
  draw.app.intake = { ...fresh(), folder, into };
  tell(draw);
  return look(draw);
}

async function take(draw, given) {
  const own = draw.app.intake;
  const { title, files } = unpacked(given);
  // Files of a campaign that is written, or of a named folder, are left alone: these are a new set.
  if (own.folder && (!own.into || own.page?.new === false)) Object.assign(own, fresh());
  own.refused = files.length ? [] : [t("drop_empty")];
  if (title) own.answers["campaign.title"] ??= title.slice(0, 80);
  let number = 0;
  for (const [name, file] of files) {
    number += 1;
    refill(draw.said, el("p", { class: "soft", role: "status" }, t("taking", { name, number, count: files.length })));
    try {
      const place = await send("drop", { into: own.into, name }, file);
      Object.assign(own, { into: place.into, folder: place.folder });
      own.kept.push(place.name);
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
