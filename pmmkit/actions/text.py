"""What is read out of the text of a setting, and what is made of text to be typed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pmmkit.actions.setting import SettingError


def cycles_of(text: str | None) -> int | tuple[int, int] | None:
    """Cycles out of text such as 3 or 3-6."""
    if text is None:
        return None
    first, dash, last = text.partition("-")
    try:
        return (int(first), int(last)) if dash else int(first)
    except ValueError:
        raise SettingError(f"{text!r}: write one cycle (3) or a range (3-6).") from None


def stem(path: str | Path) -> str:
    """Name for a folder of results: that of the campaign's folder, or of the file."""
    full = Path(path).resolve()
    named = full.parent if full.name == "campaign.toml" else full
    files = (".toml", ".h5", ".hdf5", ".nc", ".csv", ".mgf", ".zip")
    return named.stem if named.suffix in files else named.name


def present(**settings: Any) -> dict[str, Any]:
    """The settings that are not None."""
    return {name: value for name, value in settings.items() if value is not None}


def orders_of(given: Sequence[str]) -> dict[str, float]:
    """Settings of a manoeuvre out of text such as executes=7."""
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[name.strip().replace("-", "_")] = float(value)
        except ValueError:
            raise SettingError(f"{text!r}: write --set executes=7.") from None
    return found


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
        raise SettingError(f"{text!r}: write numbers such as 6,9,12.") from None


def patterns(given: Sequence[str]) -> list[str] | None:
    """Patterns of runs, each text holding one or several with commas between; None for all."""
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
            raise SettingError(f"{part!r}: write --sensors x=0.03,psi_deg=0.1.")
        bare = name.removesuffix("_deg")
        found[bare] = number if bare == name else math.radians(number)
    return found
