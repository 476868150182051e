"""The ship in waves as a page: motions, responses, added resistance, records."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from pmmkit.presentation import Described, Section
from pmmkit.seakeeping import AddedResistance, Operability, Rao, Response
from pmmkit.views.pages.page_file import state_of
from pmmkit.views.pages.page_room import Answers
from pmmkit.views.pages.sections import PageSection, told_page
from pmmkit.views.report.drawn import drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN: Final = 12


def seakeeping_answers(
    rao: Rao,
    *,
    added: AddedResistance | None = None,
    responses: Sequence[Response] = (),
    operability: Operability | None = None,
    more: Sequence[Described] = (),
    figures: Mapping[str, Figure] | None = None,
) -> Answers:
    """What the page of a ship in waves holds.

    more: what else is told, such as records beside the motions. figures: what else is drawn, by
    caption.
    """
    froude = rao.speed / math.sqrt(rao.g * rao.L)
    facts = {
        "length": f"{rao.L:.4g} m",
        "Froude numbers": ", ".join(f"{x:.3f}" for x in froude[:6]),
        "headings": ", ".join(f"{math.degrees(x):.0f}°" for x in rao.heading[:8]),
    }
    told = [*_told(rao, rao.plot(), "Heave, pitch and roll over the length of the waves.")]
    for answer in responses[:_SHOWN]:
        told += _named(answer, f"{answer.speed:.2f} m/s, {answer.heading_deg:.0f}°")
    if operability is not None:
        told += _told(operability, operability.plot(), "The largest value over what is allowed.")
    if added is not None:
        told += _told(added, added.plot(), "Added resistance in regular waves.")
    for item in more:
        told += _named(item, "")
    drawings = [drawn(figure, caption) for caption, figure in (figures or {}).items()]
    told += [Section(figures=drawings)] if drawings else []
    return {
        "state": state_of(title=f"{rao.name} in waves", kind="seakeeping", runs=0, model=""),
        "told ship": told_page(PageSection(facts=facts, after=told)),
    }


def _told(thing: Described, figure: Figure, caption: str) -> list[Section]:
    first, *rest = thing.sections()
    return [replace(first, figures=[drawn(figure, caption)]), *rest]


def _named(thing: Described, name: str) -> list[Section]:
    """Sections under the name of what they belong to."""
    found = list(thing.sections())
    before = f"{name}: " if name else ""
    return [replace(item, title=f"{before}{item.title or thing._headline()}") for item in found]
