"""When derivatives are not usable: found, kept by the table, and no model without force."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.base import ModelError, NotUsableError
from pmmkit.imo import imo_turning
from pmmkit.inference import RunEffects
from pmmkit.models import from_values, read_table, write_table
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.between_runs import BetweenRuns
from pmmkit.reduction.verdict import _far, _massless, _scattered
from tests.support.small_campaign import write_campaign

ODD = "PS_U1_a0.3"


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return pk.open_campaign(write_campaign(tmp_path_factory.mktemp("sound") / "tests"))


def spoilt(campaign, chosen, change):
    """The campaign with the records of some runs changed."""

    def one(run):
        data = change(run.data)
        return run.with_(loader=lambda: data)

    return campaign.with_(runs=tuple(one(run) if chosen(run) else run for run in campaign))


def hundredfold(campaign):
    """One run's side force in another unit."""
    return spoilt(campaign, lambda run: run.id == ODD, lambda data: data.assign(Y=100 * data.Y))


def reduced(campaign, **options):
    return reduce_campaign(campaign, check=False, executor=1, **options)


@pytest.fixture(scope="module")
def bad(sound):
    return reduced(hundredfold(sound))


@pytest.fixture(scope="module")
def forced(bad):
    return pk.to_model(bad.table, "s175-3dof", force=True)


def test_sound_tests_are_usable_and_their_table_says_so(sound):
    found = reduced(sound)
    assert found.verdict.use == "usable"
    assert found.table.verdict == found.verdict
    assert pk.to_model(found.table, "s175-3dof").not_usable == ""


def test_a_run_beyond_thirty_standard_deviations_is_no_measurement_of_the_ship(bad):
    assert bad.verdict.use == "not usable"
    (fault,) = [text for text in bad.verdict.faults if "standard deviations" in text]
    assert ODD in fault
    assert "in Y" in fault
    assert str(bad.verdict).startswith("Not usable: ")


def test_weighed_down_it_decides_nothing(sound):
    found = reduced(hundredfold(sound), odd_runs="weigh")
    assert not [text for text in found.verdict.faults if "standard deviations" in text]


def test_two_per_cent_are_a_doubt_however_many_deviations_they_are(sound, bad):
    """A solver's forces hold no noise, and no structure is that exact."""
    near = reduced(
        spoilt(sound, lambda run: run.id == ODD, lambda data: data.assign(Y=1.02 * data.Y))
    )
    for found, fault in ((near, False), (bad, True)):
        (one,) = [x for x in found.influences.items if (x.run, x.channel) == (ODD, "Y")]
        assert _far(replace(one, departure=100.0), found.solution, found.rows) is fault
        assert not _far(replace(one, departure=20.0), found.solution, found.rows)


def test_damping_that_drives_is_of_no_hull(sound):
    """All side forces with the other sign: each family agrees with each other."""
    found = reduced(spoilt(sound, lambda run: True, lambda data: data.assign(Y=-data.Y)))
    assert "Yv is positive, which no hull has: check signs, units and inertia." in (
        found.verdict.faults
    )


@pytest.mark.parametrize(("rps", "use"), [(None, "not usable"), (8.0, "usable with doubts")])
def test_a_positive_resistance_is_a_fault_unless_a_propeller_pushes(sound, rps, use):
    """Thrust of a turning propeller may stand inside X."""

    def pushed(run):
        data = run.data.assign(X=-run.data.X)
        return run.with_(loader=lambda: data, settings=replace(run.settings, propeller_rps=rps))

    drift = [run for run in sound if run.test == "static_drift"]
    found = reduced(
        sound.with_(runs=tuple(map(pushed, drift))),
        structure=["Xuu", "Xvv", "Yv", "Yvvv", "Nv", "Nvvv"],
    )
    assert found.table["Xuu"].min() > 0
    assert found.verdict.use == use
    assert any(text.startswith("Xuu is positive") for text in found.verdict.reasons)


def test_families_that_have_nothing_in_common_contradict_each_other(sound):
    """All pure sway tests in pounds."""
    pounds = spoilt(
        sound,
        lambda run: run.test == "pure_sway",
        lambda data: data.assign({name: data[name] / 4.448 for name in "XYN"}),
    )
    found = reduced(pounds)
    told = [text for text in found.verdict.faults if "contradict each other" in text]
    assert told[0].startswith("Static drift and pure sway contradict each other: of ")
    assert not any("pure yaw" in text for text in told)


@pytest.mark.parametrize(
    ("sizes", "beyond"),
    [
        ((0.02, 0.03, 0.1, 0.02), False),
        ((0.6, 0.0, 0.0, 0.0), True),
        ((0.0, 0.0, 3.0, 0.0), True),
        ((0.0, 0.0, 0.0, 0.6), True),
    ],
)
def test_scatter_beyond_any_laboratory_is_a_fault(sizes, beyond):
    """Offset over the rms force, gain, drift setting in degrees, harmonics over the rms force."""
    scatter = RunEffects(
        nodes={"Y": np.array([sizes])},
        weights={"Y": np.ones(1)},
        scale={"Y": 10.0},
        informed={"Y": RunEffects.KINDS},
    )
    between = BetweenRuns(drift=(), readings=(), scatter=scatter)
    found = list(_scattered(SimpleNamespace(between=between)))
    assert bool(found) == beyond


def test_a_mass_matrix_must_be_positive_with_the_inertia_of_the_model(sound):
    """With Yrdot = Nvdot = k it is as long as k² < (m - Yvdot)(Izz - Nrdot)."""
    ship, rho = sound.ship, sound.water.rho
    mass, inertia = 0.5 * rho * ship.L**3, 0.5 * rho * ship.L**5
    values = {"Yvdot": -0.007, "Nrdot": -0.0004}
    product = (ship.mass / mass + 0.007) * (ship.Izz / inertia + 0.0004)
    for share, faults in ((0.98, 0), (1.02, 1)):
        k = share * np.sqrt(product)
        table = from_values(
            {**values, "Yrdot": k, "Nvdot": k}, ship=ship, water=sound.water, Fn=[0.2]
        )
        assert len(list(_massless(table))) == faults
    heavier = from_values({**values, "Yvdot": 0.02}, ship=ship, water=sound.water)
    assert "mass matrix is not positive" in "".join(_massless(heavier))


@pytest.mark.parametrize("ending", ["csv", "nc"])
def test_a_file_of_the_table_keeps_the_verdict(bad, tmp_path, ending):
    file = tmp_path / f"derivatives.{ending}"
    write_table(bad.table, file)
    read = read_table(file)
    assert read.verdict == bad.verdict
    with pytest.raises(NotUsableError, match=ODD):
        pk.to_model(read, "s175-3dof")


def test_neither_way_makes_a_model_without_force(bad):
    with pytest.raises(ModelError, match=r"force=True") as caught:
        pk.model_of(bad)
    assert "(--force)" in caught.value.said("command")
    assert isinstance(caught.value, pk.PmmkitError)
    with pytest.raises(NotUsableError):
        pk.to_model(bad.estimates["regression"].table, "s175-3dof")
    with pytest.raises(NotUsableError):
        pk.to_model(bad.table.select(["Yv", "Yr", "Nv", "Nr"]), "s175-3dof", missing="estimate")


def test_force_marks_the_model_for_ever(forced, tmp_path):
    pk.save_model(pk.scaled(forced, 100.0), tmp_path / "model.toml")
    read = pk.load_model(tmp_path / "model.toml")
    assert [step.action for step in read.steps] == ["built", "forced", "scaled"]
    assert ODD in read.not_usable
    assert "NOT USABLE" in str(read)


def test_whatever_sails_it_says_so_and_no_limit_is_settled(forced):
    track = pk.simulate(forced, speed=9.0, rudder_deg=20, extrapolate=True, compiled=False)
    assert track.standing.forced in track.standing.sentences
    assert ODD in track.standing.forced
    found = imo_turning(track)
    assert {item.passed for item in found} == {None}
    assert {item.words for item in found} == {"not settled"}
    assert all(track.standing.forced in item.conditions for item in found)
    assert any(np.isfinite(item.value) for item in found)
    assert imo_turning(pk.simulate("s175-3dof", speed=9.0))[0].words == "met"
