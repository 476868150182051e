"""Which runs repeat each other."""

from __future__ import annotations

from dataclasses import fields

import pytest

from pmmkit.campaigns import RUN_SETTINGS, Run, Settings

DEG = 0.017453292519943295


def run(name: str, test: str = "static_drift", **settings: float | str | None) -> Run:
    """A run of a table of means."""
    given = Settings(**{"speed": 1.0, "drift": 4 * DEG, **settings})  # type: ignore[arg-type]
    return Run(id=name, test=test, kind="means", settings=given, loader=dict)  # type: ignore[arg-type]


def ids(*runs: Run) -> list[list[str]]:
    return [[item.id for item in group] for group in Run.repeats(runs)]


def test_runs_set_alike_repeat_each_other_in_the_order_in_which_they_came() -> None:
    assert ids(run("a"), run("b", drift=8 * DEG), run("c"), run("d", drift=8 * DEG), run("e")) == [
        ["a", "c", "e"],
        ["b", "d"],
    ]


def test_every_run_is_in_one_group() -> None:
    assert ids() == []
    assert ids(run("a")) == [["a"]]


@pytest.mark.parametrize(
    ("name", "one", "same", "other"),
    [
        ("speed", 0.436, 0.4385, 0.440),
        ("speed", 8.0, 8.007, 8.02),
        ("drift", 4 * DEG, 4.05 * DEG, 4.25 * DEG),
        ("rudder", -35 * DEG, -34.95 * DEG, -34 * DEG),
        ("propeller_rps", 5.5, 5.52, 5.7),
        ("period", 20.0, 20.05, 21.0),
        ("amplitude", 0.2, 0.2008, 0.21),
        ("yaw_amplitude", 15 * DEG, 15.05 * DEG, 16 * DEG),
        ("yaw_rate", 0.2, 0.2008, 0.21),
    ],
)
def test_settings_are_the_same_within_what_can_be_set(
    name: str, one: float, same: float, other: float
) -> None:
    """A carriage is set to 3 mm/s or 0.1 %, a turntable to 0.1°, a crank to 1 mm."""
    runs = [run(label, **{name: x}) for label, x in (("a", one), ("b", same), ("c", other))]
    assert ids(*runs) == [["a", "b"], ["c"]]


def test_port_is_not_starboard_but_astern_is_astern_whichever_way_it_is_written() -> None:
    assert ids(run("a", drift=4 * DEG), run("b", drift=-4 * DEG)) == [["a"], ["b"]]
    assert ids(run("a", drift=180 * DEG), run("b", drift=-180 * DEG)) == [["a", "b"]]


def test_a_drift_test_is_no_repeat_of_a_rudder_test() -> None:
    assert ids(run("a"), run("b", test="static_rudder")) == [["a"], ["b"]]


def test_revolutions_that_are_not_known_are_not_those_of_another_run() -> None:
    assert ids(run("a", propeller_rps=5.0), run("b"), run("c")) == [["a"], ["b", "c"]]


def test_a_propeller_at_rest_is_a_setting() -> None:
    assert ids(run("a", propeller_rps=0.0), run("b", propeller_rps=None)) == [["a"], ["b"]]


def test_a_turn_is_the_same_by_its_radius_and_by_its_rate() -> None:
    """r = U/R."""
    by_rate = run("a", test="steady_turn", yaw_rate=0.1)
    by_radius = (run(name, test="steady_turn", radius=x) for name, x in (("b", 10.0), ("c", 20.0)))
    assert ids(by_rate, *by_radius) == [["a", "b"], ["c"]]


def test_a_record_that_begins_later_in_the_cycle_is_the_same_test() -> None:
    swung = {"amplitude": 0.2, "period": 20.0}
    one = run("a", test="pure_sway", phase=0.0, **swung)
    assert ids(one, run("b", test="pure_sway", phase=90 * DEG, **swung)) == [["a", "b"]]


def test_what_the_campaign_says_counts_before_the_settings() -> None:
    """A model that stood 1° further than ordered was meant to repeat 4°."""
    assert ids(run("a"), run("b", drift=5 * DEG, repeat_of="a"), run("c", drift=5 * DEG)) == [
        ["a", "b"],
        ["c"],
    ]


def test_a_repeat_of_a_repeat_belongs_to_the_first_run() -> None:
    two = run("c", drift=9 * DEG, repeat_of="b")
    assert ids(run("a"), run("b", drift=5 * DEG, repeat_of="a"), two) == [["a", "b", "c"]]


def test_a_stated_repeat_brings_those_that_are_set_like_its_origin() -> None:
    assert ids(run("a"), run("z"), run("b", drift=5 * DEG, repeat_of="z")) == [["a", "z", "b"]]


def test_repeats_of_a_run_that_is_left_out_still_repeat_each_other() -> None:
    both = run("b", repeat_of="x"), run("c", drift=5 * DEG, repeat_of="x")
    assert ids(*both, run("d", drift=9 * DEG)) == [["b", "c"], ["d"]]


def test_runs_that_name_each_other_are_one_group() -> None:
    assert ids(run("b", repeat_of="a"), run("a", drift=9 * DEG, repeat_of="b")) == [["b", "a"]]


def test_small_steps_do_not_make_a_chain() -> None:
    """0.08° from one run to the next: the last is 0.24° from the first, another setting."""
    steps = [run(str(i), drift=(4 + 0.08 * i) * DEG) for i in range(4)]
    assert ids(*steps) == [["0", "1"], ["2", "3"]]


def test_every_setting_is_weighed() -> None:
    """But when the record begins; rate of turn and radius are one."""
    left = {"phase", "repeat_of", "yaw_rate", "radius", "further"}
    weighed = {
        *(item.name for item in fields(Settings)),
        *(item.name for item in RUN_SETTINGS.brought),
    }
    assert set(RUN_SETTINGS.resolution) == weighed - left | {"turn_rate"}
