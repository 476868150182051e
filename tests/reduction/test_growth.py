"""Tests over several depths: how derivatives grow, typed and in Python."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest
from commands import rows_of, said
from small_campaign import TRUTH, write_depths

import pmmkit as pk
from pmmkit.conventions import Ship, Water
from pmmkit.effects.shallow_water import factors
from pmmkit.models import TablesByDepth
from pmmkit.reduction import Growth
from pmmkit.reduction.depths import TOLD, Felt, reduce_depths

SHALLOW = 1.6
"""What side force and moment of the shallow tests are multiplied by."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_depths(tmp_path_factory.mktemp("depths") / "tests", {0.48: 1.0, 0.36: SHALLOW})


@pytest.fixture(scope="module")
def reductions(folder):
    return reduce_depths(pk.open_campaign(folder), fn="pooled", executor=1)


@pytest.mark.slow
def test_derivatives_of_each_depth_are_those_that_made_its_forces(reductions):
    for reduction, factor in zip(reductions, (1.0, SHALLOW), strict=True):
        table = reduction.table
        truth = np.array(
            [TRUTH[name] * (1.0 if name[0] == "X" else factor) for name in table.names]
        )
        away = (table.value[0] - truth) / table.std[0]
        assert np.max(np.abs(away)) < 4.5


@pytest.mark.slow
def test_growth_is_found_within_its_interval(reductions):
    grown = Growth.of(TablesByDepth(tables=tuple(item.table for item in reductions)))
    assert [item.name for item in grown] == list(TOLD)
    for item in grown:
        true = 1.0 if item.name[0] == "X" else SHALLOW
        assert abs(item.factor - true) < 1.5 * item.half, item
        assert item.half < (1.0 if item.name == "Nrdot" else 0.5)


@pytest.mark.slow
def test_the_command_gives_every_depth_a_folder_and_says_how_they_grow(folder, tmp_path, capsys):
    out = tmp_path / "r"
    order = ["reduce", folder, "--fn", "pooled", "--parts", "s175-3dof", "--out", out]
    status, told, words = said(capsys, *order)
    assert status == 0
    assert [round(item["h_T"], 2) for item in told["depths"]] == [2.03, 1.52]
    for item in ("depth-2.03", "depth-1.52"):
        assert (out / item / "report.html").is_file()
    rows = rows_of(out / "derivatives_by_depth.csv")
    assert len(rows) == 2 * len(TRUTH)
    (Yv,) = (row for row in told["growth"] if row["derivative"] == "Yv")
    assert Yv["ci_low"] < SHALLOW < Yv["ci_high"]
    assert "How derivatives grow from h/T 2.033" in words
    model = pk.load_model(out / "depth-1.52" / "model.toml")
    assert model.water.depth == pytest.approx(0.36 * model.ship.d / 0.236111)
    order = ["sweep", out, "--depths", "1.6,1.9", "--speeds", "8", "--out", tmp_path / "s"]
    status, told, words = said(capsys, *order)
    assert status == 0
    with (tmp_path / "s" / "sweep.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["h_T"]) for row in rows] == [1.9, 1.6]
    circles = [float(row["tactical_diameter_L"]) for row in rows]
    law = [float(row["tactical_diameter_L_formula"]) for row in rows]
    assert circles[1] > circles[0] > 0.0
    assert all(math.isfinite(x) for x in law)
    assert "straight lines over T/h" in words
    status = said(capsys, "sweep", out, "--depths", "1.2", "--speeds", "8")[0]
    assert status == 1
    half = len(pk.open_campaign(folder)) // 2
    for job in ("compare", "diagnose"):
        order = [job, out / "depth-1.52" / "model.toml", folder, "--no-figures"]
        status, told, words = said(capsys, *order, "--out", tmp_path / job)
        assert status == 0
        assert f"In water of 0.36 m, as the model: {half} of {2 * half} runs." in words
    status, _, words = said(capsys, "compare", "s175-3dof", folder, "--out", tmp_path / "c")
    assert status == 1
    assert "name a model of one of them" in words


def test_growth_is_the_ratio_with_the_errors_of_both():
    ship = Ship(name="KVLCC2", L=320.0, B=58.0, d=20.8, volume=312600.0, mass=3.2e8, Izz=2e12)
    deep, shallow = (
        pk.from_values({"Yv": x}, std={"Yv": 0.01}, Fn=[0.1], ship=ship, water=Water(depth=h))
        for x, h in ((-0.4, 41.6), (-0.6, 31.2))
    )
    (item,) = Growth.of(TablesByDepth(tables=(deep, shallow)))
    assert item.factor == pytest.approx(1.5)
    assert item.std == pytest.approx(math.hypot(0.01 / 0.4, 1.5 * 0.01 / 0.4))
    assert item.formula == pytest.approx(1.90 / 1.32, rel=0.01)  # Hirano's, from deep water


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
def test_the_share_of_the_formulas_that_a_hull_feels_is_found(share):
    """Derivatives at 2 and 1.5 draughts made by the effect itself, one of them 5 % off."""
    ship = Ship(name="KVLCC2", L=320.0, B=58.0, d=20.8, volume=312600.0, mass=3.2e8, Izz=2e12)
    deep_water = {"Yv": -0.3, "Nv": -0.13, "Nr": -0.05, "Yvdot": -0.22, "Nrdot": -0.011}

    def at(depth, off=1.0):
        grown = factors(depth, ship.d, ship.L, ship.B, ship.block, share=share)
        values = {name: x * grown[name] for name, x in deep_water.items()}
        values["Nr"] *= off
        std = {name: 0.01 * abs(x) for name, x in values.items()}
        return pk.from_values(values, std=std, Fn=[0.1], ship=ship, water=Water(depth=depth))

    (found,) = Felt.of(Growth.of(TablesByDepth(tables=(at(41.6), at(31.2)))))
    assert found.share == pytest.approx(share, abs=1e-6)
    assert found.left < 1e-6
    assert (found.without < 1e-6) == (share == 0.0)
    (off,) = Felt.of(Growth.of(TablesByDepth(tables=(at(41.6), at(31.2, off=1.05)))))
    assert abs(off.share - share) < off.half
    assert off.half > found.half
    assert f"{ship.d * 1.5 / ship.d:.4g}" in str(off)
