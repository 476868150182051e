"""What to type first: the stages of the work, and the next command for what a folder holds."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Final

from pmmkit.presentation import quoted

STORY: Final = (
    ("measure", "pmmkit inspect FOLDER", "what your files hold: columns, units, kinds of test"),
    ("", "pmmkit new-campaign FOLDER", "a campaign out of them; it asks what no file tells"),
    ("", "pmmkit check CAMPAIGN", "what contradicts itself: signs, units, inertia, clocks"),
    ("model", "pmmkit reduce CAMPAIGN", "derivatives with intervals, and a model"),
    ("predict", "pmmkit simulate MODEL", "turns, zigzags, stops"),
    ("explain", "pmmkit compare MODEL CAMPAIGN", "where the model fails"),
    ("", "pmmkit diagnose MODEL CAMPAIGN", "which physical effect it lacks"),
    ("", "pmmkit add MODEL EFFECT ...", "the model with it; the error falls"),
    ("hand in", "pmmkit report CAMPAIGN", "the test report; also imo, export"),
)
"""Stages, a command of each, and what it is for."""
HELD: Final = frozenset(
    {".csv", ".txt", ".dat", ".asc", ".tsv", ".out", ".tdms", ".mat", ".h5", ".hdf5", ".nc"}
    | {".xls", ".xlsx", ".xlsm", ".xlsb", ".ods"}
)
"""Endings of files that hold measurements more often than not."""
MOST: Final = 2_000
"""Entries of a folder that are looked at: what is in a home folder need not be known."""


def first_steps(folder: Path) -> str:
    """The stages of the work, and what of it lies in a folder with the command for it.

    Parameters
    ----------
    folder : Path
        Where the user is.

    Returns
    -------
    str

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as name:
    ...     print(first_steps(Path(name)).splitlines()[-2])
      pmmkit demo                     a demonstration: tests of a container ship to a turn
    """
    seen, command = _here(folder)
    lines = [
        "Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres.",
        "",
        *(f"  {stage:<9}{typed:<32}{what}" for stage, typed, what in STORY),
        "",
        *([f"Here: {seen} Type:", "", f"  {command}", "", "Or:", ""] if command else ["Type:", ""]),
        f"  {'pmmkit demo':<32}a demonstration: tests of a container ship to a turn",
        f"  {'pmmkit --help':<32}all commands; pmmkit COMMAND --help has an example",
    ]
    return "\n".join(lines)


def _here(folder: Path) -> tuple[str, str]:
    """What lies in a folder in a sentence, and the next command; nothing where nothing does."""
    try:
        entries = [path for path, _ in zip(sorted(folder.iterdir()), range(MOST), strict=False)]
    except OSError:
        return "", ""
    inside = [path for path in entries if path.is_dir() and not path.name.startswith(".")]
    campaigns = [path for path in (folder, *inside) if (path / "campaign.toml").is_file()]
    models = [path / "model.toml" for path in inside if (path / "model.toml").is_file()]
    if models:
        model = _named(max(models, key=lambda path: path.stat().st_mtime), folder)
        if campaigns:
            campaign = _named(campaigns[0], folder)
            return f"a model, {model}, and a campaign.", f"pmmkit compare {model} {campaign}"
        return f"a model, {model}.", f"pmmkit simulate {model} --rudder-deg 35"
    if campaigns:
        campaign = _named(campaigns[0], folder)
        return f"a campaign, {campaign}.", f"pmmkit check {campaign}"
    found = Counter(path.suffix.lower() for path in entries if path.suffix.lower() in HELD)
    if found:
        counted = ", ".join(f"{count} {ending}" for ending, count in found.most_common(3))
        return f"files that may hold tests ({counted}).", "pmmkit demo --my-data ."
    cases = [path for path in (folder, *inside) if (path / "constant").is_dir()]
    if cases:
        return "cases of OpenFOAM.", f"pmmkit demo --my-data {_named(cases[0], folder)}"
    return "", ""


def _named(path: Path, folder: Path) -> str:
    """A path as it is typed from the folder."""
    return quoted(path.relative_to(folder))
