"""Settings that several jobs have, each said once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pmmkit.actions.setting import Help, SettingError, orders_of, setting, settings, stated

Data = Annotated[
    Path | None, Help("Folder or URL of measurements that do not lie beside the campaign file.")
]
Model = Annotated[str, Help("Library ship (pmmkit ships) or model file (.toml).", argument=True)]
Campaign = Annotated[
    Path, Help("Folder with campaign.toml, such a file, .h5 or .zip, or its URL.", argument=True)
]
Figures = Annotated[bool, Help("Draw figures, which takes most of the time.")]
DrawFigures = Annotated[bool, Help("Draw figures.")]
Out = Annotated[
    Path | None,
    Help(
        "Folder of the results, whose files of the same name are replaced; a new one beside "
        "those of former calls if absent."
    ),
]
Output = Annotated[
    Path | None,
    Help("File of the result, or a folder where that is many files.", names="-o --output"),
]
Force = Annotated[bool, Help("Let the output replace the very file that was read.")]

Manoeuvre = Annotated[
    str,
    Help(
        "turning, initial_turning, zigzag, spiral, pull_out, stopping, accelerating, "
        "astern_to_ahead, course_change, williamson, straight or weave."
    ),
]
Depth = Annotated[float | None, Help("Depth of the water in m.", unit="m")]
Extrapolate = Annotated[bool, Help("Allow a speed outside the tested range.")]
Follow = Annotated[
    Literal["approach", "instant"],
    Help(
        "Whose Froude number the derivatives are taken at: that of the approach throughout, "
        "or that of each instant, held at the edge of the tested range."
    ),
]
Spread = Annotated[
    float | None,
    Help(
        "Relative standard deviation of every derivative, where the model has no covariance "
        "or in its place, such as 0.05."
    ),
]
Form = Annotated[
    Path | None,
    Help("File with the table [imo]: what the form of the IMO asks for besides (docs/imo.md)."),
]

StructureName = Annotated[
    str,
    Help(
        "Name of a structure, derivatives such as 'Yv Yv|v| Nv', or auto: the largest "
        "that these runs determine."
    ),
]
STRUCTURE = "abkowitz3"
"""The structure where none is named."""
Sets = Annotated[Literal["each", "pooled"], Help("A set per Froude number, or one over all.")]
Cycles = Annotated[str | None, Help("Cycles to take, such as 3 or 3-6; a test decides if absent.")]
Own = Annotated[Path | None, Help("File of your own effects (.toml), who take part.")]
Given = Annotated[
    tuple[str, ...], Help("Effects that are known to be there, such as fault_misalignment,memory.")
]
Scheduler = Annotated[
    str | None,
    Help("Address of a dask scheduler whose workers do it instead, such as tcp://host:8786."),
]


@settings
class ExecutionSettings:
    """Where it runs."""

    workers: int | None = setting(
        "How many work side by side on this machine; as many as it has processors if absent.",
        default=None,
        names="--workers --jobs",
        least=1,
    )
    scheduler: Scheduler = None

    @property
    def executor(self) -> int | str | None:
        """Where work runs, as `executor=` takes it."""
        if self.workers is not None and self.scheduler is not None:
            raise SettingError("Give --workers or --scheduler, not both.")
        return self.workers if self.scheduler is None else self.scheduler


@settings
class OrderSettings:
    """What is ordered in the manoeuvre."""

    rudder_deg: float | None = setting(
        "Rudder, positive to starboard; 35 in a turn, 10 in a zigzag, else as usual in that "
        "manoeuvre.",
        default=None,
        usual=(-35.0, 35.0, 1.0),
        unit="°",
    )
    switch_deg: float | None = setting(
        "Heading of a zigzag's order.", default=None, usual=(5.0, 30.0, 1.0), unit="°"
    )
    more: tuple[str, ...] = setting(
        "Any setting of the manoeuvre, such as executes=7; several by several --set.",
        default=(),
        names="--set",
    )

    def given(self) -> dict[str, Any]:
        """Those that were stated, as a manoeuvre takes them."""
        own = stated(self)
        more = orders_of(own.pop("more", ()))
        return {**own, **more}


@settings
class NoiseSettings:
    """What is uncertain in any case."""

    floor: float | None = setting(
        "What is smooth and too small to matter, over the rms force of a channel: your own "
        "uncertainty. U_SN of the campaign file, 0.005 for measured forces, 0.02 for "
        "free-running records if absent.",
        default=None,
        least=0.0,
        most=0.5,
    )
    noise: float | None = setting(
        "Standard uncertainty of a mean or harmonic, over the rms force, of runs that state "
        "none (tables, CFD).",
        default=None,
        least=0.0,
        most=0.5,
    )
