"""Models as data: files without loss, damage that is named, values over Fn, tables on ships."""

from __future__ import annotations

import random
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.base import (
    DataError,
    ExtrapolationError,
    MissingPartError,
    ModelError,
    PmmkitError,
    UnknownNameError,
)
from pmmkit.conventions import Convention, Water
from pmmkit.files import toml_text
from pmmkit.models import Part, from_values, load_model, model_text, save_model, scaled, to_model
from pmmkit.models.library import SHIPS

MODEL_SCALE = 36.0
GRID = (0.145, 0.217, 0.290)


def tank_model(ship):
    """The ship at 1:36."""
    s = MODEL_SCALE
    return replace(
        ship,
        name="S175 model",
        L=ship.L / s,
        B=ship.B / s,
        d=ship.d / s,
        volume=ship.volume / s**3,
        mass=ship.mass / s**3,
        Izz=ship.Izz / s**5,
    )


def s175_table(without=(), Fn=None, std=None, **changes):
    """A table of the S175 as Son and Nomoto's values, at model scale."""
    library = load_model("s175-3dof")
    values = {**library.values("hull_polynomial"), **library.values("added_mass")} | changes
    values = {name: x for name, x in values.items() if name != "lx" and name not in without}
    return from_values(
        values,
        ship=tank_model(library.ship),
        water=Water(rho=999.1),
        Fn=Fn,
        std=std,
        convention=library.convention,
    )


# Files

WRITABLE = st.text(st.characters(exclude_categories=["Cs"]), max_size=60)


@pytest.mark.slow
@given(
    data=st.recursive(
        st.dictionaries(
            WRITABLE,
            st.one_of(
                st.floats(allow_nan=False),
                st.integers(-(2**62), 2**62),
                st.booleans(),
                WRITABLE,
                st.lists(st.floats(allow_nan=False), max_size=30),
                st.lists(WRITABLE, max_size=5),
                st.lists(st.lists(st.floats(allow_nan=False), max_size=9), max_size=5),
            ),
            max_size=5,
        ),
        lambda inner: st.dictionaries(WRITABLE, inner, max_size=4),
        max_leaves=6,
    )
)
def test_whatever_is_written_as_toml_is_read_back_equal(data):
    assert tomllib.loads(toml_text(data)) == data


def test_line_breaks_of_unicode_inside_long_lists_stay_as_they_are():
    data = {"notes": ["x" * 90, "next line \x85 and \u2028 paragraph", ["a" * 80, "b\x85"]]}
    assert tomllib.loads(toml_text(data)) == data


def test_a_model_is_saved_and_loaded_without_loss(tmp_path):
    table = s175_table(
        Fn=GRID, std={"Yv": [1e-5, 2e-5, 3e-5], "Nr": 1e-6}, Yv=[-0.0116, -0.012, -0.013]
    )
    model = to_model(table, "s175-3dof")
    path = tmp_path / "made" / "model.toml"
    save_model(model, path)
    again = load_model(path)
    assert model_text(again) == model_text(model)
    assert again.ship == model.ship
    assert again.water == model.water
    assert again.convention == model.convention
    assert {k: dict(p.values) for k, p in again.parts.items()} == {
        k: dict(p.values) for k, p in model.parts.items()
    }
    np.testing.assert_array_equal(again.covariance, model.covariance)
    assert list(tmp_path.rglob("*.part*")) == []


def test_the_file_is_written_the_same_every_time(tmp_path):
    texts = set()
    for i in range(3):
        save_model(load_model("s175"), tmp_path / f"{i}.toml")
        texts.add((tmp_path / f"{i}.toml").read_bytes())
    assert len(texts) == 1


LIBRARY_TEXT = SHIPS["s175"].file.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("schema = 1", "schema = 99", "schema is 99"),
        ("schema = 1", "", "schema is None"),
        ("Yv = -0.0116", "Yv = nan", "Yv"),
        ("Yv = -0.0116", 'Yv = "-0.0116"', "Yv"),
        ("Yv = -0.0116", "Yw = -0.0116", "Yw"),
        ("Yv = -0.0116", "Yv = [-0.0116, -0.012]", "2 values for 0 Froude numbers"),
        ("Yv = -0.0116", "Yvdot = -0.0116", "takes no Yvdot"),
        ("Yvvr = 0.0214", "Yvrv = 0.0214", "is spelled Yvvr"),
        ("L = 175.0", "L = -175.0", "must be positive"),
        ("L = 175.0", f"L = 1{'0' * 400}", "absurdly large"),
        ("L = 175.0", "", "ship lacks L"),
        ("L = 175.0", "L = 175.0\nlength = 3.0", "ship.length is not known"),
        ("GM = 0.3\n", "\n", "needs GM"),
        ("D = 6.533", "", "propeller lacks D"),
        ('wake = "son-nomoto"', 'wake = "son"', "possible: constant, son-nomoto, mmg"),
        ('system = "prime"', 'system = "bis2"', "convention.system"),
        ("[effects.roll]", "[effects.rolls]", "no effect 'rolls'"),
        ("t = 0.175", "t = 1.75", "outside"),
        ("rate_deg_s = 5.0", "rate_deg_s = 0.0", "outside"),
        ("[water]", "[watre]", "watre"),
        ("Kv = 0.0003026", "Kv = 0.0003026\nYT = 1.0", "thrust"),
        ("Kpdot =", "Kudot =", "no place for Kudot"),
    ],
)
def test_a_wrong_entry_is_named_with_its_file(tmp_path, old, new, says):
    assert old in LIBRARY_TEXT
    path = tmp_path / "wrong.toml"
    path.write_text(LIBRARY_TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert says in str(caught.value)
    assert all(problem.file == str(path) for problem in caught.value.problems)


def test_all_faults_of_a_file_are_named_at_once(tmp_path):
    text = LIBRARY_TEXT.replace("L = 175.0", "L = 0.0").replace("Yv = -0.0116", "Yv = true")
    text = text.replace('system = "prime"', 'system = "metric"')
    path = tmp_path / "wrong.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert len(caught.value.problems) == 3


@pytest.mark.parametrize("seed", range(60))
def test_a_damaged_file_gives_a_model_or_an_error_of_ours(tmp_path, seed):
    """Bytes flipped, the file cut, lines swapped or doubled: never a traceback of a library."""
    chance = random.Random(seed)
    content = bytearray(LIBRARY_TEXT.encode())
    kind = seed % 4
    if kind == 0:
        for _ in range(chance.randrange(1, 6)):
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif kind == 1:
        content = content[: chance.randrange(len(content))]
    else:
        lines = content.split(b"\n")
        a, b = chance.randrange(len(lines)), chance.randrange(len(lines))
        if kind == 2:
            lines[a], lines[b] = lines[b], lines[a]
        else:
            lines.insert(b, lines[a])
        content = bytearray(b"\n".join(lines))
    path = tmp_path / "damaged.toml"
    path.write_bytes(content)
    try:
        model = load_model(path)
    except ModelError:
        return
    assert np.all(np.isfinite([x for part in model.parts for x in model.values(part).values()]))


@pytest.mark.parametrize(
    "content", [b"", b"\xff\xfe\x00", b"schema = 1", b"a" * 10_000, b"[" * 5000, b"\x00" * 64]
)
def test_files_that_are_no_models(tmp_path, content):
    path = tmp_path / "no.toml"
    path.write_bytes(content)
    with pytest.raises(ModelError):
        load_model(path)


def test_a_cut_file_never_reads_as_a_smaller_model(tmp_path):
    """The last part of the file is needed: a model that lost its roll part is refused."""
    path = tmp_path / "cut.toml"
    path.write_text(LIBRARY_TEXT[: LIBRARY_TEXT.index("[effects.roll]")], encoding="utf-8")
    with pytest.raises(ModelError, match="no part 'roll'"):
        load_model(path)


# Values over the Froude number


def speed_dependent():
    return to_model(s175_table(Fn=GRID, Nr=[-0.002, -0.003, -0.005]), "s175-3dof")


def test_values_between_froude_numbers_lie_on_the_line():
    model = speed_dependent()
    for Fn, Nr in ((0.145, -0.002), (0.181, -0.0025), (0.217, -0.003), (0.2535, -0.004)):
        assert model.values("hull_polynomial", Fn)["Nr"] == pytest.approx(Nr, rel=1e-12)
    assert model.values("hull_polynomial", 0.2)["Yv"] == pytest.approx(-0.0116, rel=1e-12)


def test_beyond_the_range_a_value_is_refused_unless_asked_for():
    model = speed_dependent()
    with pytest.raises(ExtrapolationError, match=r"0\.145 to 0\.29"):
        model.values("hull_polynomial", 0.32)
    carried = model.values("hull_polynomial", 0.3265, extrapolate=True)["Nr"]
    assert carried == pytest.approx(-0.006, rel=1e-9)
    at_the_end = model.values("hull_polynomial", 0.29 * 1.0005)["Nr"]
    assert at_the_end == -0.005
    with pytest.raises(ModelError, match="say which"):
        model.values("hull_polynomial")


# From a table to a model


def test_a_table_on_its_ship_gives_the_table_back():
    table = s175_table(Fn=GRID)
    model = to_model(table, "s175-3dof")
    for i, Fn in enumerate(GRID):
        found = model.values("hull_polynomial", Fn) | model.values("added_mass", Fn)
        for name, value in table.at(GRID[i]).items():
            assert found[name] == value
    assert model.ship.L == 175.0
    assert "1:36 model tests" in model.scale
    assert "Froude" in model.scale
    assert "self-propulsion" in model.scale
    assert model.parts["hull_polynomial"].source_of("Yv") == "measured: S175 model"
    assert model.parts["propeller"].source_of("D") == "library: Son and Nomoto 1981"


def test_a_three_dof_table_on_the_rolling_ship_gives_three_degrees_of_freedom():
    model = to_model(s175_table(), "s175")
    assert not model.rolls
    assert any("Three degrees of freedom" in note for note in model.notes)


def test_a_four_dof_table_keeps_roll():
    library = load_model("s175")
    values = {**library.values("hull_polynomial"), **library.values("added_mass")}
    del values["lx"]
    table = from_values(
        values,
        ship=library.ship,
        water=library.water,
        convention=library.convention.with_(coriolis="in-derivatives"),
    )
    assert to_model(table, "s175").rolls
    three = to_model(table, "s175-3dof")
    assert not three.rolls
    assert "Kphi" not in three.parts["hull_polynomial"].values
    assert "Yphi" not in three.parts["hull_polynomial"].values


def test_a_missing_derivative_is_named_with_the_tests_that_give_it():
    with pytest.raises(MissingPartError) as caught:
        to_model(s175_table(without=["Nr", "Xvr"]), "s175")
    text = str(caught.value)
    assert "Nr is not in the table. It comes from: pure yaw or circular motion." in text
    assert "Xvr is not in the table. It comes from: yaw with drift" in text


def test_a_gap_at_some_speeds_is_named_with_them_and_with_the_way_out():
    table = s175_table(Fn=GRID, Nr=[-0.0022, float("nan"), -0.002])
    with pytest.raises(MissingPartError) as caught:
        to_model(table, "s175")
    assert "Nr has no value at Fn 0.217." in str(caught.value)
    assert 'fn="pooled"' in str(caught.value)
    with pytest.raises(MissingPartError) as caught:
        to_model(s175_table(without=["Nr"]), "s175")
    assert "pooled" not in str(caught.value)


def test_what_the_runs_do_not_determine_is_not_zero():
    table = s175_table(Yvvr=float("nan"))
    with pytest.raises(MissingPartError, match="Yvvr has no value"):
        to_model(table, "s175")
    model = to_model(table, "s175", missing="zero")
    assert model.values("hull_polynomial")["Yvvr"] == 0.0
    assert model.parts["hull_polynomial"].source_of("Yvvr") == "assumed: zero"
    assert any("Yvvr" in note for note in model.notes)


def test_the_essential_derivatives_are_never_taken_as_zero():
    for name in ("Xuu", "Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot"):
        with pytest.raises(MissingPartError, match=name):
            to_model(s175_table(without=[name]), "s175", missing="zero")


def test_acceleration_derivatives_can_come_from_the_library_in_any_system():
    table = s175_table(without=["Xudot", "Nrdot"])
    model = to_model(table, "s175", missing="library")
    assert model.values("added_mass")["Nrdot"] == -0.000419
    assert model.parts["added_mass"].source_of("Nrdot") == "library: s175"
    in_d = table.with_(convention=table.convention.with_(system="prime-d"))
    borrowed = to_model(in_d, "s175", missing="library").values("added_mass")["Nrdot"]
    assert borrowed == pytest.approx(-0.000419 * 175 / 8.5)
    with pytest.raises(MissingPartError, match="Xvr"):
        to_model(s175_table(without=["Xvr"]), "s175", missing="library")


def test_rudder_terms_and_offsets_of_the_tests_stay_out():
    model = to_model(s175_table(Yd=-0.003, Nd=0.0015, Y0=1e-5, XT=0.9), "s175-3dof")
    assert not {"Yd", "Nd", "Y0", "XT"} & set(model.parts["hull_polynomial"].values)
    assert any("Yd, Nd" in note for note in model.notes)
    assert any("Y0" in note for note in model.notes)


def test_a_table_of_another_hull_is_refused():
    table = s175_table()
    other = table.with_(ship=replace(table.ship, B=1.5 * table.ship.B))
    with pytest.raises(ModelError, match="L/B"):
        to_model(other, "s175")
    near = table.with_(ship=replace(table.ship, B=1.04 * table.ship.B))
    assert any("L/B" in note for note in to_model(near, "s175").notes)


def test_a_table_about_another_point_is_refused():
    table = s175_table()
    shifted = table.with_(convention=table.convention.with_(moment_reference_x=0.1))
    with pytest.raises(ModelError, match="midship"):
        to_model(shifted, "s175")


def test_few_degrees_of_freedom_widen_the_ships_that_are_drawn():
    """JCGM 101:2008, 6.4.9: with 4 degrees of freedom 95 % lie within 2.776 u, not 1.960 u."""
    table = s175_table()
    n = len(table.names)
    known = table.with_(
        covariance=1e-8 * np.eye(n).reshape(1, n, 1, n),
        dof=np.where(np.arange(n) < 3, 4.0, np.inf)[None],
    )
    model = to_model(known, "s175-3dof")
    low, high = known.interval()
    drawn = 1.959964 * np.sqrt(np.diagonal(model.covariance))
    half = [(high - low)[0, known.index(name)] / 2 for name in model.covariance_names]
    assert drawn == pytest.approx(half, rel=1e-6)
    assert max(half) / min(half) == pytest.approx(2.776445 / 1.959964, rel=1e-6)


def test_the_covariance_of_the_table_goes_along():
    table = s175_table(Fn=GRID, std={"Yv": [1e-5, 2e-5, 3e-5]})
    model = to_model(table, "s175-3dof")
    n = len(model.covariance_names)
    place = model.covariance_names.index("Yv")
    for row, std in enumerate((1e-5, 2e-5, 3e-5)):
        assert model.covariance[row * n + place, row * n + place] == pytest.approx(std**2)
    assert to_model(s175_table(), "s175-3dof").covariance is None


def test_words_that_are_not_known_are_refused():
    with pytest.raises(DataError, match="refuse, zero, library"):
        to_model(s175_table(), "s175", missing="guess")
    with pytest.raises(UnknownNameError):
        to_model(s175_table(), "s176")


# Models in memory


def test_a_model_that_makes_no_sense_cannot_be_made():
    model = load_model("s175-3dof")
    with pytest.raises(ModelError, match="no effect 'sails'"):
        model.with_(parts={**model.parts, "sails": Part(effect="sails")})
    with pytest.raises(ModelError, match="symmetric"):
        model.with_(covariance=np.array([[1.0, 0.5], [0.0, 1.0]]), covariance_names=("Yv", "Nv"))
    with pytest.raises(ModelError, match="expected"):
        model.with_(covariance=np.eye(3), covariance_names=("Yv", "Nv"))
    with pytest.raises(ModelError, match="ascend"):
        model.with_(Fn=(0.2, 0.1))
    with pytest.raises(ModelError, match="midship"):
        model.with_(convention=Convention(motion_reference_x=2.0))
    with pytest.raises(MissingPartError, match="no part 'shaft'"):
        model.part("shaft")


@settings(max_examples=20)
@given(length=st.floats(0.5, 400.0))
def test_scaling_there_and_back_changes_nothing(length):
    model = load_model("s175")
    back = scaled(scaled(model, length), model.ship.L)
    assert back.ship.mass == pytest.approx(model.ship.mass, rel=1e-12)
    assert back.ship.Izz == pytest.approx(model.ship.Izz, rel=1e-12)
    for effect in model.parts:
        for name, value in model.values(effect).items():
            assert back.values(effect)[name] == pytest.approx(value, rel=1e-12)
    assert f"L = {length:g} m" in scaled(model, length).scale


def test_scaling_to_nothing_is_refused():
    for length in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(PmmkitError, match="positive"):
            scaled(load_model("s175"), length)


def test_a_file_saved_by_version_1_loads_for_ever():
    """Kept as it was written by schema 1: values over Fn, odd names, a covariance with gaps."""
    model = load_model(Path(__file__).parents[1] / "data" / "model_v1.toml")
    assert model.Fn == (0.15, 0.29)
    assert model.values("hull_polynomial", 0.22)["Nr"] == pytest.approx(-0.00215)
    assert model.values("hull_polynomial", 0.22)["Yv|v|"] == pytest.approx(-0.01)
    assert model.covariance is not None
    n = len(model.covariance_names)
    assert model.covariance.shape == (2 * n, 2 * n)
    place = n + model.covariance_names.index("Yv")
    assert model.covariance[place, place] == pytest.approx(4e-10, rel=1e-12)
    assert np.isnan(model.covariance[0, 0])
    assert model.parts["rudder_mmg"].options["inflow"] == "son-nomoto"


def test_a_file_with_later_effects_loads_for_ever():
    """Kept as it was written: cross-flow drag, Kose's wake, wind, options, one covariance."""
    file = Path(__file__).parents[1] / "data" / "model_v1_effects.toml"
    model = load_model(file)
    assert list(model.parts) == [
        "hull_polynomial",
        "crossflow_drag",
        "added_mass",
        "propeller",
        "rudder_mmg",
        "wind",
    ]
    assert model.values("hull_polynomial")["Y|u|v"] == -0.3728
    assert model.parts["propeller"].options == {"wake": "kose"}
    assert model.values("wind")["AL"] == 0.52
    assert model.parts["wind"].source == "measured: drawing"
    np.testing.assert_array_equal(model.covariance, [[1e-4, -1e-6], [-1e-6, 4e-6]])
    text = file.read_text(encoding="utf-8").replace("schema = 1", "schema = 2")
    text = text.replace('history = ["a step"]\n', "")
    step = '[[steps]]\naction = "noted"\nnote = "a step"\n\n'
    first = "[effects.hull_polynomial]"
    text = text.replace(first, step + first)
    name = next(line for line in text.splitlines() if line.startswith("name = "))
    assert model_text(model) == f"{text.replace(name, name + chr(10) + 'closed = true')}\n[end]\n"


@pytest.mark.slow
def test_a_model_file_that_pmmkit_wrote_is_whole_or_refused(tmp_path):
    """Cut at every fourth byte, and before and behind every line end."""
    whole = model_text(load_model("s175-3dof")).encode()
    ends = {at for at in range(len(whole)) if whole[at : at + 1] == b"\n"}
    last = max(ends)
    for cut in sorted({*range(0, last, 4), *ends, *(at + 1 for at in ends)} - {last, last + 1}):
        (tmp_path / "m.toml").write_bytes(whole[:cut])
        with pytest.raises(ModelError):
            load_model(tmp_path / "m.toml")


def test_a_part_that_is_taken_out_leaves_nothing_in_the_covariance():
    """A resistance curve that was fitted has uncertainties; the model without it has none of it."""
    model = pk.with_effect(
        load_model("s175-3dof"), "resistance_curve", coefficients="typical", Fn=(0.2, 0.3)
    )
    names = ("Yv", *(f"resistance_curve.{name}" for name in model.values("resistance_curve")))
    variances = np.arange(1.0, len(names) + 1)
    fitted = model.with_(
        covariance=np.diag(np.tile(variances, len(model.Fn) or 1)), covariance_names=names
    )
    left = pk.without_effect(fitted, "resistance_curve")
    assert left.covariance_names == ("Yv",)
    assert left.covariance.tolist() == np.eye(len(left.Fn) or 1).tolist()


@pytest.mark.parametrize("wrong", ["table", 5, None])
def test_what_is_no_model_is_told_what_makes_one(wrong):
    """A table of derivatives was taken for the name of a file, longer than a name can be."""
    ship = load_model("s175-3dof").ship
    table = from_values({"Yv": -0.01}, ship=ship, water=Water(rho=1000.0, g=9.81))
    with pytest.raises(ModelError, match=r"to_model\(table\)"):
        pk.simulate(table if wrong == "table" else wrong, speed=9.0)
