"""The records of a campaign that a question is put to, and those that are held out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

from pmmkit.base import DataError, Problem
from pmmkit.campaigns import Campaign, Cut, Run, usable
from pmmkit.identification.as_tested import RecordOffsets, without
from pmmkit.identification.from_run import free_records
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model

SAME_LENGTH: Final = 0.02
"""Share by which the lengths of model and campaign may differ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chosen:
    """Records of some runs, and what was cut from them.

    Parameters
    ----------
    runs : tuple of str
        Ids.
    records : tuple of FreeRecord
        Their usable segments.
    cuts : tuple of (str, Cut)
        What was left out, by run.
    """

    runs: tuple[str, ...]
    records: tuple[FreeRecord, ...]
    cuts: tuple[tuple[str, Cut], ...]

    @classmethod
    def of(
        cls,
        campaign: Campaign,
        model: Model,
        *,
        runs: Sequence[str] | None,
        test_runs: Sequence[str] | None,
        channels: Sequence[str] | None,
        rudder: Literal["auto", "measured", "ordered"],
        wind: bool,
        shortest: float | None = None,
    ) -> tuple[Chosen, Chosen | None]:
        """Records to identify from, and those held out.

        Parameters
        ----------
        campaign : Campaign
            Free-running runs.
        model : Model
            Of the ship as tested.
        runs, test_runs : sequence of str, optional
            Patterns of ids.
        channels, rudder, wind, shortest
            As for `free_records`.

        Returns
        -------
        Chosen, Chosen or None
            A run that is held out is never identified from.

        Raises
        ------
        DataError
            If the campaign is captive or of another ship, or no record is left.
        UnknownNameError
            If a pattern fits no run.
        """
        if campaign.kind != "free-running":
            raise DataError(
                f"Campaign {campaign.title!r} is {campaign.kind}: identify takes free-running "
                "records. Captive tests go into `pmmkit reduce` (its --method has sindy and ekf "
                "too)."
            )
        if abs(model.ship.L / campaign.ship.L - 1.0) > SAME_LENGTH:
            raise DataError(
                f"Model {model.name!r} is of a ship of {model.ship.L:g} m, the records of one of "
                f"{campaign.ship.L:g} m. Bring the model to that length: pmmkit scale {model.name} "
                f"--length {campaign.ship.L:g} --froude-only."
            )
        held = campaign.matching(test_runs) if test_runs else []
        asked = campaign.matching(runs) if runs else list(campaign.runs)
        train = [run for run in asked if run not in held]
        if not train:
            raise DataError("Every run is held out: none is left to identify from.")

        def records(chosen: Sequence[Run]) -> Chosen:
            return _records(
                chosen,
                model,
                channels=channels,
                rudder=rudder,
                wind=wind,
                shortest=shortest,
                depth_of=campaign.depth_of,
                campaign=campaign.title,
            )

        return records(train), records(held) if held else None

    @property
    def seconds(self) -> float:
        """Length of all records together [s]."""
        return float(sum(item.t[-1] - item.t[0] for item in self.records))

    def content(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "runs": list(self.runs),
            "records": [
                {
                    "name": item.name,
                    "samples": len(item),
                    "seconds": item.t[-1] - item.t[0],
                    "speed": item.speed,
                    "channels": list(item.measured),
                    "wind": item.wind_speed is not None,
                }
                for item in self.records
            ],
            "cuts": [
                {"run": run, "t_start": cut.t_start, "t_stop": cut.t_stop, "reason": cut.reason}
                for run, cut in self.cuts
            ],
        }

    def words(self, head: str, most: int = 6) -> list[str]:
        """For people: how many records, what was measured, what was cut."""
        channels = list(dict.fromkeys(name for item in self.records for name in item.measured))
        wind = any(item.wind_speed is not None for item in self.records)
        lines = [
            f"{head}: {len(self.records)} records from {len(self.runs)} runs "
            f"({', '.join(self.runs)}), {sum(map(len, self.records))} samples, "
            f"{self.seconds:.0f} s; {', '.join(channels)}{' and wind' if wind else ''}"
        ]
        empty = [
            run for run in self.runs if not any(_is_of(item.name, run) for item in self.records)
        ]
        if empty:
            lines.append(f"  no segment was long enough in {', '.join(empty)}")
        lines += [f"  cut from {run}: {cut}" for run, cut in self.cuts[:most]]
        if len(self.cuts) > most:
            lines.append(f"  and {len(self.cuts) - most} more cuts, in identified.json")
        return lines

    def corrected(self, model: Model) -> Chosen:
        """The records as the model's steps say that they were sailed."""
        records = (
            without(item, RecordOffsets.of(model, item.campaign).values) for item in self.records
        )
        return replace(self, records=tuple(records))

    def long_enough(self, window: float) -> tuple[FreeRecord, ...]:
        """The records that hold a window [s].

        Raises
        ------
        DataError
            If none does.
        """
        found = tuple(item for item in self.records if item.t[-1] - item.t[0] >= window)
        if not found:
            longest = max(item.t[-1] - item.t[0] for item in self.records)
            raise DataError(
                f"No record is as long as a window of {window:g} s; the longest has "
                f"{longest:.1f} s. Choose a shorter --window."
            )
        return found


def _is_of(record: str, run: str) -> bool:
    """Whether a record is a run or one of its segments."""
    return record == run or record.rpartition("/")[0] == run


def _records(
    runs: Sequence[Run],
    model: Model,
    *,
    channels: Sequence[str] | None,
    rudder: Literal["auto", "measured", "ordered"],
    wind: bool,
    shortest: float | None,
    depth_of: Callable[[Run], float | None],
    campaign: str,
) -> Chosen:
    """Usable segments of runs; every run that cannot be used at all is named at once."""
    records: list[FreeRecord] = []
    cuts: list[tuple[str, Cut]] = []
    problems: list[Problem | str] = []
    for run in runs:
        least = shortest or 10.0 * model.ship.L / max(run.settings.speed, 1e-9)
        data = run.data
        loaded = run.with_(loader=lambda data=data: data)
        cuts += [(run.id, cut) for cut in usable(loaded, shortest=least).cuts]
        try:
            records += free_records(
                loaded,
                model,
                rudder=rudder,
                channels=channels,
                wind=wind,
                shortest=least,
                depth=depth_of(run),
                campaign=campaign,
            )
        except DataError as error:
            problems += error.problems
    if problems:
        raise DataError(problems, title="Not identified")
    if not records:
        told = [Problem(message=f"{cut}.", run=run) for run, cut in cuts]
        raise DataError(
            told or "The runs hold no samples.",
            title="No record is long enough after the cuts (ten ship lengths, or --shortest)",
        )
    return Chosen(runs=tuple(run.id for run in runs), records=tuple(records), cuts=tuple(cuts))
