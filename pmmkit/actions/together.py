"""``pmmkit diagnose`` with several campaigns."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.actions.outcome import Outcome, marked, say, warned, written
from pmmkit.actions.sound import sound_campaigns
from pmmkit.actions.text import present

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign


def together_outcome(
    name: str,
    paths: Sequence[Path],
    folder: Path,
    *,
    data: Path | None,
    captive: dict[str, Any],
    free: dict[str, Any],
    drawn: bool,
) -> Outcome:
    """The answer of several campaigns, printed and written."""
    from pmmkit.base import DataError
    from pmmkit.conventions import STRUCTURES
    from pmmkit.diagnosis import joint_diagnosis
    from pmmkit.models import load_model, save_model
    from pmmkit.plotting import save

    if name in STRUCTURES:
        raise DataError(
            f"{name} is a structure: several campaigns are asked about a model. Give a model file "
            f"or a library ship; pmmkit reduce writes a model from captive tests."
        )
    model = load_model(name)
    asked: dict[str, Campaign] = {}
    head, warnings, checks = [], [], {}
    for title, (campaign, checked) in sound_campaigns(paths, data).items():
        asked[title] = campaign
        head.append(f"{title}: {len(campaign.runs)} runs, {campaign.kind}")
        warnings += warned(checked)
        checks[title] = [item.to_dict() for item in checked]
    found = joint_diagnosis(
        model, asked, captive=present(**captive), free=present(**free), progress=say
    )
    content = {**found.to_dict(), "model": model.name, "checks": checks}
    results: list[tuple[str, Any]] = [
        ("diagnosis.json", content),
        ("effects.csv", found.to_pandas()),
    ]
    if found.model is not None:
        results.append(("model.toml", partial(save_model, found.model)))
    if found.others:
        another = found.others[0].model
        results.append(("another_laboratory.toml", partial(save_model, another)))
    if drawn:
        results.append(("evidence.svg", partial(save, found.plot())))
    lines = [*head, *warnings, str(found), ""]
    return marked(written(folder, results, content, lines), model)
