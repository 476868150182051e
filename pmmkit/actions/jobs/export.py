"""Write a model, table, campaign or track for MATLAB, Simulink, Excel, SIMMAN and others."""

from __future__ import annotations

from pathlib import Path
from typing import Final, Literal

from pmmkit.actions.outcome import Outcome, marked, results_file
from pmmkit.actions.setting import SettingError, setting, settings, stem
from pmmkit.actions.shared import Data, Output
from pmmkit.actions.speeds import WAYS, TypedSpeed, typed

STAGE: Final = ("hand in", 3)
EXAMPLE: Final = "pmmkit export kvlcc2 --to mss --speed 8"


Format = Literal["mss", "shipmmg", "fmu", "csv", "excel", "latex", "netcdf", "simman"]
"""What other programs read."""


@settings
class ExportSettings:
    """What is asked."""

    what: str = setting(
        "Library ship, model file, campaign, derivative table, or track.csv of a simulation.",
        argument=True,
    )
    to: Format | None = setting(
        "What to write; the ending of the output says it if absent.", default=None
    )
    output: Output = None
    speed: TypedSpeed | None = setting(
        f"For models whose values depend on it, at the model's own scale: {WAYS}.",
        default=None,
        read=typed,
        metavar="SPEED",
    )
    data: Data = None
    fmi: Literal["3", "2"] | None = setting(
        "For fmu: version of the interface; 3 if absent, older programs read 2.", default=None
    )
    compile: bool = setting("For fmu: put a library for this machine into it.", default=False)


def export(job: ExportSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.exports import ENDINGS, file_name, read_subject
    from pmmkit.exports import export as export_exports
    from pmmkit.models import Model

    default: str | Path = ""
    subject = read_subject(job.what, data=job.data)
    if job.output is None:
        if job.to is None:
            raise SettingError("Say what to write: --to mss, or -o with an ending such as .m.")
        default = file_name(subject, stem(job.what), job.to)
    target = results_file(job.output, default)
    pace = None
    if job.speed is not None:
        known = isinstance(subject, Model)
        pace = job.speed.of(subject.ship, subject.water) if known else job.speed.without_ship()
    files = export_exports(
        job.what,
        target,
        job.to if job.to else None,
        speed=pace,
        data=job.data,
        fmi=None if job.fmi is None else 2 if job.fmi == "2" else 3,
        compile=job.compile,
    )
    lines = [f"{target}: {len(files)} files." if target.is_dir() else f"Written: {target}"]
    if target.suffix == ENDINGS["fmu"]:
        lines += _of_fmu(job.what, pace, compile=job.compile)
    done = Outcome(content={"files": [str(file) for file in files]}, lines=lines)
    return marked(done, subject) if isinstance(subject, Model) else done


def _of_fmu(what: str, speed: float | None, *, compile: bool) -> list[str]:
    """What a user of an FMU asks next: how the ship begins, and whether there is a library."""
    from pmmkit.exports import approach_of
    from pmmkit.models import load_model

    model = load_model(what)
    at = approach_of(model, speed)
    froude = model.ship.froude(at, model.water.g)
    begins = f"The ship begins at {at:.4g} m/s (Fn {froude:.2g})"
    lines = [f"{begins}." if speed is not None else f"{begins}; --speed chooses another speed."]
    if not compile:
        lines.append("It holds C sources; --compile puts a library for this machine into it.")
    return lines
