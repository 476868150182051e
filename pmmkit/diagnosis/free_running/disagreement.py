"""Records that disagree with the others: a kind of manoeuvre, a side, a speed, a part of the day.

In the records of a group the water exerts F (1 + g) + a + b β in place of F in one channel, as
`Disagreement` asks it of captive runs. What a push does to the track is known from the slopes over
the unknown forces, so that no manoeuvre is sailed again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from pmmkit.base import DataError
from pmmkit.campaigns import Run, Settings
from pmmkit.conventions import CHANNELS
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.left_out import turns
from pmmkit.diagnosis.free_running.windows import RecordWindows, by_piece, piece_begins, sailed
from pmmkit.equations import State
from pmmkit.identification import FreeRecord
from pmmkit.inference import Normal
from pmmkit.intake import Disagreement
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import xarray as xr


def disagreements(fit: SetFit, null: SetFit) -> list[Disagreement]:
    """Groups of records with the evidence that they disagree, beside a fit and in its place."""
    alone = {(item.channel, item.group): item.log_odds for item in _every(null)}
    return [replace(item, instead=alone[item.channel, item.group]) for item in _every(fit)]


def _unread() -> xr.Dataset:
    raise DataError("A record stands for its run by what it was set to alone.")


def run_of(record: FreeRecord) -> Run:
    """A record as the run that it is, as far as its rudder tells."""
    put = np.flatnonzero(np.abs(record.delta) > 0.5 * np.max(np.abs(record.delta)))
    first = float(record.delta[put[0]]) if len(put) else 0.0
    return Run(
        id=record.name,
        test="turning" if turns(record) else "zigzag",
        kind="history",
        loader=_unread,
        settings=Settings(speed=record.speed, rudder=first),
    )


def _every(fit: SetFit) -> Iterator[Disagreement]:
    """All groups in all channels beside a fit."""
    stretches = fit.place.question.stretches
    records = [item.record for item in stretches]
    groups = Run.groups([run_of(x) for x in records], list(range(len(records))))
    numbers = fit.place.question.numbers
    at = numbers.used(fit.names)
    root = block_diag(numbers.base.root(fit.spread), np.eye(len(at) - numbers.width))
    channels = CHANNELS[: len(stretches[0].units)]
    price = Disagreement.price(len(groups), len(channels))
    patterns = [_patterns(item, fit) for item in stretches]
    every = np.concatenate([window for own in patterns for window in own])
    sizes = np.sqrt(np.mean(every[:, :, 0] ** 2, axis=0))
    steepest = float(np.max(np.abs(every[:, :, 2]))) or 1.0
    for c, channel in enumerate(channels):
        size = np.array([1.0, sizes[c], sizes[c] / steepest])
        only = np.eye(len(channels))[c][:, None]
        pushed = [[(x[:, c] * size)[:, None] * only for x in own] for own in patterns]
        known = fit.place.information.with_pushes(pushed).under(fit.forces)
        whole = known.products.sum(axis=0)
        rows = np.append(3 + at, len(whole) - 1)
        normal = Normal.of_products(whole[np.ix_(rows, rows)]).in_terms_of(root)
        for words, members in groups.items():
            mine = [item.name in members for item in records]
            own = known.products[mine].sum(axis=0)
            found = normal.added(own[:3, :3], own[:3, -1], root.T @ own[3 + at, :3], Run.OTHERWISE)
            yield Disagreement.of(channel, words, members, found, found, price=price)


def _patterns(stretch: RecordWindows, fit: SetFit) -> list[Array]:
    """What a group may have otherwise in the pieces of each window (p, f, 3): the force on the
    ship along the path, over ½ρLdU² (½ρL²dU²), one, and the drift angle [rad]."""
    question = fit.place.question
    states = sailed(stretch, question.numbers.T @ fit.place.z)
    motion = {name: states[:, getattr(State, name)] for name in ("u", "v", "r")}
    ends = list(zip(stretch.begins[:-1].tolist(), stretch.begins[1:].tolist(), strict=True))
    for name in ("u", "v", "r"):
        motion[f"{name}dot"] = np.concatenate(
            [np.gradient(motion[name][a:b], stretch.record.t[a:b]) for a, b in ends]
        )
    exerted = question.model.ship.rigid_body_forces(motion)
    count = len(stretch.units)
    force = np.column_stack([exerted[name] for name in CHANNELS[:count]]) / stretch.units
    drift = np.arctan2(-motion["v"], motion["u"])
    every = np.stack([force, np.ones_like(force), np.tile(drift[:, None], count)], axis=2)
    pieces = by_piece(stretch, every.reshape(len(every), -1)).reshape(-1, count, 3)
    return np.split(pieces, np.searchsorted(piece_begins(stretch), stretch.begins[1:-1]))
