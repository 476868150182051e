"""Make a ship from her card: an empty card, the card of a model, a model that does as a card says.

Examples: pmmkit card form · pmmkit card fit card.toml · pmmkit card write kvlcc2 --speed 8
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final, Literal

from pmmkit.actions.outcome import Outcome, marked, results_file, results_folder, written
from pmmkit.actions.setting import SettingError, setting, settings, stem
from pmmkit.actions.shared import Extrapolate, Force, Out, Output, Spread
from pmmkit.actions.speeds import Speed, approach
from pmmkit.base import DataError
from pmmkit.presentation import quoted

STAGE: Final = ("model", 3)
EXAMPLE: Final = "pmmkit card fit card.toml"


@settings
class CardSettings:
    """What is asked."""

    action: Literal["form", "write", "fit"] = setting(
        "form: an empty card to fill in; write: the card of a model; fit: a model from a card.",
        argument=True,
    )
    what: str | None = setting(
        "write: library ship or model file; fit: the card.", default=None, argument=True
    )
    speed: Speed = None
    model: str | None = setting(
        "fit: library ship or model file that is moved to the card; the estimate from the "
        "particulars of the card if absent.",
        default=None,
    )
    spread: Spread = None
    ships: int = setting("fit: ships behind an interval.", default=200, least=20)
    seed: int = setting("fit: of their draws.", default=0, least=0)
    extrapolate: Extrapolate = False
    output: Output = None
    out: Out = None
    force: Force = False


def card(job: CardSettings) -> Outcome:
    """Do what is asked."""
    if job.action == "fit" and job.output is not None:
        raise SettingError("fit writes a folder: name it with --out.")
    if job.action != "fit" and job.out is not None:
        raise SettingError(f"{job.action} writes a file: name it with -o.")
    if job.action == "form":
        return _form(job)
    if job.what is None:
        wanted = "a model" if job.action == "write" else "a card, such as card.toml"
        raise SettingError(f"{job.action} needs {wanted}: pmmkit card {job.action} ….")
    return _written(job, job.what) if job.action == "write" else _fitted(job, Path(job.what))


def _form(job: CardSettings) -> Outcome:
    """An empty card."""
    from pmmkit.cards import Card, empty_card
    from pmmkit.files import write_text

    if job.what is not None:
        raise SettingError(f"form takes nothing: is it pmmkit card write {job.what}?")
    file = results_file(job.output, Card.FILE)
    write_text(file, empty_card())
    command = f"pmmkit card fit {quoted(file)}"
    return Outcome(
        content={"card": str(file), "next": command},
        lines=[f"Card: {file}", "Fill in what you know of the ship.", f"Next: {command}"],
    )


def _written(job: CardSettings, name: str) -> Outcome:
    """The card of a model."""
    from pmmkit.cards import Card
    from pmmkit.files import write_text
    from pmmkit.models import load_model

    loaded = load_model(name)
    made = Card.of(loaded, approach(job.speed, loaded), extrapolate=job.extrapolate)
    file = results_file(job.output, f"{stem(name)}-card.toml", read=[name], force=job.force)
    write_text(file, made.text())
    told = Outcome(content={"card": str(file)}, lines=[str(made), "", f"Card: {file}"])
    return marked(told, loaded)


def _fitted(job: CardSettings, file: Path) -> Outcome:
    """A model from a card."""
    from pmmkit.base import shown
    from pmmkit.cards import Card, read_card, ship_from_card
    from pmmkit.files import MODEL
    from pmmkit.models import save_model

    if job.speed is not None:
        raise SettingError("fit takes the speeds of the card: write them there.")
    if not file.exists():
        raise DataError(f"{file}: there is no such card. pmmkit card form makes one to fill in.")
    known = read_card(file)
    folder = results_folder(job.out, f"{stem(file)}-ship", read=[file, job.model], force=job.force)
    with shown() as progress:
        found = ship_from_card(
            known,
            model=job.model,
            spread=job.spread,
            ships=job.ships,
            seed=job.seed,
            progress=progress,
        )
    measures, values = found.to_pandas(), found.values()
    results = [
        (MODEL.file, partial(save_model, found.model)),
        ("measures.csv", measures),
        ("values.csv", values.reset_index()),
        (Card.FILE, found.completed().text()),
        ("measures.svg", found.plot().save),
    ]
    command = f"pmmkit uncertainty {quoted(folder / MODEL.file)} --speed {known.speed:.4g}"
    content = {
        "model": str(folder / MODEL.file),
        "measures": measures.to_dict("records"),
        "values": values.reset_index().to_dict("records"),
        "told": found.told,
        "misfit": found.misfit,
        "widened": found.widened,
        "missed": [item.words for item in found.missed],
        "warnings": found.warnings(),
        "next": command,
    }
    lines = [str(found), "", f"Next: {command}"]
    return marked(written(folder, results, content, lines), found.model)
