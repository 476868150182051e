"""Mean drift of waves that a free-running ship's model lacks, beside wind and current."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import FreeRecord, identify
from pmmkit.base import DataError
from pmmkit.diagnosis import Diagnosis
from pmmkit.diagnosis.free_running.base import movable
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.hypotheses import candidates_for
from pmmkit.diagnosis.free_running.question import records_of
from pmmkit.equations import State
from pmmkit.identification import Binding
from pmmkit.identification.binding import driven
from pmmkit.models import Model, Part
from pmmkit.seakeeping import frequencies
from pmmkit.seakeeping.second_order.mean_drift import drift_table
from tests.support.few_stations import thinned
from tests.support.free_tank.campaigns import Setup, write
from tests.support.free_tank.cases import FLEETS
from tests.support.free_tank.container import BODY, Container
from tests.support.free_tank.hidden import NOTHING, Hidden
from tests.support.free_tank.sailing import Order, sail
from tests.support.free_tank.sensors import recorded

FLEET = FLEETS["s175"]
SHIP = pk.load_model("s175-3dof")
HEIGHT, PERIOD, WIND = 3.0, 8.0, 8.0
SENSORS = ("x", "y", "psi", "u", "v", "r")
NOISE = {name: FLEET.noise[name] for name in SENSORS}
RIVALS = ("wave_drift", "wind", "current", "asymmetry")
STEP, EVERY = 1.0, 2
"""Of the tank [s], and steps from a sample to the next."""
RUNS = (
    #speed rudder switch seconds sea   wind
    (7.0, 35.0, None, 500.0, -0.6, 1.9),
    (10.0, -20.0, 20.0, 350.0, 1.4, -2.3),
    (7.0, 10.0, 10.0, 350.0, 2.6, 0.2),
    (10.0, -15.0, None, 400.0, 0.3, 2.9),
)  # fmt: skip


def orders(count: int, *, one_side: bool) -> list[Order]:
    """Turns and zigzags at two speeds, waves and a light wind from sides of their own."""
    return [
        Order(
            rudder=math.radians(rudder),
            switch=None if switch is None else math.radians(switch),
            speed=speed,
            seconds=seconds,
            wind_speed=WIND,
            wind_from=sea if one_side else wind,
            sea_height=HEIGHT,
            sea_from=sea,
        )
        for speed, rudder, switch, seconds, sea, wind in RUNS[:count]
    ]


def sailed(
    hidden: Hidden, count: int = 3, *, one_side: bool = False, seed: int = 0
) -> list[FreeRecord]:
    """Records of the tank's own container ship, whose roll does nothing to her; the sea that they
    state acts as is hidden."""
    rng, found = np.random.default_rng(seed), []
    ship = Container(replace(hidden, heel=0.0))
    for number, run in enumerate(sail(ship, orders(count, one_side=one_side), STEP)):
        seen = recorded(run, hidden, FLEET.noise, EVERY, rng)
        true = np.ones(len(seen["t"]))
        found.append(
            FreeRecord(
                name=f"run {number}",
                t=seen["t"],
                delta=seen["delta"],
                turns=seen["n"],
                measured=MappingProxyType({name: seen[name] for name in SENSORS}),
                speed=run.order.speed,
                wind_speed=run.order.wind_speed * true,
                wind_direction=run.order.wind_from * true,
                wave_height=HEIGHT * true,
                wave_direction=run.order.sea_from * true,
                wave_period=PERIOD,
            )
        )
    return found


def with_table(model: Model, table: dict[str, tuple[float, ...]], factor: float = 0.0) -> Model:
    """A model whose file has a table of drift, that acts by a factor."""
    factors = dict.fromkeys(("kx", "ky", "kn"), factor)
    part = Part(
        effect="wave_drift",
        values=MappingProxyType({"Hs": HEIGHT, "from_deg": 0.0, **factors, **table}),
        options=MappingProxyType({"coefficients": "table"}),
    )
    return replace(model, parts=MappingProxyType({**model.parts, "wave_drift": part}))


@pytest.fixture(scope="module")
def table() -> dict[str, tuple[float, ...]]:
    """By strip theory, which the tank knows nothing of."""
    hull = thinned(pk.load_hull("s175"))
    waves = pk.sea("bretschneider", Hs=HEIGHT, Tp=PERIOD)
    omega = frequencies(hull.L, waves)
    found = pk.rao(hull, speeds=8.5, headings_deg=np.arange(0, 181, 15), omega=omega)
    return drift_table(found, waves)


def asked(
    model: Model,
    records: Sequence[FreeRecord],
    rivals: Sequence[str] | None = RIVALS,
    *,
    most: int = 1,
) -> Diagnosis:
    return diagnose_free(model, records, candidates=rivals, sensors=NOISE, most=most)


def still(seconds: float = 4.0, **sea: object) -> FreeRecord:
    """A few seconds of anything."""
    t = np.arange(0.0, seconds)
    zero = 0.0 * t
    return FreeRecord(
        name="a", t=t, delta=zero, turns=zero, measured={"psi": zero}, speed=7.0
    ).with_(**sea)


ROUGH = {"wave_height": np.full(4, 2.0), "wave_direction": np.full(4, 0.5)}


def test_it_is_asked_where_a_sea_is_stated_and_the_model_has_a_table(table):
    ready = with_table(SHIP, table)
    asked = {
        (model is ready, record is rough): "wave_drift"
        in {item.name for item in candidates_for(model, [record])}
        for rough in [still(**ROUGH)]
        for model in (SHIP, ready)
        for record in (rough, still())
    }
    assert asked == {key: all(key) for key in asked}


def test_a_table_that_waits_does_not_act_and_no_base_moves_it(table):
    assert movable(with_table(SHIP, table)) == movable(SHIP)
    assert "wave_drift.ky" in movable(with_table(SHIP, table, 1.0))


def test_one_table_is_not_taken_for_two_seas(table):
    records = [still(**ROUGH, wave_period=period) for period in (7.0, 12.0)]
    with pytest.raises(DataError, match=r"7 to 12 s.*one period"):
        diagnose_free(with_table(SHIP, table), records)


def test_half_a_sea_is_refused():
    with pytest.raises(DataError, match="half a sea"):
        still(wave_height=np.full(4, 2.0))


def test_a_record_sails_in_the_sea_that_it_states(table):
    """A stated calm is calm whatever the model's own sea is; none stated leaves the model's."""
    model = with_table(SHIP, table, 1.0)
    steady = {
        name: sailed_along(model, still(60.0, **sea))
        for name, sea in {
            "own": {},
            "calm": {"wave_height": np.zeros(60), "wave_direction": np.zeros(60)},
            "same": {"wave_height": np.full(60, HEIGHT), "wave_direction": np.zeros(60)},
            "abeam": {"wave_height": np.full(60, HEIGHT), "wave_direction": np.full(60, 1.5)},
        }.items()
    }
    none = sailed_along(SHIP, still(60.0))
    assert steady["calm"] == none
    assert steady["same"] == steady["own"] != none
    assert steady["abeam"][State.v] < none[State.v]


def sailed_along(model: Model, record: FreeRecord) -> tuple[float, ...]:
    """States at the end of a record, from steady running."""
    binding = Binding.of(driven(model), (), record.speed, conditions=record.conditions)
    functions = binding.functions
    k = binding.base.copy()
    functions.complete(k)
    first = np.zeros((1, len(binding.states)))
    first[0, State.u] = record.speed
    out = np.empty((len(record), first.shape[1]))
    ends = np.array([0, len(record)])
    functions.windows(record.t, record.inputs, ends, first, k, 1.0, out)
    return tuple(out[-1].tolist())


def test_the_sea_of_a_campaign_reaches_its_records(tmp_path):
    """Once for all runs in [defaults], or at a run."""
    folder = write(Setup(ship="kvlcc2-l7", runs=3, seed=0), tmp_path)
    file = folder / "campaign.toml"
    stated = "[defaults]\nwave_height = 0.05\nwave_period = 1.3\nwaves_from_deg = 30\n"
    text = file.read_text(encoding="utf-8") + "waves_from_deg = -60\n"
    file.write_text(stated + text, encoding="utf-8")
    campaign = pk.open_campaign(folder)
    first, *_, last = records_of(campaign, pk.load_model("kvlcc2-l7"))
    assert (first.wave_height == 0.05).all()
    assert first.wave_period == 1.3
    assert first.wave_direction[0] == pytest.approx(math.radians(30.0))
    assert last.wave_direction[-1] == pytest.approx(math.radians(-60.0))


@pytest.fixture(scope="module")
def named(table) -> Diagnosis:
    """Walls that send short waves back, by another form and other numbers than the table."""
    return asked(with_table(SHIP, table), sailed(Hidden(waves=1.0)), None)


@pytest.mark.slow
def test_waves_are_named_among_the_whole_catalogue(named):
    assert named.group[0][0] == ("wave_drift",)
    assert named.group[0][1] > 0.9
    (finding,) = named.findings
    assert finding.error_after < 0.8 * finding.error_before
    better = named.model.values("wave_drift")
    assert 0.1 < better["ky"] < 1.5
    assert better["ky2"] == pytest.approx(finding.coefficients["sway2"])
    assert better["kx"] == pytest.approx(
        finding.coefficients["share"] + finding.coefficients["surge"]
    )


@pytest.mark.slow
def test_no_waves_are_named_where_none_act(table):
    """A sea is stated, and the ship does not feel it."""
    assert asked(with_table(SHIP, table), sailed(NOTHING)).group == ()


@pytest.mark.slow
def test_a_wind_is_not_taken_for_waves(table):
    found = asked(with_table(SHIP, table), sailed(Hidden(windage=1.0)))
    assert [names for names, _ in found.group] == [("wind",)]


@pytest.mark.slow
def test_it_is_added_and_taken_out_again(table, named):
    added = pk.with_effect(with_table(SHIP, table), named.findings[0])
    assert added.values("wave_drift")["ky"] == pytest.approx(named.model.values("wave_drift")["ky"])
    assert pk.without_effect(added, "wave_drift").values("wave_drift")["ky"] == 0.0


@pytest.mark.slow
def test_a_wind_sea_is_told_from_a_wind_that_the_model_knows(table):
    """From one side they are nearly one force: what is known of the wind tells them apart, and by
    the yaw moment that the waterline gives to short waves the waves alone are not taken for it."""
    areas = {"AF": BODY.front, "AL": BODY.flank, "cx": 0.7, "cy": 0.8, "cn": 0.1}
    part = Part(effect="wind", values=MappingProxyType(areas))
    ready = with_table(SHIP, table)
    knows = ready.with_(parts=MappingProxyType({**ready.parts, "wind": part}))
    others = [name for name in RIVALS if name != "wind"]
    windy, both = (
        asked(knows, sailed(hidden, one_side=True), others, most=2)
        for hidden in (Hidden(windage=1.0), Hidden(waves=1.0, windage=1.0))
    )
    assert windy.group == ()
    assert [names for names, _ in both.group] == [("wave_drift",)]
    waves = asked(ready, sailed(Hidden(waves=1.0), len(RUNS), one_side=True))
    assert [names for names, _ in waves.group] == [("wave_drift",)]


@pytest.mark.slow
def test_a_filter_fits_the_factors_in_the_sea_of_each_record(table):
    """The side force at about what the walls of the tank make, by the table; the ship of the table
    lets a part of the waves through."""
    model = with_table(SHIP, table, 1.0)
    records = sailed(Hidden(waves=1.0))
    found = identify(model, records, ["wave_drift.ky"], spread=0.5, sensors=NOISE)
    assert 0.3 < found.model.values("wave_drift")["ky"] < 1.4
