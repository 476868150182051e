"""What the campaign file corrects in a run, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns.stated_run import Correction
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS, unit_factor
from pmmkit.numerics import Array
from pmmkit.presentation import with_uncertainty
from pmmkit.signals import FEWEST, head_rest, steady_mean

OF_SAMPLES = frozenset({"scale", "shift", "flip", "trim", "drop", "tare"})
"""Actions that change the numbers of a run; the others change what is said of it."""


def correct(
    data: Mapping[str, Array], corrections: Sequence[Correction], *, file: str, run: str
) -> tuple[dict[str, Array], list[str], dict[str, tuple[float, float]]]:
    """Channels with the corrections of the campaign file, in its order.

    Values are SI, in ship axes and our signs: corrections come after all conversions. Of harmonics
    ``scale`` and ``flip`` change all parts of a channel, ``shift`` its mean; ``tare`` takes off
    what the forces show while the carriage stands.
    """
    out = dict(data)
    notes: list[str] = []
    tared: dict[str, tuple[float, float]] = {}
    problems: list[Problem] = []
    for correction in corrections:
        if correction.action not in OF_SAMPLES:
            continue
        if correction.action == "trim":
            kept = _trimmed(out, correction)
            if kept is None:
                problems.append(
                    Problem(
                        message=f"the correction {_range(correction)} leaves no samples; they are "
                        f"from t = {out['t'][0]:g} to {out['t'][-1]:g} s."
                        if "t" in out
                        else "the correction trim needs a history; this is a row of a table.",
                        file=file,
                        run=run,
                    )
                )
                continue
            out = kept
            notes.append(f"{_range(correction)} ({correction.reason})")
            continue
        if correction.action == "tare":
            try:
                out, note, zeros = _tared(out, correction)
                tared |= zeros
                notes.append(f"{note} ({correction.reason})")
            except DataError as error:
                problems += [replace(item, file=file, run=run) for item in error.problems]
            continue
        for channel in correction.values["channels"]:
            names = _names(out, channel)
            if not names:
                problems.append(
                    Problem(
                        message=f"the correction {correction.action!r} names channel {channel}, "
                        f"which this run does not have: {', '.join(out)}.",
                        file=file,
                        run=run,
                    )
                )
            out, note = _changed(out, names, channel, correction)
            notes.append(f"{note} ({correction.reason})")
    if problems:
        raise CampaignError(problems)
    return out, notes, tared


def shift_in_si(channel: str, value: float, unit: str | None) -> float | None:
    """A shift in the SI unit of its channel; None if the unit measures something else."""
    if unit is None:
        return value
    si, factor = unit_factor(unit)
    return value * factor if si == CHANNEL_UNITS[channel] else None


def _names(data: Mapping[str, Array], channel: str) -> list[str]:
    return [
        name
        for name in (channel, f"{channel}_std", f"{channel}_cos", f"{channel}_sin")
        if name in data
    ]


def _changed(
    data: dict[str, Array], names: Sequence[str], channel: str, correction: Correction
) -> tuple[dict[str, Array], str]:
    out = dict(data)
    if correction.action == "drop":
        for name in names:
            del out[name]
        return out, f"correction: {channel} dropped"
    if correction.action == "shift":
        value = float(correction.values["value"])
        for name in names:
            if name == channel:
                out[name] = out[name] + value
            elif name.endswith("_cos"):
                out[name] = out[name] + np.where(np.arange(len(out[name])) == 0, value, 0.0)
        return out, f"correction: {channel} shifted by {value:g} {CHANNEL_UNITS[channel]}"
    factor = float(correction.values["factor"]) if correction.action == "scale" else -1.0
    for name in names:
        out[name] = out[name] * (abs(factor) if name.endswith("_std") else factor)
    how = f"times {factor:g}" if correction.action == "scale" else "sign changed"
    return out, f"correction: {channel} {how}"


def _trimmed(data: dict[str, Array], correction: Correction) -> dict[str, Array] | None:
    if "t" not in data:
        return None
    start = correction.values.get("t_start", -np.inf)
    end = correction.values.get("t_end", np.inf)
    inside = (data["t"] >= start) & (data["t"] <= end)
    return {name: numbers[inside] for name, numbers in data.items()} if inside.any() else None


def _tared(
    data: Mapping[str, Array], correction: Correction
) -> tuple[dict[str, Array], str, dict[str, tuple[float, float]]]:
    """Channels without what they show at rest: from the times stated, else at the head."""
    named = correction.values.get("channels", [name for name in CHANNELS if name in data])
    absent = [name for name in named if name not in data]
    if "t" not in data or absent or not named:
        what = f"channels {', '.join(absent)}, which this run does not have" if absent else "forces"
        raise DataError(f"the correction 'tare' needs a history with {what}.")
    t, forces = data["t"], np.stack([data[name] for name in named])
    inside = _at_rest(data, correction)
    zero = steady_mean(t[inside], forces[:, inside])
    seconds = float(np.ptp(t[inside]))
    told = ", ".join(
        f"{name} {with_uncertainty(float(x), float(s))} {CHANNEL_UNITS[name]}"
        for name, x, s in zip(named, zero.value, zero.std, strict=True)
    )
    shifted = {name: data[name] - x for name, x in zip(named, zero.value, strict=True)}
    note = f"correction: tared by {seconds:.3g} s of rest: {told} taken off"
    zeros = zip(zero.value.tolist(), zero.std.tolist(), strict=True)
    return {**data, **shifted}, note, dict(zip(named, zeros, strict=True))


def _at_rest(data: Mapping[str, Array], correction: Correction) -> NDArray[np.bool_]:
    """The samples from which the zero is taken."""
    t = data["t"]
    if {"t_start", "t_end"} & set(correction.values):
        low, high = (
            correction.values.get("t_start", -np.inf),
            correction.values.get("t_end", np.inf),
        )
        inside: NDArray[np.bool_] = (t >= low) & (t <= high)
        if np.count_nonzero(inside) < FEWEST:
            raise DataError(
                f"the correction 'tare' takes the rest from t = {low:g} to {high:g} s, where there "
                f"are fewer than {FEWEST} samples: the record runs from {t[0]:g} to "
                f"{t[-1]:g} s."
            )
        return inside
    forces = [data[name] for name in CHANNELS if name in data]
    found = head_rest(t, np.stack(forces)) if "X" in data else None
    if found is None:
        raise DataError(
            "the correction 'tare' finds no rest at the head of the record: state t_start and "
            "t_end, or leave this run out of the correction (tare = false where [defaults] tare)."
        )
    return np.arange(len(t)) < found.stop


def _range(correction: Correction) -> str:
    bounds = [
        f"{word} t = {correction.values[key]:g} s"
        for word, key in (("from", "t_start"), ("to", "t_end"))
        if key in correction.values
    ]
    return f"correction: trimmed {' '.join(bounds)}"
