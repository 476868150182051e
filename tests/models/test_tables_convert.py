"""The same forces in every convention, the published numbers of other forms, and what is refused.

The forces come from `effects.hull.Regressors`, which knows nothing of the conversions.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit.base import TableError
from pmmkit.conventions import STRUCTURES, Convention, Ship, Water
from pmmkit.effects import Regressors, State
from pmmkit.models import DerivativeTable, converted, from_values
from pmmkit.models.tables.compare import identical
from pmmkit.models.tables.convert import to_system

WATER = Water(rho=1000.0, g=9.81)
S175 = Ship(name="S175", L=175.0, B=25.4, d=9.5, volume=21222.0, mass=2.12e7, Izz=3.7e10)
SON_NOMOTO = {
    "Xudot": -0.000238,
    "Xuu": -0.0004226,
    "Xvr": -0.00311,
    "Xrr": 0.00020,
    "Xvv": -0.00386,
    "Yvdot": -0.007049,
    "Yv": -0.0116,
    "Yr": 0.00242,
    "Yvvv": -0.109,
    "Yrrr": 0.00177,
    "Yvvr": 0.0214,
    "Yvrr": -0.0405,
    "Nrdot": -0.000419,
    "Nv": -0.0038545,
    "Nr": -0.00222,
    "Nvvv": 0.001492,
    "Nrrr": -0.00229,
    "Nvvr": -0.0424,
    "Nvrr": 0.00156,
}


def son_nomoto(**convention: object) -> DerivativeTable:
    separate = Convention(coriolis="separate").with_(**convention)
    return from_values(SON_NOMOTO, ship=S175, water=WATER, convention=separate)


def random_table(
    seed: int, structure: str = "abkowitz3", rows: int = 2, more: tuple[str, ...] = (), **convention
) -> DerivativeTable:
    """Values of order one and a full covariance over derivatives and Froude numbers."""
    rng = np.random.default_rng(seed)
    names = STRUCTURES[structure].with_(*more).derivatives
    n = len(names)
    root = rng.normal(size=(rows * n, rows * n)) * 0.01
    table = from_values(
        {name: rng.normal(size=rows) for name in names},
        ship=S175,
        water=WATER,
        Fn=[0.15 + 0.1 * row for row in range(rows)],
        convention=Convention(**convention),
    )
    return table.with_(covariance=(root @ root.T).reshape(rows, n, rows, n))


def random_state(seed: int, size: int = 20, speed: float | None = None, small=1.0) -> State:
    rng = np.random.default_rng(seed)
    moves = {name: rng.normal(size=size) * small for name in ("v", "vdot", "udot")}
    moves |= {name: rng.normal(size=size) * 0.02 * small for name in ("r", "rdot")}
    moves |= {"delta": rng.normal(size=size) * small, "phi": rng.normal(size=size) * 0.1}
    u = 8.0 + rng.normal(size=size) if speed is None else np.sqrt(speed**2 - moves["v"] ** 2)
    return State.of(u=u, thrust=rng.uniform(1e5, 1e6, size), **moves)


def forces(table: DerivativeTable, state: State, channel: str, row: int = 0) -> np.ndarray:
    names = [name for name in table.names if name[0] == channel]
    columns = Regressors.at(
        names,
        state,
        ship=table.ship,
        water=table.water,
        convention=table.convention,
        approach_speed=8.0,
    ).columns
    return columns @ table.select(names).value[row]


def assert_same_forces(first, second, state, row=0, rtol=1e-10):
    for channel in "XYN":
        one, two = (forces(table, state, channel, row) for table in (first, second))
        np.testing.assert_allclose(two, one, rtol=rtol, atol=rtol * np.abs(one).max())


def assert_round_trip(table: DerivativeTable, there: DerivativeTable) -> None:
    back = converted(there, table.convention)
    assert back.convention == table.convention
    assert back.notes == table.notes
    added = [name for name in back.names if name not in table.names]
    if added:
        np.testing.assert_allclose(back.select(added).value, 0.0, atol=1e-13)
    back = back.select(table.names)
    scale = np.nan_to_num(np.abs(table.covariance)).max()
    np.testing.assert_allclose(back.value, table.value, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(back.covariance, table.covariance, rtol=1e-10, atol=1e-12 * scale)


class TestPublishedNumbers:
    def test_son_and_nomoto_on_the_draught_basis_in_beta_form_with_total_coefficients(self):
        """The S175 list of another program: values times L/d = 18.421, odd-in-v signs flipped,
        added-mass Coriolis terms inside (there Yr = .0402 + .0044, Xvr = -.0726 + .1299)."""
        published = {
            "Yv": 0.2137,
            "Yvvv": 2.008,
            "Yvvr": 0.3942,
            "Yvrr": 0.7461,
            "Yrrr": 0.0326,
            "Nv": 0.0710,
            "Nr": -0.0409,
            "Nvvv": -0.0275,
            "Nvvr": -0.7811,
            "Nvrr": -0.0287,
            "Nrrr": -0.0422,
            "Xvv": -0.0711,
            "Xrr": 0.0037,
            "Xvr": -0.0726,
            "Yr": 0.0402,
            "Xudot": -0.0044,
            "Yvdot": 0.1299,
            "Nrdot": -0.0077,
        }
        table = converted(son_nomoto(), system="prime-d", sway="beta", coriolis="in-derivatives")
        values = table.at()
        for name, number in published.items():
            assert values[name] == pytest.approx(number, abs=6e-5 if abs(number) < 1 else 6e-4)

    def test_total_coefficients_of_the_s175(self):
        total = converted(son_nomoto(), coriolis="in-derivatives").at()
        assert total["Yr"] == pytest.approx(0.002182, abs=1e-12)
        assert total["Xvr"] == pytest.approx(0.003939, abs=1e-12)

    def test_kcs_from_its_beta_form_of_total_coefficients(self):
        """Yoshimura and Ueno list Xβr - my = -.1084 and Yr - mx = .0398, mx .00627, my .1552."""
        kcs = Ship(name="KCS", L=230.0, B=32.2, d=10.8, volume=52030.0, mass=5.2e7, Izz=1.7e11)
        table = from_values(
            {
                "Xvr": -0.1084,
                "Yr": 0.0398,
                "Yv": 0.2252,
                "Yvvv": 1.7179,
                "Nvvr": -0.6168,
                "Nvrr": 0.0512,
                "Xudot": -0.00627,
                "Yvdot": 0.1552,
            },
            ship=kcs,
            water=WATER,
            convention=Convention(system="prime-d", sway="beta"),
        )
        values = converted(table, sway="v", coriolis="separate").at()
        expected = {
            "Xvr": 0.1084 - 0.1552,
            "Yr": 0.0398 + 0.00627,
            "Yv": -0.2252,
            "Yvvv": -1.7179,
            "Nvvr": -0.6168,
            "Nvrr": -0.0512,
            "Yvdot": -0.1552,
        }
        for name, number in expected.items():
            assert values[name] == pytest.approx(number, abs=1e-12)

    def test_the_mass_of_a_floating_ship_is_one_in_bis(self):
        """In bis, forces are over the displaced weight: the added mass m itself becomes 1."""
        mass = 2 * S175.volume / S175.L**3
        table = from_values({"Yvdot": -mass, "Xudot": -mass / 20}, ship=S175, water=WATER)
        bis = to_system(table, "bis").at()
        assert bis["Yvdot"] == pytest.approx(-1.0, rel=1e-14)
        assert bis["Xudot"] == pytest.approx(-0.05, rel=1e-14)


class TestTheSameForces:
    @pytest.mark.parametrize("structure", ["abkowitz3", "modulus", "son-nomoto", "mmg"])
    @pytest.mark.parametrize(
        "change",
        [
            {"system": "prime-d"},
            {"sway": "beta"},
            {"rudder_positive": "port"},
            {"surge": "constant"},
            {"system": "prime-d", "sway": "beta", "surge": "constant", "rudder_positive": "port"},
        ],
        ids=str,
    )
    def test_in_any_motion(self, structure, change):
        table = random_table(1, structure, more=("Yd", "Nd", "Yvd", "Yddd", "Yvdd", "XT", "Yuu"))
        assert_same_forces(table, converted(table, **change), random_state(2))

    @pytest.mark.parametrize("row", [0, 1])
    @pytest.mark.parametrize("surge", ["u", "constant"])
    def test_in_bis_at_the_speed_of_the_row(self, row, surge):
        table = random_table(3, more=("Yd", "Y0", "YT", "Nvvvv"), surge=surge)
        bis = to_system(table, "bis")
        speed = S175.speed(float(table.Fn[row]), WATER.g)
        assert_same_forces(table, bis, random_state(4, speed=speed), row=row)
        assert any("bis" in note for note in bis.notes)

    def test_surge_forms_agree_in_bis_at_any_speed(self):
        table = to_system(random_table(5), "bis")
        assert_same_forces(table, converted(table, surge="constant"), random_state(6))

    @pytest.mark.parametrize("system", ["prime", "prime-d", "bis"])
    @pytest.mark.parametrize("sway", ["v", "beta"])
    def test_coriolis_terms_written_out_are_what_was_taken_out(self, system, sway):
        """Total = separate + my v r in X and - mx u r in Y, with U = u in Y (no drift)."""
        total = converted(random_table(7), system=system, sway=sway)
        separate = converted(total, coriolis="separate")
        state = random_state(8, speed=S175.speed(0.15, WATER.g))
        straight = state.with_(v=np.zeros(20), u=np.full(20, S175.speed(0.15, WATER.g)))
        plain = converted(total, system="prime", sway="v")
        mass = 0.5 * WATER.rho * S175.L**3
        mx, my = -mass * plain["Xudot"][0], -mass * plain["Yvdot"][0]
        np.testing.assert_allclose(
            forces(separate, state, "X") + my * state.v * state.r,
            forces(total, state, "X"),
            rtol=1e-10,
        )
        np.testing.assert_allclose(
            forces(separate, straight, "Y") - mx * straight.u * straight.r,
            forces(total, straight, "Y"),
            rtol=1e-10,
        )
        assert forces(separate, state, "N") == pytest.approx(forces(total, state, "N"))

    @pytest.mark.parametrize("structure", ["linear", "abkowitz3", "mmg"])
    def test_moment_about_another_point_is_the_moment_less_the_arm_times_the_force(self, structure):
        table, state, arm = random_table(9, structure), random_state(10), 4.2
        moved = converted(table, moment_reference_x=arm)
        np.testing.assert_allclose(
            forces(moved, state, "N"),
            forces(table, state, "N") - arm * forces(table, state, "Y"),
            rtol=1e-9,
        )

    @staticmethod
    def elsewhere(state: State, x: float) -> State:
        return state.with_(v=state.v + x * state.r, vdot=state.vdot + x * state.rdot)

    @pytest.mark.parametrize("convention", [{"U": "carriage"}, {"system": "bis"}], ids=str)
    @pytest.mark.parametrize("x", [3.0, -60.0])
    def test_motion_point_is_exact_where_the_unit_of_speed_does_not_move(self, convention, x):
        table = random_table(11, more=("Yd", "Xvvvv", "Yvvd", "Nvvdot"), **convention)
        moved = converted(table, motion_reference_x=x)
        state = random_state(12)
        for channel in "XYN":
            np.testing.assert_allclose(
                forces(moved, self.elsewhere(state, x), channel),
                forces(table, state, channel),
                rtol=1e-9,
                atol=1e-9 * np.abs(forces(table, state, channel)).max(),
            )

    def test_motion_point_is_exact_for_terms_of_the_second_power_of_speed(self):
        table = random_table(13).select(["Xuu", "Xvv", "Xvr", "Xrr", "Xudot", "Yvdot", "Nrdot"])
        for surge in ("u", "constant"):
            start = converted(table, surge=surge)
            moved = converted(start, motion_reference_x=17.0)
            state = random_state(14)
            for channel in "XYN":
                np.testing.assert_allclose(
                    forces(moved, self.elsewhere(state, 17.0), channel),
                    forces(start, state, channel),
                    rtol=1e-10,
                )

    def test_motion_point_is_right_to_the_fifth_order_with_instantaneous_speed(self):
        """What a cubic table cannot hold falls with the fifth power of the motion."""
        table = random_table(15).select(["Yv", "Yr", "Yvvv", "Yvvr", "Yvrr", "Yrrr"])
        moved = converted(table, motion_reference_x=30.0)
        errors = []
        for small in (1.0, 0.5, 0.25):
            state = random_state(16, speed=8.0, small=small)
            ahead = State.of(u=np.full(20, 8.0), v=state.v, r=state.r)
            error = forces(moved, self.elsewhere(ahead, 30.0), "Y") - forces(table, ahead, "Y")
            errors.append(np.abs(error).max())
        orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        np.testing.assert_allclose(orders, 5.0, atol=0.15)

    def test_moment_and_motion_points_move_together(self):
        table = random_table(17, U="carriage")
        moved = converted(table, moment_reference_x=3.0, motion_reference_x=-5.0)
        state = random_state(18)
        N = forces(moved, self.elsewhere(state, -5.0), "N")
        expected = forces(table, state, "N") - 3.0 * forces(table, state, "Y")
        np.testing.assert_allclose(N, expected, rtol=1e-9)

    def test_points_take_the_coriolis_terms_with_them(self):
        """A separate table moves as its total does: the point shift sees all of the force."""
        total = random_table(19)
        separate = converted(total, coriolis="separate")
        move = {"moment_reference_x": 4.0, "motion_reference_x": 2.0}
        one = converted(total, **move)
        two = converted(converted(separate, **move), coriolis="in-derivatives").select(one.names)
        np.testing.assert_allclose(two.value, one.value, rtol=1e-11, atol=1e-13)


class TestCovariance:
    def test_is_carried_by_the_same_map_as_the_values(self):
        """The map, column by column from tables that hold a single one, gives J C Jᵀ."""
        table = random_table(20, "abkowitz3", rows=2)
        change = {
            "system": "bis",
            "sway": "beta",
            "surge": "constant",
            "coriolis": "separate",
            "moment_reference_x": 5.0,
            "motion_reference_x": 9.0,
        }
        stated = converted(table, **change)
        columns = [
            converted(table.with_(value=one.reshape(table.value.shape)), **change).value.ravel()
            for one in np.eye(table.value.size)
        ]
        J = np.stack(columns, axis=1)
        np.testing.assert_allclose(J @ table.value.ravel(), stated.value.ravel(), rtol=1e-9)
        C = table.covariance.reshape(J.shape[1], -1)
        expected = (J @ C @ J.T).reshape(stated.covariance.shape)
        np.testing.assert_allclose(stated.covariance, expected, atol=1e-9 * expected.max())

    def test_a_sum_knows_the_correlation_of_its_parts(self):
        """Xvv = 2 ± .1 and Xuu = 1 ± .1, fully tied: their difference is known exactly."""
        table = from_values({"Xuu": 1.0, "Xvv": 2.0}, ship=S175, water=WATER)
        tied = table.with_(covariance=np.full((1, 2, 1, 2), 0.01))
        assert converted(tied, surge="constant").std[0] == pytest.approx([0.1, 0.0])

    def test_an_unknown_entry_spoils_only_what_it_enters(self):
        values = SON_NOMOTO | {"Xvv": np.nan}
        std = {name: 1e-4 for name in values if name != "Xvv"}
        table = from_values(values, std=std, ship=S175, water=WATER)
        result = converted(table, surge="constant", moment_reference_x=3.0)
        assert math.isnan(result.at()["Xvv"])
        assert {name for name, value in result.at().items() if math.isnan(value)} == {"Xvv"}
        spread = dict(zip(result.names, result.std[0], strict=True))
        assert {name for name, value in spread.items() if math.isnan(value)} == {"Xvv"}

    def test_degrees_of_freedom_and_runs_are_those_of_the_weakest_part(self):
        table = from_values(
            {"Xuu": 1.0, "Xvv": 2.0}, std={"Xuu": 1, "Xvv": 1}, ship=S175, water=WATER
        ).with_(
            dof=np.array([[4.0, 9.0]]),
            runs=np.array([[6, 3]]),
            method=np.array([["resistance", "drift"]]),
        )
        result = converted(table, surge="constant")
        assert result.dof.tolist() == [[4.0, 4.0]]
        assert result.runs.tolist() == [[6, 3]]
        assert result.method.tolist() == [["resistance", "resistance + drift"]]


class TestRoundTrips:
    changes = st.fixed_dictionaries(
        {},
        optional={
            "system": st.sampled_from(["prime", "prime-d", "bis"]),
            "sway": st.sampled_from(["v", "beta"]),
            "surge": st.sampled_from(["u", "constant"]),
            "coriolis": st.sampled_from(["in-derivatives", "separate"]),
            "rudder_positive": st.sampled_from(["starboard", "port"]),
            "moment_reference_x": st.floats(-80, 80),
            "motion_reference_x": st.floats(-80, 80),
        },
    )

    @pytest.mark.slow
    @given(start=changes, end=changes, seed=st.integers(0, 99))
    @settings(max_examples=60, deadline=None)
    def test_there_and_back_is_where_it_was(self, start, end, seed):
        table = random_table(seed, more=("Yd", "Nd", "Yvd", "Xdd"), rows=2, **start)
        assert_round_trip(table, converted(table, **end))

    def test_nothing_to_do_gives_the_same_table(self):
        table = random_table(0)
        assert converted(table) is table
        assert identical(converted(table, table.convention), table)

    def test_ship_water_notes_and_provenance_are_carried(self):
        table = from_values(
            {"Yv": -0.01}, ship=S175, water=WATER, notes=["a note"], provenance={"by": "hand"}
        )
        result = to_system(table, "prime-d")
        assert (result.ship, result.water, result.notes) == (S175, WATER, ("a note",))
        assert result.provenance == {"by": "hand"}


class TestRefusals:
    @pytest.mark.parametrize(
        ("table", "change", "words"),
        [
            (random_table(0), {"U": "carriage"}, "Reduce the runs again"),
            (random_table(0), {"surge": "delta-u"}, "approach"),
            (random_table(0, U="carriage"), {"surge": "constant"}, "instantaneous"),
            (random_table(0, "modulus"), {"motion_reference_x": 1.0}, r"Yv\|v\|"),
            (random_table(0).select(["Yr", "Xvr", "Xudot"]), {"coriolis": "separate"}, "Yvdot"),
            (random_table(0).select(["Yr", "Yvdot"]), {"coriolis": "separate"}, "Xudot"),
            (random_table(0), {"system": "imperial"}, "imperial"),
            (random_table(0), {"sway": "u"}, "beta"),
            (random_table(0), {"moment_reference_x": math.nan}, "not a number"),
            (random_table(0), {"moment_reference": 1.0}, "moment_reference"),
            (son_nomoto(), {"system": "bis"}, "pooled"),
        ],
        ids=lambda item: str(item) if isinstance(item, dict) else "",
    )
    def test_what_the_numbers_do_not_hold(self, table, change, words):
        with pytest.raises(TableError, match=words):
            converted(table, **change)

    def test_all_reasons_at_once(self):
        with pytest.raises(TableError) as caught:
            converted(random_table(0), U="carriage", surge="delta-u")
        assert len(caught.value.problems) == 2

    def test_an_added_mass_without_a_value_is_missing(self):
        table = from_values(SON_NOMOTO | {"Xudot": np.nan}, ship=S175, water=WATER)
        with pytest.raises(TableError, match=r"Xudot is needed.*no value"):
            converted(table, coriolis="separate")

    def test_pooled_terms_of_the_second_power_of_speed_go_to_bis(self):
        table = son_nomoto().select(["Xuu", "Xvv", "Xvr", "Xrr", "Yvdot"])
        assert_round_trip(table, to_system(table, "bis"))

    def test_a_ship_whose_lengths_are_not_known(self):
        unknown = Ship(name="?", L=math.nan, B=1.0, d=math.nan, volume=1.0, mass=1.0, Izz=1.0)
        table = from_values({"Yv": -0.01}, ship=unknown, water=WATER)
        for change in ({"system": "prime-d"}, {"moment_reference_x": 1.0}):
            with pytest.raises(TableError, match="not known"):
                converted(table, **change)
