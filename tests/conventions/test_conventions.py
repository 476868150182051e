"""Names of derivatives, units, non-dimensional systems, and the hull polynomial in newtons."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polynomials import polynomial_forces

from pmmkit.base import DataError, UnknownNameError
from pmmkit.conventions import CHANNELS, Convention, Ship, Water, parse_derivative, unit_factor
from pmmkit.conventions.derivatives import FACTORS
from pmmkit.effects import Regressors, State

SHIP = Ship(name="box", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
WATER = Water(rho=1000.0, g=9.81)


class TestNames:
    @given(st.sampled_from(CHANNELS), st.permutations(FACTORS), st.integers(1, 5))
    def test_the_order_of_the_factors_does_not_matter(self, channel, factors, count):
        chosen = factors[:count]
        expected = parse_derivative(channel + "".join(sorted(chosen)))
        assert parse_derivative(channel + "".join(chosen)).factors == expected.factors
        assert sorted(expected.factors) == sorted(chosen)
        assert parse_derivative(expected.name).name == expected.name

    @pytest.mark.parametrize(
        ("given_name", "name"),
        [
            ("Xrv", "Xvr"),
            ("Nrvv", "Nvvr"),
            ("Y|v|v", "Yv|v|"),
            ("Yr|v|", "Y|v|r"),
            ("Kphiv", "Kvphi"),
            ("Nvdotvv", "Nvvvdot"),
            ("Ydphip", "Ypdphi"),
            ("N0uu", "N0uu"),
        ],
    )
    def test_canonical_names(self, given_name, name):
        assert parse_derivative(given_name).name == name

    @pytest.mark.parametrize(
        "bad", ["", "Y", "v", "Zv", "Yw", "Yv'", "Y v", "Yvdott", "yv", "Y|w|"]
    )
    def test_what_is_no_name(self, bad):
        with pytest.raises(UnknownNameError, match="not the name of a derivative"):
            parse_derivative(bad)

    @pytest.mark.parametrize(
        ("name", "speed", "length"),
        [
            ("Yv", 1, 0),
            ("Yvvr", 3, 1),
            ("Yv|v|", 2, 0),
            ("Nrdot", 2, 2),
            ("Yvdot", 2, 1),
            ("Xuu", 2, 0),
            ("Yd", 0, 0),
            ("Y0", 0, 0),
            ("XT", 2, 0),
            ("Kp", 1, 1),
            ("Yvphi", 1, 0),
        ],
    )
    def test_powers_of_speed_and_length(self, name, speed, length):
        derivative = parse_derivative(name)
        assert (derivative.speed_power, derivative.length_power) == (speed, length)

    @given(
        st.sampled_from(
            [
                "Yv",
                "Yvvv",
                "Nvvr",
                "Yv|v|",
                "Y|v|r",
                "Yvdot",
                "Nvvdot",
                "Yrd",
                "Yddd",
                "Yd|d|",
                "Yvvd",
            ]
        ),
        st.sampled_from(["v", "d"]),
    )
    def test_the_sign_under_a_flip_is_that_of_the_product(self, name, variable):
        numbers = {"v": 0.3, "r": 0.7, "d": 0.2, "vdot": 1.1}
        flipped = numbers | {
            key: -number for key, number in numbers.items() if key in (variable, f"{variable}dot")
        }

        def product(values):
            return math.prod(
                abs(values[factor.strip("|")]) if "|" in factor else values[factor]
                for factor in parse_derivative(name).factors
            )

        sign = parse_derivative(name).sign_under_flip(variable)
        assert product(flipped) == pytest.approx(sign * product(numbers))


class TestUnits:
    @pytest.mark.parametrize(
        ("unit", "si", "factor"),
        [
            ("kN", "N", 1000.0),
            ("MN", "N", 1e6),
            ("mN", "N", 1e-3),
            ("kgf", "N", 9.80665),
            ("Nm", "N m", 1.0),
            ("kNm", "N m", 1e3),
            ("N·m", "N m", 1.0),
            ("N m", "N m", 1.0),
            ("nm", "m", 1852.0),
            ("kn", "m/s", 0.514444),
            ("knots", "m/s", 0.514444),
            ("mm", "m", 1e-3),
            ("deg", "rad", 0.0174533),
            ("°/s", "rad/s", 0.0174533),
            ("rpm", "1/s", 1 / 60),
            ("Hz", "1/s", 1.0),
            ("-", "", 1.0),
            ("%", "", 0.01),
            (" m/s² ", "m/s2", 1.0),
            ("g", "m/s2", 9.80665),
            ("t", "kg", 1000.0),
        ],
    )
    def test_factors(self, unit, si, factor):
        assert unit_factor(unit) == (si, pytest.approx(factor, rel=1e-5))

    def test_unknown(self):
        with pytest.raises(DataError, match="furlong"):
            unit_factor("furlong")


class TestSystems:
    ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
    water = Water(rho=1000.0, g=10.0)

    @pytest.mark.parametrize(
        ("channel", "system", "unit"),
        [
            ("Y", "prime", 32000.0),
            ("N", "prime", 128000.0),
            ("X", "prime-d", 2000.0),
            ("K", "prime-d", 8000.0),
            ("Y", "bis", 5000.0),
            ("N", "bis", 20000.0),
        ],
    )
    def test_units_of_force_and_moment(self, channel, system, unit):
        assert (
            Convention(system=system).force_unit(channel, ship=self.ship, water=self.water, U=2.0)
            == unit
        )

    def test_units_of_speed(self):
        ship = replace(self.ship, L=4.9)
        assert Convention(system="prime").speed_unit(ship=ship, water=self.water, U=2.0) == 2.0
        assert Convention(system="bis").speed_unit(
            ship=ship, water=self.water, U=2.0
        ) == pytest.approx(7.0)

    def test_unknown_system(self):
        with pytest.raises(UnknownNameError, match="prime-d"):
            Convention(system="imperial").force_unit("Y", ship=self.ship, water=self.water, U=2.0)


class TestHullPolynomial:
    state = State.of(
        u=1.9, v=0.3, r=0.1, p=0.2, phi=0.05, udot=0.2, vdot=-0.1, rdot=0.3, delta=0.2, thrust=50.0
    )

    def column(self, name, state=None, **convention):
        return Regressors.at(
            [name],
            state or self.state,
            ship=SHIP,
            water=WATER,
            convention=Convention(**convention),
            approach_speed=2.0,
        ).columns[0, 0]

    def test_each_term_by_hand(self):
        """½ρL²U² = 8000 U² newtons; v' = v/U, r' = rL/U, v̇' = v̇L/U², ṙ' = ṙL²/U²."""
        U = math.hypot(1.9, 0.3)
        force, moment = 8000 * U**2, 32000 * U**2
        expected = {
            "Xuu": force * (1.9 / U) ** 2,
            "Yv": force * 0.3 / U,
            "Yvvr": force * (0.3 / U) ** 2 * 0.4 / U,
            "Nr|r|": moment * (0.4 / U) ** 2,
            "Yvdot": force * -0.1 * 4 / U**2,
            "Nrdot": moment * 0.3 * 16 / U**2,
            "Yddd": force * 0.2**3,
            "Kp": moment * 0.8 / U,
            "Nphi": moment * 0.05,
            "X0": force,
            "XT": 50.0,
        }
        for name, number in expected.items():
            assert self.column(name) == pytest.approx(number), name

    def test_carriage_speed(self):
        assert self.column("Yvvv", U="carriage") == pytest.approx(8000 * 4 * 0.15**3)

    def test_bis_is_over_weight_and_the_root_of_g_times_length(self):
        unit = math.sqrt(9.81 * 4)
        assert self.column("Yv", system="bis") == pytest.approx(4905 * 0.3 / unit)
        assert self.column("XT", system="bis") == pytest.approx(50.0)

    @pytest.mark.parametrize("system", ["prime", "prime-d"])
    def test_constant_surge_is_the_resistance_whatever_the_drift(self, system):
        ahead = State.of(u=math.hypot(1.9, 0.3))
        same = {"system": system, "surge": "constant"}
        assert self.column("Xuu", **same) == pytest.approx(self.column("Xuu", ahead, **same))

    def test_constant_surge_grows_with_the_square_of_speed_in_bis(self):
        slow, fast = (
            self.column("Xuu", State.of(u=u, v=v), system="bis", surge="constant")
            for u, v in ((0.6, 0.8), (1.6, 1.2))
        )
        assert fast == pytest.approx(4 * slow)
        assert slow == pytest.approx(4905 / (9.81 * 4))

    def test_loss_of_speed(self):
        assert self.column("Xu", surge="delta-u") == pytest.approx(
            8000 * math.hypot(1.9, 0.3) * -0.1
        )

    @pytest.mark.parametrize("system", ["prime", "prime-d", "bis"])
    @pytest.mark.parametrize("surge", ["u", "constant"])
    @pytest.mark.parametrize("sway", ["v", "beta"])
    @pytest.mark.parametrize("rudder", ["starboard", "port"])
    def test_the_sum_over_monomials_is_the_sum_over_the_columns(self, system, surge, sway, rudder):
        convention = Convention(system=system, surge=surge, sway=sway, rudder_positive=rudder)
        names = ["Xuu", "Xvv", "Xvr", "Yv", "Yv|v|", "Yvvr", "Yd", "Nr", "Nvvd", "N0", "Kphi"]
        values = dict(zip(names, np.linspace(-1, 1.3, len(names)), strict=True))
        s = self.state
        summed = polynomial_forces(
            values,
            (1.9, 0.3, 0.1, 0.2, 0.05, 0.2),
            ship=SHIP,
            water=WATER,
            convention=convention,
            approach=2.0,
        )
        for force, channel in zip(summed, CHANNELS, strict=True):
            chosen = [name for name in names if name[0] == channel]
            columns = Regressors.at(
                chosen, s, ship=SHIP, water=WATER, convention=convention, approach_speed=2.0
            ).columns
            assert force == pytest.approx((columns @ [values[name] for name in chosen])[0])

    def test_no_names_give_no_columns(self):
        empty = Regressors.at(
            [], self.state, ship=SHIP, water=WATER, convention=Convention(), approach_speed=2.0
        ).columns
        assert empty.shape == (1, 0)
