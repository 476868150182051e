// Place 2: the derivatives of the present model.

import { el, refill } from "./dom.js";
import { t } from "./words.js";

export async function showDerivatives(root, app, shown) {
  shown();
  refill(root, el("p", { class: "soft" }, t("not_yet")));
}
