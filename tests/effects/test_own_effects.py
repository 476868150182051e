"""Own effects: a small grammar, on equal terms in a diagnosis, and derivatives in a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import hidden_campaign
from hypothesis import given
from hypothesis import strategies as st
from term_candidates import polynomial

import pmmkit as pk
from pmmkit.base import DataError, ModelError
from pmmkit.conventions import Convention
from pmmkit.diagnosis import candidate_of
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.models import load_model
from pmmkit.reduction import View
from pmmkit.testing.effects import check_effect

SMALL = hidden_campaign("small", {"yaw_sway_coupling": 1.0}, seed=4)


# Reading


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("Y: v*|v|*r; N: v*v*r", ("Yv|v|r", "Nvvr")),
        ("Y: v^3 + r**3", ("Yvvv", "Yrrr")),
        ("N: delta*v^2\n\nX: r*v", ("Nvvd", "Xvr")),
        ("Y: 1 ; K: p*|p|", ("Y0", "Kp|p|")),
        ("Y:phi*phi*v", ("Yvphiphi",)),
    ],
)
def test_text_becomes_derivatives(text, names):
    assert tuple(pk.own_effect("mine", text).shares) == names


def test_a_named_coefficient_stands_for_several_terms():
    fins = pk.own_effect("fins", "Y: a*v*|v| + -0.5*a*v*r; N: -0.4 * a*v*|v|; a ~ -1e-2")
    assert fins.typical == {"a": -0.01}
    assert fins.sizes({"a": -0.02}) == pytest.approx({"Yv|v|": -0.02, "Yvr": 0.01, "Nv|v|": 0.008})


def test_usual_sizes_are_given_or_a_tenth_of_a_usual_force():
    """S175: Y of 3.2e-3, N of 1.3e-3 at v' 0.2 and r' 0.4."""
    found = pk.own_effect("mine", "Y: v*r; N: v*v*r; N: r", typical={"Nrvv": 0.04})
    assert found.typical == pytest.approx({"Yvr": 0.004, "Nvvr": 0.04, "Nr": 3.25e-4})


def test_added_mass_may_change_with_the_motion():
    """Force over acceleration [N s²/m, N m s²]: ½ρL³ a v'², ½ρL⁵ b |v'| with v' = v/U."""
    made = pk.own_effect("bilge", "Yvdot: a*v^2; Nrdot: b*abs(v); a ~ -0.02; b ~ 0.002")
    assert (made.kind, made.outputs) == ("mass", ("Yvdot", "Nrdot"))
    found = made.force(v=0.5, U=1.0, L=2.0, rho=1000.0, a=-0.02, b=0.002)
    assert found == pytest.approx((500 * 8 * -0.02 * 0.25, 500 * 32 * 0.002 * 0.5))
    check_effect(made)
    ship = pk.load_model("s175-3dof")
    heavy = pk.with_effect(ship, made, coefficients={"a": -0.02, "b": 0.0})
    known = {"Yvvvdot": -0.02, "Nvvvdot": 0.0}
    same = pk.with_effect(ship, "nonlinear_added_mass", coefficients=known)
    turns = [pk.simulate(x, rudder_deg=35, speed=9.0).metrics["advance_L"] for x in (heavy, same)]
    assert turns[0] == pytest.approx(turns[1], rel=1e-12)


@pytest.mark.parametrize(
    "text", ["Y: a*v*Fn; Yvdot: a*v^2; a ~ 1", "Yvdot: a*lag(v, 0.3); a ~ 1", "Xvdot: a*v; a ~ 1"]
)
def test_added_mass_that_has_no_place_is_refused(text):
    with pytest.raises(DataError, match=r"added mass|a statement begins with .* or Yvdot"):
        pk.own_effect("bilge", text)


@pytest.mark.parametrize(
    ("text", "message", "place"),
    [
        ("Y: v*|w|*r", "'|w|' is no factor (v, r, u, p, phi, d, delta)", 5),
        ("Y: vv*r", "'vv' is no factor", 3),
        ("Y: v; N: v*(r)", "'(' has no meaning here", 11),
        ("Y v*r", "a statement begins with X:, Y:, N: or K:", 0),
        ("Z: v", "a statement begins with", 0),
        ("Y: 2*v", "a number or a minus belongs to a coefficient with a name", 3),
        ("Y: v*", "end with a factor", 4),
        ("Y: v r", "joined by *", 5),
        ("Y:", "a factor is missing", 2),
        ("Y: v +", "a factor is missing", 6),
        ("Y: v^99", "a power is a whole number from 1 to 9", 5),
        ("Y: v*v;\nY: v^2", "Yvv stands there twice", 11),
        ("Y: v; Yv ~ big", "a usual size is a number", 10),
        ("Y: v; Nv ~ 3", "Nv stands in no term", 5),
        ("Y: v; Yv ~ 0", "must not be 0", 5),
        ("Y: |phi|", "no modulus of phi", 3),
        ("Y: vdot", "'vdot' is no factor", 3),
        ("Y: __import__('os')", "'(' has no meaning here", 13),
    ],
)
def test_damaged_text_shows_the_place(text, message, place):
    with pytest.raises(DataError) as caught:
        pk.own_effect("mine", text)
    said = str(caught.value)
    assert message in said
    assert f"(character {place + 1})" in said
    _, line, caret = said.rsplit("\n", 2)
    column = place - (text.rfind("\n", 0, place) + 1)
    assert caret == " " * (4 + column) + "^"
    assert line.strip() in text


@given(st.text(alphabet="XYNKvrupdphi|*^+-~:;. 0129a\n", max_size=30))
def test_any_text_is_read_or_refused(text):
    try:
        found = pk.own_effect("mine", text)
    except DataError:
        return
    assert found.shares
    assert all(np.isfinite(x) and x for x in found.typical.values())


def test_names_of_the_catalogue_are_taken():
    for name in ("memory", "fault_gauge_zero", "2nd bilge", "kiel+", ""):
        with pytest.raises(DataError, match="cannot be the name"):
            pk.own_effect(name, "Y: v")


FILE = """
[[effects]]
name = "keel"
family = "hull coupling"
summary = "A keel that drags."
terms = "Y: v*|v|*r; N: v*v*r"
check = "yaw with drift"
[effects.typical]
Nvvr = -0.04

[[effects]]
name = "fins"
terms = '''
Y: a*v*|v|
N: -0.4*a*v*|v|
a ~ -0.01
'''
"""


def test_own_effects_come_from_a_file(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(FILE, encoding="utf-8")
    keel, fins = pk.own_effects(path)
    assert (keel.family, keel.check, keel.typical["Nvvr"]) == (
        "hull coupling",
        "yaw with drift",
        -0.04,
    )
    assert fins.typical == {"a": -0.01}


def test_a_damaged_file_names_everything_that_is_wrong(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(
        FILE.replace('terms = "Y: v*|v|*r', 'tems = 3\nterms = "Y: v*w*r').replace(
            'name = "fins"', 'name = "memory"'
        )
        + '[[effects]]\nname = 3\n[[effects]]\nname = "a"\nterms = "Y: v"\ntypical = 3\n',
        encoding="utf-8",
    )
    with pytest.raises(DataError) as caught:
        pk.own_effects(path)
    said = str(caught.value)
    for word in (
        "#1",
        "'tems'",
        "#2",
        "one of the catalogue",
        "#3",
        "terms is missing",
        "name must be a text",
        "#4",
        "typical must be a table of numbers",
    ):
        assert word in said, word
    path.write_text("x = 1", encoding="utf-8")
    with pytest.raises(DataError, match=r"Write \[\[effects\]\]"):
        pk.own_effects(path)
    with pytest.raises(DataError, match="does not exist"):
        pk.own_effects(tmp_path / "no.toml")


# In a diagnosis


def test_columns_are_those_of_the_polynomial():
    """Text and catalogue say the same; a named coefficient is the sum of its shares."""
    base = CaptiveBase(
        names={},
        values={},
        ship=SMALL.ship,
        water=SMALL.water,
        convention=Convention(),
        reference=1.5,
    )
    text = candidate_of(pk.own_effect("mine", "Y: v*v*r; N: v*|v|"))
    tied = candidate_of(pk.own_effect("tied", "Y: a*v*v*r; N: -0.4*a*v*|v|; a ~ 1"))
    known = polynomial("known", "hull", "", {"Yvvr": 1.0, "Nv|v|": 1.0})
    for view in View.of(SMALL):
        one, other, sum_ = (x.columns([view], base, 0.0)[0] for x in (text, known, tied))
        for channel, share in (("Y", [1.0, 0.0]), ("N", [0.0, -0.4])):
            np.testing.assert_allclose(one[channel], other[channel], rtol=1e-12)
            np.testing.assert_allclose(sum_[channel][:, 0], one[channel] @ share, rtol=1e-12)


@pytest.mark.slow
def test_an_own_effect_wins_where_the_catalogue_has_no_such_thing():
    """Yaw-sway coupling taken out of the catalogue and written as text."""
    mine = pk.own_effect(
        "mine",
        "Y: v*v*r + v*r*r; N: v*v*r + v*r*r",
        family="own",
        typical={"Yvvr": 0.02, "Yvrr": -0.04, "Nvvr": -0.04, "Nvrr": 0.002},
    )
    others = [x for x in captive_candidates() if x.name != "yaw_sway_coupling"]
    found = diagnose_captive(SMALL, "cubic", candidates=[*others, mine])
    assert found.group[0][0] == ("mine",)
    (finding,) = found.findings
    model = pk.without_effect(load_model("s175-3dof"), "yaw_sway_coupling")
    better = pk.with_effect(model, finding)
    assert better.values("hull_polynomial")["Nvvr"] == finding.coefficients["Nvvr"]
    assert finding.coefficients["Nvvr"] == pytest.approx(-0.0424, rel=0.3)


@pytest.mark.slow
def test_a_tied_effect_enters_a_model_with_its_shares():
    fins = pk.own_effect("fins", "Y: a*v*|v|; N: -0.4*a*v*|v|; a ~ -0.01")
    model = load_model("kcs")
    better = pk.with_effect(model, fins, coefficients={"a": -0.02})
    hull, scale = better.values("hull_polynomial"), model.ship.L / model.ship.d
    assert hull["Yv|v|"] == pytest.approx(0.02 * scale)  # kcs is written in β = -v'
    assert hull["Nv|v|"] == pytest.approx(-0.008 * scale)
    assert "Yv|v|" not in pk.without_effect(better, fins).values("hull_polynomial")
    finding = diagnose_captive(SMALL, "cubic").findings[0]
    with pytest.raises(ModelError, match="Give the own effect itself"):
        pk.with_effect(model, replace(finding, effect="fins", coefficients={"a": -0.02}))


@pytest.mark.slow
def test_one_written_by_hand_takes_part_too():
    """A candidate in Python: the coupling as one shape with a single coefficient."""

    def columns(views, base, value):
        of = {"Y": ("Yvvr", "Yvrr"), "N": ("Nvvr", "Nvrr")}
        size = {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156}
        return [
            {
                channel: view.project(
                    base.columns(names, view.motion, view.speed) @ [[size[n]] for n in names]
                )
                for channel, names in of.items()
            }
            for view in views
        ]

    own = Candidate(
        name="shape",
        family="own",
        kind="physics",
        summary="A shape.",
        coefficients=("share",),
        typical=(1.0,),
        columns=columns,
    )
    found = diagnose_captive(SMALL, "cubic", candidates=[own])
    assert found.group[0][0] == ("shape",)
    assert found.findings[0].coefficients["share"] == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize("typed", ["my bilge", "My Bilge", " my-bilge ", "my_Bilge"])
def test_a_name_of_words_is_made_valid_and_said(typed):
    with pytest.warns(UserWarning, match="is called my_bilge here"):
        assert pk.own_effect(typed, "Y: v*|v|*r").name == "my_bilge"


def test_two_names_that_become_one_stand_there_twice(tmp_path):
    file = tmp_path / "own.toml"
    entry = '[[effects]]\nname = "{}"\nterms = "Y: v*|v|*r"\n'
    file.write_text(entry.format("my_bilge") + entry.format("my bilge"), encoding="utf-8")
    with (
        pytest.warns(UserWarning, match="my_bilge"),
        pytest.raises(DataError, match="'my_bilge' stands there twice"),
    ):
        pk.own_effects(file)
