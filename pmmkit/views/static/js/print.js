// On paper a page from disk has all its places, one after the other, as they are drawn.

import { el } from "./dom.js";
import { t } from "./words.js";
import { toldAfter, toldBefore } from "./sections.js";

// `places`: functions that draw, by name. All answers are at hand, so that everything is drawn
// before the browser lays out the paper.
export function printAll(app, places) {
  const root = document.documentElement;
  let before = null;
  let book = null;

  const draw = async (name) => {
    const chapter = el("section", { class: "chapter stack" }, el("h1", {}, t(`place_${name}`)));
    const content = el("div", { class: "stack" });
    book.append(chapter);
    const told = await app.told(name);
    chapter.append(...toldBefore(told), content, ...toldAfter(told));
    if (app.draws(name)) await places[name](content, app, () => {});
    else content.remove();
  };

  addEventListener("beforeprint", () => {
    if (book) return;
    before = root.dataset.theme;
    root.dataset.theme = "light";
    root.classList.add("on-paper");
    book = el("div", { class: "book" }, el("h1", { class: "title" }, app.state.title), el("p", { class: "soft" }, app.about()));
    document.body.append(book);
    Promise.all(app.places().map(draw)).then(() => book?.querySelectorAll("details").forEach((own) => { own.open = true; }));
  });
  addEventListener("afterprint", () => {
    book?.remove();
    book = null;
    root.classList.remove("on-paper");
    if (before) root.dataset.theme = before;
    else delete root.dataset.theme;
  });
}
