"""The options and arguments that commands share, and what is read out of their text."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from pmmkit.base import Workers
    from pmmkit.campaigns import Campaign as Tests
    from pmmkit.intake import CheckFinding

Data = Annotated[
    Path | None,
    typer.Option(
        "--data", help="Folder or URL of measurements that do not lie beside the campaign file."
    ),
]
Model = Annotated[str, typer.Argument(help="Library ship (pmmkit ships) or model file (.toml).")]
Campaign = Annotated[
    Path, typer.Argument(help="Folder with campaign.toml, such a file, .h5 or .zip, or its URL.")
]
Figures = Annotated[bool, typer.Option(help="Draw figures, which takes most of the time.")]
DrawFigures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw figures.")]

Manoeuvre = Annotated[
    str,
    typer.Option(
        help="turning, initial_turning, zigzag, spiral, pull_out, stopping, accelerating, "
        "astern_to_ahead, course_change, williamson, straight or weave."
    ),
]
RudderDeg = Annotated[
    float | None,
    typer.Option(
        "--rudder-deg",
        help="Rudder, positive to starboard; 35 in a turn, 10 in a zigzag, else as usual in that "
        "manoeuvre.",
    ),
]
SwitchDeg = Annotated[float | None, typer.Option(help="Heading of a zigzag's order.")]
More = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="Any setting of the manoeuvre, such as executes=7; several by several --set."
    ),
]
Depth = Annotated[float | None, typer.Option(help="Depth of the water in m.")]
Extrapolate = Annotated[
    bool, typer.Option("--extrapolate", help="Allow a speed outside the tested range.")
]
Follow = Annotated[
    Literal["approach", "instant"],
    typer.Option(
        "--fn",
        help="Whose Froude number the derivatives are taken at: that of the approach throughout, "
        "or that of each instant, held at the edge of the tested range.",
    ),
]
Spread = Annotated[
    float | None,
    typer.Option(
        help="Relative standard deviation of every derivative, where the model has no covariance "
        "or in its place, such as 0.05."
    ),
]

Form = Annotated[
    Path | None,
    typer.Option(
        "--form",
        help="File with the table [imo]: what the form of the IMO asks for besides (docs/imo.md).",
    ),
]

StructureName = Annotated[
    str,
    typer.Option(
        "--structure",
        help="Name of a structure, derivatives such as 'Yv Yv|v| Nv', or auto: the largest "
        "that these runs determine.",
    ),
]
Sets = Annotated[
    Literal["each", "pooled"],
    typer.Option("--fn", help="A set per Froude number, or one over all."),
]
Cycles = Annotated[
    str | None,
    typer.Option("--cycles", help="Cycles to take, such as 3 or 3-6; a test decides if absent."),
]
WorkerCount = Annotated[
    int | None,
    typer.Option(
        "--workers",
        "--jobs",
        min=1,
        help="How many work side by side on this machine; as many as it has processors if absent.",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        help="Address of a dask scheduler whose workers do it instead, such as tcp://host:8786."
    ),
]
Floor = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        max=0.5,
        help="What is smooth and too small to matter, over the rms force of a channel: your own "
        "uncertainty. U_SN of the campaign file, 0.005 for measured forces, 0.02 for free-running "
        "records if absent.",
    ),
]
Noise = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        max=0.5,
        help="Standard uncertainty of a mean or harmonic, over the rms force, of runs that state "
        "none (tables, CFD).",
    ),
]
Own = Annotated[
    Path | None, typer.Option("--own", help="File of your own effects (.toml), who take part.")
]
Given = Annotated[
    list[str] | None,
    typer.Option(help="Effects that are known to be there, such as fault_misalignment,memory."),
]


def sound_campaign(
    path: Path, data: Path | None, executor: Workers = None
) -> tuple[Tests, tuple[CheckFinding, ...]]:
    """A campaign that does not contradict itself, and what the checks say of it."""
    from pmmkit.campaigns import open_campaign
    from pmmkit.intake import examine, refuse

    campaign = open_campaign(path, data=data)
    findings = examine(campaign, executor=executor)
    refuse(findings)
    return campaign, findings


def sound_campaigns(
    paths: Sequence[Path], data: Path | None
) -> dict[str, tuple[Tests, tuple[CheckFinding, ...]]]:
    """The same of several campaigns, by their titles as a session knows them."""
    from pmmkit.campaigns import by_title

    sound = [sound_campaign(path, data) for path in paths]
    return dict(zip(by_title([campaign for campaign, _ in sound]), sound, strict=True))


def cycles_of(text: str | None) -> int | tuple[int, int] | None:
    """Cycles out of text such as 3 or 3-6."""
    if text is None:
        return None
    first, dash, last = text.partition("-")
    try:
        return (int(first), int(last)) if dash else int(first)
    except ValueError:
        raise typer.BadParameter(f"{text!r}: write one cycle (3) or a range (3-6).") from None


def where(workers: int | None, scheduler: str | None) -> int | str | None:
    """Where work runs, as `executor=` takes it."""
    if workers is not None and scheduler is not None:
        raise typer.BadParameter("Give --workers or --scheduler, not both.")
    return workers if scheduler is None else scheduler


def stem(path: str | Path) -> str:
    """Name for a folder of results: that of the campaign's folder, or of the file."""
    full = Path(path).resolve()
    named = full.parent if full.name == "campaign.toml" else full
    files = (".toml", ".h5", ".hdf5", ".nc", ".csv", ".mgf", ".zip")
    return named.stem if named.suffix in files else named.name


def stated(**settings: Any) -> dict[str, Any]:
    """The settings that were given."""
    return {name: value for name, value in settings.items() if value is not None}


def settings_of(given: Sequence[str] | None) -> dict[str, float]:
    """Settings out of text such as executes=7."""
    found = {}
    for text in given or ():
        name, _, value = text.partition("=")
        try:
            found[name.strip().replace("-", "_")] = float(value)
        except ValueError:
            raise typer.BadParameter(f"{text!r}: write --set executes=7.") from None
    return found


def typed_again(**options: Any) -> str:
    """Options as they are typed, with a space before each; those that were not given stay away.

    Examples
    --------
    >>> typed_again(floor=0.02, own=None, test_runs=["TC_35", "ZZ 20"])
    " --floor 0.02 --test-runs TC_35 --test-runs 'ZZ 20'"
    """
    found = []
    for name, value in stated(**options).items():
        for one in value if isinstance(value, list) else [value]:
            text = f"{one:g}" if isinstance(one, float) else _quoted(one)
            found.append(f" --{name.replace('_', '-')} {text}")
    return "".join(found)


def _quoted(value: str | Path) -> str:
    return quoted(value) if isinstance(value, Path) else shlex.quote(value)


def words(text: str | Sequence[str] | None) -> list[str]:
    """Names out of text such as memory,current, or out of several such texts."""
    texts = [text] if isinstance(text, str) else text or []
    return " ".join(texts).replace(",", " ").split()


def numbers(text: str | None) -> Sequence[float] | None:
    """Numbers out of text such as 6,9,12."""
    if text is None:
        return None
    try:
        return [float(part) for part in words(text)]
    except ValueError:
        raise typer.BadParameter(f"{text!r}: write numbers such as 6,9,12.") from None


def patterns(given: Sequence[str] | None) -> list[str] | None:
    """Patterns of runs, each option holding one or several with commas between."""
    if not given:
        return None
    return [part.strip() for text in given for part in text.split(",") if part.strip()]


def sensors_of(text: str | None) -> dict[str, float] | None:
    """Standard deviations out of text such as x=0.03,psi_deg=0.1, angles in radians."""
    if text is None:
        return None
    found = {}
    for part in words(text):
        name, _, value = part.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not number > 0.0:
            raise typer.BadParameter(f"{part!r}: write --sensors x=0.03,psi_deg=0.1.")
        bare = name.removesuffix("_deg")
        found[bare] = number if bare == name else math.radians(number)
    return found
