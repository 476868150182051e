"""How stated uncertainties enter: one table for campaign file, reduction and comparison."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_campaign

import pmmkit as pk
from pmmkit import reduce_campaign
from pmmkit.base import DataError
from pmmkit.campaigns import Settings, TypeB
from pmmkit.reduction import altered, idle
from pmmkit.reduction.observations.equations import residuals
from pmmkit.reduction.observations.stated import INERTIA, RIG
from pmmkit.validation.captive import compare_captive

WHOLE = {name for name, item in TypeB.STATABLE.items() if item.of in ("water", "rig")}
"""What there is one of in a campaign: it can be changed there for an independent truth."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return small_campaign.write_campaign(tmp_path_factory.mktemp("stated") / "small")


def in_memory(run):
    data = run.data
    return run.with_(loader=lambda: data)


@pytest.fixture(scope="module")
def small(folder):
    """Every kind of test at one speed, read once."""
    opened = pk.open_campaign(folder)
    return opened.with_(runs=tuple(in_memory(x) for x in opened if x.settings.speed == 1.0))


@pytest.fixture(scope="module")
def balance(small):
    """As if the balance felt the model, its points off midship."""
    runs = tuple(run.with_(forces="balance") for run in small)
    return small.with_(runs=runs, moment_reference_x=0.2, motion_reference_x=-0.1)


@pytest.fixture(scope="module")
def model():
    table = pk.from_values(small_campaign.TRUTH, ship=pk.load_ship("s175-3dof"), water=pk.Water())
    return pk.to_model(table, parts="s175-3dof")


def moved(campaign, name, step):
    """The campaign as if a source were wrong by a step."""
    if name == "rho":
        return campaign.with_(water=replace(campaign.water, rho=campaign.water.rho + step))
    if hasattr(campaign, name):
        return campaign.with_(**{name: getattr(campaign, name) + step})
    return campaign.with_(
        ship=replace(campaign.ship, **{name: getattr(campaign.ship, name) + step})
    )


# What may be stated


def test_all_that_can_be_stated_is_known_to_the_room_that_says_what_it_does():
    of = {
        kind: {x.name for x in TypeB.STATABLE.values() if x.of == kind}
        for kind in ("rig", "setting")
    }
    assert of["rig"] == {*RIG, "moment_reference_x"}
    assert of["setting"] <= set(Settings.__dataclass_fields__)
    assert set(RIG) >= INERTIA


@pytest.mark.slow
def test_every_source_can_be_stated_in_a_campaign_file_and_written_again(folder, tmp_path):
    lines = [
        f"{item.key} = {{ std = 0.25, unit = {item.unit!r} }}" for item in TypeB.STATABLE.values()
    ]
    made = small_campaign.write_campaign(tmp_path / "all")
    toml = made / "campaign.toml"
    toml.write_text(
        toml.read_text(encoding="utf-8").replace(
            "[water]", "\n".join(["[uncertainty]", *lines, "", "[water]"]), 1
        ),
        encoding="utf-8",
    )
    opened = pk.open_campaign(made)
    assert {item.name for item in opened.uncertainty} == set(TypeB.STATABLE)
    for item in opened.uncertainty:
        expected = math.radians(0.25) if item.kind.unit == "deg" else 0.25
        assert (item.std, item.shared) == (pytest.approx(expected), item.kind.single)
    pk.export(opened, tmp_path / "again")
    assert set(pk.open_campaign(tmp_path / "again").uncertainty) == set(opened.uncertainty)


def test_errors_of_one_cause_are_stated_in_a_campaign_file(tmp_path):
    made = small_campaign.write_campaign(tmp_path / "common")
    toml = made / "campaign.toml"
    text = toml.read_text(encoding="utf-8")
    stated = 'Y_gauge = { std = 0.2, unit = "%", common = "weights" }'
    toml.write_text(text.replace("[water]", f"[uncertainty]\n{stated}\n\n[water]", 1), "utf-8")
    (source,) = pk.open_campaign(made).uncertainty
    assert source == TypeB(name="Y_gauge", std=0.002, relative=True, shared=True, common="weights")
    pk.export(pk.open_campaign(made), tmp_path / "again")
    assert pk.open_campaign(tmp_path / "again").uncertainty == (source,)
    wrong = stated.replace(" }", ", shared = false }")
    toml.write_text(text.replace("[water]", f"[uncertainty]\n{wrong}\n\n[water]", 1), "utf-8")
    with pytest.raises(DataError, match="all runs share it"):
        pk.open_campaign(made)


def test_the_page_on_files_lists_all_that_can_be_stated():
    page = Path(__file__).parents[2] / "docs" / "formats.md"
    section = page.read_text(encoding="utf-8").partition("### `[uncertainty]`")[2].partition("###")
    listed = section[0].partition("What can be stated")[2]
    assert set(re.findall(r"`(\w+)`", listed)) == {item.key for item in TypeB.STATABLE.values()}


def test_what_cannot_be_stated_is_refused_with_the_nearest_name():
    with pytest.raises(DataError, match="did you mean 'motion_reference_x'"):
        TypeB(name="motion_reference", std=0.1)


# What it does


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(WHOLE))
def test_the_comparison_changes_as_if_the_campaign_said_otherwise(balance, model, name):
    """Truth: the comparison once more with the campaign changed by one standard uncertainty."""
    std = {"mass": 3.0, "Izz": 10.0, "rho": 2.0}.get(name, 0.03)
    source = TypeB(name=name, std=std, shared=True)
    stated, _ = compare_captive(model, balance.with_(uncertainty=(source,)), floor=0.0)
    other, _ = compare_captive(model, moved(balance, name, std), floor=0.0)
    largest = 0.0
    for run, there in zip(stated, other, strict=True):
        for channel in "XYN":
            change = np.abs(there.error(channel) - run.error(channel))
            size = np.abs(run.predicted[channel]).max() + 1e-3
            np.testing.assert_allclose(
                run.shares["stated"][channel], change, rtol=1e-6, atol=1e-9 * size
            )
            largest = max(largest, change.max() / size)
    assert largest > 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("channel", ["X", "Y", "N"])
def test_the_comparison_changes_as_if_a_gauge_read_otherwise(balance, model, channel, relative):
    """Truth: the comparison once more with all samples of the channel as they would be read."""
    std = 0.01 if relative else 0.5

    def read(run):
        data = run.data
        wrong = data[channel] * (1.0 + std) if relative else data[channel] + std
        return run.with_(loader=lambda: data.assign({channel: wrong}))

    source = TypeB(name=f"{channel}_gauge", std=std, relative=relative, shared=True)
    stated, _ = compare_captive(model, balance.with_(uncertainty=(source,)), floor=0.0)
    other, _ = compare_captive(
        model, balance.with_(runs=tuple(read(run) for run in balance)), floor=0.0
    )
    for run, there in zip(stated, other, strict=True):
        for name in "XYN":
            change = np.abs(there.error(name) - run.error(name))
            size = np.abs(run.view.force[name]).max() + 1.0
            np.testing.assert_allclose(
                run.shares["stated"][name], change, rtol=1e-6, atol=1e-9 * size
            )
        assert np.any(run.shares["stated"][channel])


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*WHOLE, "L"}))
def test_the_reduction_changes_as_if_the_campaign_said_otherwise(balance, name):
    """Truth: the equations of all runs with the campaign changed by one standard uncertainty."""
    std = {"mass": 3.0, "Izz": 10.0, "rho": 2.0}.get(name, 0.03)
    source = TypeB(name=name, std=std, shared=True)
    stated = reduce_campaign(balance.with_(uncertainty=(source,)), check=False)
    other = reduce_campaign(moved(balance, name, std), check=False)
    values = dict(zip(stated.table.names, stated.table.value[0], strict=True))
    largest = 0.0
    for own, there, (change,) in zip(stated.rows, other.rows, stated.sensitivities, strict=True):
        for channel in "XYN":
            vector = [values.get(term, 0.0) for term in own.names[channel]]
            before, after = (x.force[channel] - x.design[channel] @ vector for x in (own, there))
            size = np.abs(own.force[channel]).max()
            (told,) = residuals([change], channel, values)
            np.testing.assert_allclose(told, after - before, rtol=2e-3, atol=2e-5 * size)
            largest = max(largest, np.abs(told).max() / size)
    assert largest > 1e-4


def test_a_gain_of_the_sway_force_moves_the_moments_that_refer_elsewhere(balance):
    run, rig = balance.runs[0], balance.rig
    found = altered(
        TypeB(name="Y_gauge", std=0.01, relative=True),
        run,
        rig,
        labels=("C0",),
        force={"Y": np.array([50.0]), "N": np.array([7.0])},
        rho=1000.0,
    )
    assert found.force["Y"].tolist() == [0.5]
    assert found.force["N"].tolist() == [pytest.approx(0.2 * 0.5)]


@pytest.mark.parametrize("name", ["Y_from_X", "N_from_Y"])
def test_cross_talk_shows_a_share_of_another_channel(balance, name):
    """With the moments about a point .2 m forward, a sway force too large is a moment too."""
    force = {"X": np.array([-20.0]), "Y": np.array([50.0]), "N": np.array([7.0])}
    found = altered(
        TypeB(name=name, std=0.01, shared=True),
        balance.runs[0],
        balance.rig,
        labels=("C0",),
        force=force,
        rho=1000.0,
    )
    moved = {channel: float(x[0]) for channel, x in found.force.items()}
    expected = {"Y": -0.2, "N": 0.2 * -0.2} if name == "Y_from_X" else {"N": 0.5}
    assert moved == pytest.approx(expected)


# What does nothing is said


@pytest.mark.slow
def test_what_no_run_feels_is_said_by_both_rooms(small, model):
    stated = (
        TypeB(name="mass", std=1.0, shared=True),
        TypeB(name="K_gauge", std=1.0, shared=True),
        TypeB(name="drift", std=0.01),
        TypeB(name="radius", std=0.1),
    )
    said = "No run feels what [uncertainty] states of mass, K_gauge, radius"
    campaign = small.with_(uncertainty=stated)
    assert any(note.startswith(said) for note in reduce_campaign(campaign, check=False).notes)
    assert any(note.startswith(said) for note in compare_captive(model, campaign, floor=0.0)[1])
    assert idle(stated[2:3], [(run, ("X", "Y", "N")) for run in small]) == ()
