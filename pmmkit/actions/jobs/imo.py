"""Judge a ship by every criterion of IMO MSC.137(76), to both sides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from pmmkit.actions.outcome import Outcome, marked, results_folder, written
from pmmkit.actions.setting import setting, settings, stem
from pmmkit.actions.shared import Depth, Extrapolate, Follow, Form, Model, Out, Spread
from pmmkit.actions.speeds import Speed, approach
from pmmkit.presentation import counted, text_of

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.imo import Verdict

STAGE: Final = ("hand in", 2)
EXAMPLE: Final = "pmmkit imo kvlcc2 --speed 8 --spread 0.05"


@settings
class ImoSettings:
    """What is asked."""

    model: Model
    speed: Speed = None
    ships: int = setting("Ships drawn for the probability of passing.", default=2000)
    spread: Spread = None
    astern: float | None = setting(
        "Revolutions of the full astern stop over those of the approach, such as -0.6; "
        "the standard does not say them. -0.7 if absent.",
        default=None,
        most=-0.01,
    )
    reversal: float | None = setting(
        "Seconds from the order astern until those revolutions are reached; a model's own "
        "shaft lags behind it. If absent they fall to zero in two ship lengths over the "
        "speed and go on at that rate.",
        default=None,
        least=0.1,
    )
    torque: float | None = setting(
        "Largest torque astern over that of the approach, such as 0.8; as much as the "
        "revolutions need if absent.",
        default=None,
        least=0.01,
    )
    form: Form = None
    fn: Follow = "approach"
    depth: Depth = None
    extrapolate: Extrapolate = False
    out: Out = None


def imo(job: ImoSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.imo import imo_verdicts, verdict_sections
    from pmmkit.models import load_model
    from pmmkit.views import form_of_model, read_stated

    folder = results_folder(job.out, f"{stem(job.model)}-imo")
    loaded = load_model(job.model)
    pace = approach(job.speed, loaded)
    stated = {} if job.form is None else read_stated(job.form)
    found = imo_verdicts(
        loaded,
        pace,
        n=job.ships,
        spread=job.spread,
        astern=job.astern,
        reversal=job.reversal,
        torque=job.torque,
        full_speed=stated.get("speed_85"),
        full_draught=stated.get("full_load_draught"),
        fn=job.fn,
        depth=job.depth,
        extrapolate=job.extrapolate,
    )
    rows = [item.to_dict() for item in found]
    filled = form_of_model(loaded, found, speed=pace, stated=stated, depth=job.depth)
    results = [("imo.json", rows), ("imo.csv", _table(found)), *filled.files()]
    lines = [
        f"{loaded.name}, {pace:g} m/s (Fn {loaded.ship.froude(pace, loaded.water.g):.3f})",
        text_of(verdict_sections(found)),
        "",
        f"Form: {folder / filled.PAGE}, with "
        f"{counted(len(filled.not_supplied), 'field')} not supplied",
    ]
    return marked(written(folder, results, {"verdicts": rows}, lines), loaded)


def _table(found: Sequence[Verdict]) -> pd.DataFrame:
    """The verdicts as a table, sentences in one cell."""
    import pandas as pd

    rows = [
        {
            **item.to_dict(),
            "unsettled": " ".join(item.unsettled),
            "conditions": " ".join(item.conditions),
            "full_astern": "" if item.full_astern is None else item.full_astern.words,
        }
        for item in found
    ]
    return pd.DataFrame(rows)
