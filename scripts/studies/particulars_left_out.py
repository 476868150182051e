"""Particulars of a model on a balance that are left out or wrong: what each campaign gets.

    python -m scripts.studies.particulars_left_out

A little tank that shares no code with the package tows and swings a hull whose derivatives are
known. Its campaign file then says nothing of a particular, or a wrong one. Told are the derivatives
that are off by more than their interval, the worst in half-widths, and what check and verdict say.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import pmmkit as pk
from pmmkit.base import PmmkitError
from pmmkit.conventions import Structure
from pmmkit.intake import examine
from pmmkit.presentation import WIDE
from pmmkit.reduction import reduce_campaign
from tests.support import own_tank

CAMPAIGNS = {
    "drift, sway, yaw": own_tank.PROGRAMME,
    "sway alone": tuple(x for x in own_tank.PROGRAMME if "pure_sway" in x.keys),
    "drift and yaw": tuple(x for x in own_tank.PROGRAMME if "pure_sway" not in x.keys),
}


OWN = Structure(name="little hull", derivatives=tuple(own_tank.TRUTH))


def without(name: str) -> Callable[[str], str]:
    """Take a line of [ship] away."""
    return lambda text: re.sub(rf"^{name} = .*\n", "", text, flags=re.MULTILINE)


def to(name: str, value: float) -> Callable[[str], str]:
    """Write another value."""
    return lambda text: re.sub(rf"^{name} = .*$", f"{name} = {value}", text, flags=re.MULTILINE)


CASES = {
    "as it is": lambda text: text,
    "xG left out (truth 0.015 L)": without("xG"),
    "xG 30 % off": to("xG", 1.3 * own_tank.XG),
    "xG of the other sign": to("xG", -own_tank.XG),
    "Izz left out": without("Izz"),
    "Izz 30 % too large": to("Izz", 1.3 * own_tank.IZZ),
    "Izz 30 % too small": to("Izz", 0.7 * own_tank.IZZ),
    "mass left out (volume is stated)": without("mass"),
    "mass 30 % too large": to("mass", 1.3 * own_tank.MASS),
}


def row(folder: Path, change: Callable[[str], str]) -> list[str]:
    """What a campaign gets: derivatives that are off, what is said, the verdict."""
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(change(text), encoding="utf-8")
    try:
        campaign = pk.open_campaign(folder)
        said = [f"{x.severity}: {x.message.split('.')[0]}" for x in examine(campaign)]
        result = reduce_campaign(campaign, structure=OWN, fn="pooled", check=False)
    except PmmkitError as error:
        return ["-", "-", f"refused: {str(error).splitlines()[0]}", ""]
    finally:
        file.write_text(text, encoding="utf-8")
    table = result.table
    off = {
        name: abs(value - own_tank.TRUTH[name]) / (WIDE * std)
        for name, value, std in zip(table.names, table.value[0], table.std[0], strict=True)
        if name in own_tank.TRUTH and np.isfinite(std) and std > 0.0
    }
    wrong = sorted((name for name in off if off[name] > 1.0), key=lambda name: -off[name])
    words = ", ".join(f"{name} {off[name]:.1f}" for name in wrong[:4]) or "none"
    return [
        f"{len(wrong)} of {len(off)}",
        words,
        "; ".join(said) or "-",
        str(result.verdict).splitlines()[0],
    ]


def main() -> None:
    """The table."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        for kind, tests in CAMPAIGNS.items():
            folder = own_tank.write(Path(place) / kind.replace(" ", "_"), tests)
            rows += [[kind, case, *row(folder, change)] for case, change in CASES.items()]
    for line in [["campaign", "what is stated", "off", "half-widths", "check", "verdict"], *rows]:
        print(f"| {' | '.join(line)} |")


if __name__ == "__main__":
    main()
