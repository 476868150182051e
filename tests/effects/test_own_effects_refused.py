"""Texts of own effects that are too long, too deep or absurd: an error with its place."""

from __future__ import annotations

import re

import pytest

import pmmkit as pk
from pmmkit.base import DataError
from pmmkit.effects.expressions import DEPTH, LONGEST

A = "; a ~ 0.01"
ABSURD = {
    "5000 factors": "Y: " + "*".join(["v"] * 5000),
    "100 factors": "Y: " + "*".join(["v"] * 100),
    "powers": "Y: v^9*r^9*u^9",
    "400 factors in an expression": "Y: a*Fn*" + "*".join(["v"] * 400) + A,
    "400 terms in an expression": "Y: " + " + ".join(["a*Fn"] * 400) + A,
    "brackets": "Y: a*" + "(" * 100 + "Fn" + ")" * 100 + A,
    "functions": "Y: a*" + "sin(" * 70 + "Fn" + ")" * 70 + A,
    "signs": "Y: a*" + "-" * 200 + "Fn" + A,
    "powers of powers": "Y: a*((((((Fn^9)^9)^9)^9)^9)^9)" + A,
    "functions written twice": "Y: a*" + "beyond(" * 25 + "Fn" + ", 0.1)" * 25 + A,
    "too large": "Y: 1e400*a*v" + A,
    "too large in an expression": "Y: 1e400*a*v*Fn" + A,
    "larger than any": "Y: 1e308*a*v*Fn + 1e308*a*v*Fn" + A,
    "many digits": "Y: " + "9" * 3000 + "*a*v*Fn" + A,
    "many digits of a power": "Y: a*v^" + "9" * 3000 + A,
    "size": "Y: a*v; a ~ 1e400",
}


@pytest.mark.parametrize("kind", ABSURD)
def test_an_absurd_text_is_refused_with_its_place(kind):
    with pytest.raises(DataError, match=r"Own effect keel: .* \(character \d+\)\.") as caught:
        pk.own_effect("keel", ABSURD[kind])
    head, line, mark = str(caught.value).split("\n")
    assert len(head) < 200
    assert len(line) < 130
    assert line[mark.index("^")] == ABSURD[kind][int(re.search(r"character (\d+)", head)[1]) - 1]


@pytest.mark.parametrize(
    "word", ["v", "phi", "L", "U", "rho", "unit", "sin", "sat", "maximum", "lambda", "late_keel_1"]
)
def test_a_coefficient_bears_no_name_that_has_a_meaning(word):
    """Such a one was put in the place of what it names, or ended the reading with a SyntaxError."""
    text = f"Y: {word}*r*Fn + {word}*lag(u, 1); {word} ~ 0.1"
    with pytest.raises(DataError, match=f"{word} has a meaning already") as caught:
        pk.own_effect("keel", text)
    assert f"(character {text.rindex(';') + 2})" in str(caught.value)
    pk.own_effect("keel", text.replace(word, "late_keeling"))


def test_what_is_usual_is_far_from_these_limits():
    inside = "(" * (DEPTH // 3) + "Fn" + ")" * (DEPTH // 3)
    text = "Y: " + " + ".join([f"a*beyond(v, 0.1)*|r|^3*{inside}"] * 6) + A
    effect = pk.own_effect("keel", text)
    assert effect.outputs == ("Y",)
    assert len(text) < LONGEST


def test_a_model_file_with_such_a_text_is_refused(tmp_path):
    keel = pk.own_effect("keel", "Y: a*sat(v, 0.1)*r; a ~ 0.01")
    model = pk.with_effect(pk.load_model("s175-3dof"), keel, coefficients="typical")
    pk.save_model(model, tmp_path / "m.toml")
    text = (tmp_path / "m.toml").read_text(encoding="utf-8")
    evil = text.replace("sat(v, 0.1)", "Fn" + "*v" * 1500)
    (tmp_path / "m.toml").write_text(evil, encoding="utf-8")
    with pytest.raises(DataError, match=r"(?s)m\.toml.*keel"):
        pk.load_model(tmp_path / "m.toml")
