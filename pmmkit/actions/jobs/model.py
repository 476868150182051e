"""Show a model part by part with its sources, change values, take a part of another ship, or
estimate what its propeller does astern.

The changed model is MODEL-changed.toml in this folder if -o is absent.

Examples: pmmkit model show model.toml · pmmkit model set model.toml rudder.area=0.055
--because 'as built' · pmmkit model replace model.toml propeller --from kvlcc2
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, Literal

from pmmkit.actions.outcome import Outcome, marked, results_file
from pmmkit.actions.setting import SettingError, setting, settings, stem
from pmmkit.actions.shared import Force, Output

if TYPE_CHECKING:
    from pmmkit.models import Model


STAGE: Final = ("model", 5)
EXAMPLE: Final = "pmmkit model set model.toml rudder.area=33 --because 'as built'"


@settings
class ModelSettings:
    """What is asked."""

    action: Literal["show", "set", "replace", "astern"] = setting(
        "show part by part; set values; replace a part by another ship's; estimate what "
        "the propeller does astern.",
        argument=True,
    )
    model: str = setting("Library ship (pmmkit ships) or model file (.toml).", argument=True)
    what: tuple[str, ...] = setting(
        "set: rudder.area=0.055 Nvvr=-0.04; replace: propeller or rudder.",
        default=(),
        argument=True,
    )
    lender: str | None = setting(
        "replace: library ship or model file.", default=None, names="--from"
    )
    because: str = setting("The reason, which the model keeps: 'the yard's drawing'.", default="")
    output: Output = None
    force: Force = False


def model(job: ModelSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.files import write_results
    from pmmkit.models import load_model, save_model, with_part_of, with_stated

    loaded = load_model(job.model)
    words = list(job.what)
    if job.action in ("show", "astern") and (words or job.lender):
        raise SettingError(f"{job.action} takes a model alone; set and replace change it.")
    if job.action == "show":
        return _shown(loaded, [])
    if job.action == "set":
        made = with_stated(loaded, _values(words), job.because or "stated on the command line")
    elif job.action == "astern":
        made = loaded.with_estimated_astern()
    else:
        if len(words) != 1 or job.lender is None:
            raise SettingError(
                "Write the part and who lends it: pmmkit model replace model.toml propeller "
                "--from kvlcc2."
            )
        made = with_part_of(loaded, words[0], load_model(job.lender), job.because)
    path = results_file(
        job.output, f"{stem(job.model)}-changed.toml", read=[job.model, job.lender], force=job.force
    )
    write_results(path.parent, [(path.name, partial(save_model, made))])
    done = made.history[len(loaded.history) :]
    return _shown(made, [*done, f"Model: {path.resolve()}"], str(path))


def _shown(model: Model, done: list[str], path: str | None = None) -> Outcome:
    """The model's page, and what it lacks for a simulation."""
    lacks = model.missing_parts
    said = (
        f"It cannot be simulated without {', '.join(lacks)}: take them from a library ship with "
        f"pmmkit model replace."
        if lacks
        else "It has all that a simulation needs."
    )
    told = Outcome(
        content={
            "model": path,
            "name": model.name,
            "parts": {
                name: {
                    "source": part.source,
                    "values": {
                        own: {
                            "value": value,
                            "source": part.source_of(own),
                            "std": part.std.get(own)
                            or next(iter(model.std.get(part.place(own), ())), None),
                        }
                        for own, value in part.values.items()
                    },
                    "options": dict(part.options),
                }
                for name, part in model.parts.items()
            },
            "lacks": lacks,
            "steps": list(model.history),
        },
        lines=[str(model), "", said, *(["", *done] if done else [])],
    )
    return marked(told, model)


def _values(words: list[str]) -> dict[str, float]:
    """Values from ``place=number``."""
    found = {}
    for word in words:
        place, equals, text = word.partition("=")
        try:
            found[place.strip()] = float(text)
        except ValueError:
            raise SettingError(f"{word!r}: write rudder.area=0.055 or Nvvr=-0.04.") from None
        if not equals:
            raise SettingError(f"{word!r}: write rudder.area=0.055 or Nvvr=-0.04.")
    if not found:
        raise SettingError("Write what is set: pmmkit model set a.toml rudder.area=0.055.")
    return found
