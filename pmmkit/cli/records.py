"""What commands ask of free-running records: which, which channels, how well they are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import numbers, patterns, sensors_of, stated, typed_again, words
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.identification import Chosen
    from pmmkit.models import Model

WINDOW: Final = 60.0
Candidates = Annotated[
    str | None,
    typer.Option(
        help="Effects and faults that free-running records are asked for, such as "
        "asymmetry,rudder_stall; the whole catalogue if absent."
    ),
]
Runs = Annotated[
    list[str] | None,
    typer.Option(help="Free-running runs to diagnose, such as 'turn_*'; may be repeated."),
]
TestRuns = Annotated[
    list[str] | None,
    typer.Option("--test-runs", help="Free-running runs held out, to be predicted."),
]
Channels = Annotated[
    str | None,
    typer.Option(
        help="Channels of free-running records to use, such as x,y,psi,r where the checks find "
        "fault with the velocities; all if absent."
    ),
]
Spread = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        help="Largest share of their usual sizes by which the model's values may be off before "
        "free-running records are looked at; how far they move is found; 0.15 if absent.",
    ),
]
Shortest = Annotated[
    float | None,
    typer.Option(
        min=0.1,
        help="Leave out free-running segments shorter than this, in s; ten ship lengths if absent.",
    ),
]
Sensors = Annotated[
    str | None,
    typer.Option(
        help="Standard deviations of channels of free-running records, such as "
        "x=0.03,y=0.03,psi_deg=0.1; told from their noise if absent."
    ),
]
Windage = Annotated[
    str | None, typer.Option(help="Frontal and lateral area above water in m2, such as 0.135,0.52.")
]
Judged = Annotated[
    float | None,
    typer.Option(
        min=0.1,
        help="Length in s of the windows by which effects are judged; five ship lengths if absent.",
    ),
]
Window = Annotated[
    float, typer.Option(min=0.1, help="Length in s of the windows of runs held out.")
]


@dataclass(frozen=True, kw_only=True)
class RecordOptions:
    """What was typed about free-running records, as text."""

    candidates: str | None = None
    runs: list[str] | None = None
    test_runs: list[str] | None = None
    channels: str | None = None
    spread: float | None = None
    shortest: float | None = None
    sensors: str | None = None
    windage: str | None = None
    judged: float | None = None
    window: float = WINDOW

    def typed(self) -> dict[str, Any]:
        """What was typed, by name of the option."""
        window = None if self.window == WINDOW else self.window
        return stated(**{**vars(self), "window": window})

    def repeated(self) -> str:
        """The options to type again where the same records are used, with a space before each."""
        return typed_again(
            **{name: value for name, value in self.typed().items() if name != "candidates"}
        )

    def chosen(self, campaign: Campaign, model: Model) -> tuple[Chosen, Chosen | None]:
        """The records that are used, and those held out."""
        from pmmkit.identification import chosen_records

        return chosen_records(
            campaign,
            model,
            runs=patterns(self.runs),
            test_runs=patterns(self.test_runs),
            channels=None if self.channels is None else words(self.channels),
            shortest=self.shortest,
            rudder="auto",
            wind=True,
        )

    def system(self) -> dict[str, Any]:
        """Settings of the question that the records are asked."""
        return {
            **stated(spread=self.spread),
            "windage": self.areas,
            "sensors": sensors_of(self.sensors),
            "window": self.judged,
        }

    def settings(self, kept: Chosen | None) -> dict[str, Any]:
        """Settings of a session about the records, with those held out."""
        return {
            **self.system(),
            "held_out": kept.records if kept else (),
            "held_out_window": self.window if kept else None,
        }

    def several(self) -> dict[str, Any]:
        """Settings of a session about several campaigns."""
        return {
            **self.system(),
            **stated(
                runs=patterns(self.runs),
                test_runs=patterns(self.test_runs),
                channels=None if self.channels is None else words(self.channels),
                shortest=self.shortest,
                held_out_window=self.window if self.test_runs else None,
            ),
        }

    def together(self) -> dict[str, Any]:
        """Settings of the records where several campaigns vote together."""
        from pmmkit.effects import CATALOGUE

        names = self.names
        return stated(
            candidates=None if names is None else [CATALOGUE[name] for name in names],
            runs=patterns(self.runs),
            channels=None if self.channels is None else words(self.channels),
            sensors=sensors_of(self.sensors),
            spread=self.spread,
            shortest=self.shortest,
            windage=self.areas,
            window=self.judged,
        )

    @property
    def names(self) -> list[str] | None:
        """The effects that are asked for; None for the whole catalogue."""
        return None if self.candidates is None else words(self.candidates)

    @property
    def areas(self) -> tuple[float, float] | None:
        """Frontal and lateral area above water [m²]."""
        found = numbers(self.windage)
        if found is None:
            return None
        if len(found) != 2 or min(found) <= 0.0:
            raise typer.BadParameter(f"{self.windage!r}: write two areas such as 0.135,0.52.")
        return found[0], found[1]


def errors_table(errors: Mapping[str, Mapping[str, float]]) -> str:
    """Errors of windows, a line for each model."""
    from pmmkit.identification import UNITS

    names = [name for name in UNITS if any(name in row for row in errors.values())]
    head = [f"{name.replace('_', ' ')} [{UNITS[name]}]" for name in names]
    rows = [
        [what, *(f"{row[name]:.3g}" if name in row else "-" for name in names)]
        for what, row in errors.items()
    ]
    return aligned(["", *head], rows)
