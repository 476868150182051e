"""Starts and forces of a window are those of all its averages as one normal vector."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.settling import smoothed
from pmmkit.diagnosis.free_running.slopes import Sheet

PIECES, ROWS = 9, 60
SIGMA = np.array([0.1, 0.2, 0.05])
FORCES = Forces(shares=np.array([0.03, 0.05, 0.02]), memory=1.0)


def made(tied):
    """A window of which two states show nearly the same, of columns far from one size."""
    draw = np.random.default_rng(0)
    starts = draw.normal(size=(ROWS, 6))
    starts[:, 5] = starts[:, 4] + tied * starts[:, 5]
    return Sheet(
        starts=starts * [1e4, 1.0, 1.0, 1e-3, 1.0, 1.0],
        forces=draw.normal(size=(ROWS, PIECES, 3)),
        values=draw.normal(size=(ROWS, 2)),
        errors=0.1 * draw.normal(size=ROWS),
        along=np.zeros((PIECES, 3)),
        channels=draw.integers(0, 3, ROWS),
        blocks=np.arange(ROWS),
        counts=np.full(ROWS, 4.0),
        spacing=0.5,
        begun=np.zeros(6),
        loose=np.full(6, np.inf),
    )


@pytest.mark.parametrize("tied", [1.0, 0.1, 0.01])
def test_starts_and_forces_are_those_of_generalised_least_squares(tied):
    """Forces are an Ornstein-Uhlenbeck process, starts are free."""
    sheet = made(tied)
    apart = np.abs(np.subtract.outer(np.arange(PIECES), np.arange(PIECES)))
    process = np.kron(np.exp(-0.5 * apart), np.diag(FORCES.shares**2))
    G, noise = sheet.forces.reshape(ROWS, -1), SIGMA[sheet.channels] ** 2 / sheet.counts
    white = np.linalg.inv(np.linalg.cholesky(G @ process @ G.T + np.diag(noise)))
    size = np.linalg.norm(sheet.starts, axis=0)
    basis, R = np.linalg.qr(white @ sheet.starts / size)
    start = np.linalg.solve(R, basis.T @ white @ sheet.errors) / size
    shown = sheet.starts @ (np.linalg.solve(R, basis.T @ white) / size[:, None])
    taken = shown + G @ process @ G.T @ white.T @ white @ (np.eye(ROWS) - shown)
    (found,) = smoothed([sheet], SIGMA, FORCES)
    spread = np.linalg.norm(np.linalg.inv(R), axis=1) / size
    np.testing.assert_allclose(found.start / spread, start / spread, atol=1e-4)
    left = (np.eye(ROWS) - taken) @ sheet.errors / np.sqrt(noise)
    np.testing.assert_allclose(found.left, left, atol=1e-4)
    np.testing.assert_allclose(found.leverage, np.diagonal(taken), atol=1e-4)


def test_a_start_that_nothing_measures_stays_as_near_to_zero_as_is_known():
    """Its probability is a factor of the normal vector: the mean of both, in closed form."""
    sheet = made(1.0)
    known, begun = 1e-3, 0.2
    loose = np.array([np.inf, np.inf, np.inf, np.inf, np.inf, known])
    (free,) = smoothed([sheet], SIGMA, FORCES)
    (tied,) = smoothed(
        [replace(sheet, begun=np.array([0, 0, 0, 0, 0, begun]), loose=loose)], SIGMA, FORCES
    )
    size = np.linalg.norm(
        sheet.starts / (SIGMA[sheet.channels] / np.sqrt(sheet.counts))[:, None], axis=0
    )
    variance = free.known.covariance[5, 5] / size[5] ** 2
    share = variance / (variance + known**2)
    expected = free.start[5] + share * (-begun - free.start[5])
    assert tied.start[5] == pytest.approx(expected, rel=1e-6)
    assert abs(begun + tied.start[5]) < abs(begun + free.start[5])
