"""Runs of a ship that propels herself: what their resistance is, and what it is not."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from small_campaign import RHO, L, write_campaign

import pmmkit as pk
from pmmkit.api import model_of
from pmmkit.models.estimates import resistance_derivative
from pmmkit.reduction import reduce_campaign

THRUST = 3.8e-4
"""Over ½ρL²U²: nine tenths of the resistance of the small programme."""


def with_thrust(folder, noise):
    """Records of a propeller whose revolutions go with the speed, its thrust measured."""
    write_campaign(folder, thrust=0.8 * THRUST)
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    rng = np.random.default_rng(5)
    entries = text.split("[[runs]]")[1:]
    for entry in entries:
        name = entry.split('id = "')[1].split('"')[0]
        speed = float(entry.split("speed = ")[1].split()[0])
        text = text.replace(entry, entry.replace("rps = 8.0", f"rps = {4.0 * speed}"))
        file = folder / "runs" / f"{name}.csv"
        with file.open(encoding="utf-8", newline="") as stream:
            head, *rows = list(csv.reader(stream))
        mean = 0.5 * RHO * (L * speed) ** 2 * THRUST * (1.0 + noise * rng.normal())
        with file.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream).writerows([[*head, "T"], *([*row, f"{mean:.6g}"] for row in rows)])
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return pk.open_campaign(folder)


@pytest.fixture(scope="module", params=["measured", "not measured"])
def reduction(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("thrust") / "tests"
    if request.param == "measured":
        campaign = with_thrust(folder, noise=0.01)
    else:
        campaign = pk.open_campaign(write_campaign(folder, thrust=0.8 * THRUST))
    return reduce_campaign(campaign, executor=1)


@pytest.mark.slow
def test_thrust_that_goes_with_the_speed_is_not_parted_from_the_resistance(reduction):
    """Its share comes from the noise of the thrust alone: no propeller's, or none."""
    assert reduction.verdict.use == "usable with doubts"
    (doubt,) = (text for text in reduction.verdict.doubts if "thrust less resistance" in text)
    assert "0.145, 0.290" in doubt
    assert not any("contradict" in text or "Xuu," in text for text in reduction.verdict.reasons)


@pytest.mark.slow
def test_the_model_has_a_resistance_and_not_what_the_thrust_left_of_it(reduction):
    table, model = reduction.table, model_of(reduction)
    known, _ = resistance_derivative(table.ship, table.water, 1.5, table.convention)
    found = np.atleast_1d(model.values("hull_polynomial", model.Fn[0])["Xuu"])
    assert abs(table["Xuu"][0]) < 0.4 * abs(found[0])
    assert found[0] == pytest.approx(known, rel=0.3)
    assert model.part("hull_polynomial").source_of("Xuu").startswith("empirical")
    track = pk.simulate(model, speed=model.ship.speed(model.Fn[0], model.water.g), rudder_deg=35)
    assert 0.2 < track.metrics["speed_ratio"] < 0.9
