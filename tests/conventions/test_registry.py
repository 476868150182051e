"""Registries: look-up, order, installed packages, the user's own, and what is derived of them."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from pmmkit.base import ModelError, Registry, UnknownNameError
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, TypeB
from pmmkit.conventions import METRICS, STRUCTURES
from pmmkit.effects import CATALOGUE
from pmmkit.identification.methods import METHODS as OF_RECORDS
from pmmkit.intake.checks import CHECKS
from pmmkit.models.library import SHIPS
from pmmkit.readers import READERS
from pmmkit.reduction.methods.registry import METHODS as OF_TABLES
from pmmkit.simulation import MANOEUVRES

EVERY = (
    *(CATALOGUE, READERS, MANOEUVRES, TEST_KINDS, STRUCTURES, OF_RECORDS, OF_TABLES, SHIPS),
    *(CHECKS, METRICS, RUN_SETTINGS, TypeB.STATABLE),
)


@dataclass(frozen=True)
class Knot:
    name: str
    strands: int = 2


def knots(*own: str, **how) -> Registry[Knot]:
    return Registry(Knot, lambda: map(Knot, own or ("bowline", "clove_hitch")), what="knot", **how)


@pytest.mark.parametrize("registry", EVERY, ids=lambda registry: registry.what)
def test_every_registry_names_its_entries_once_and_guesses_a_name(registry):
    names = list(registry)
    assert len(names) == len(set(names)) == len(registry) > 1
    assert all(registry[name].name == name for name in names)
    assert all(isinstance(entry, registry.kind) for entry in registry.values())
    assert list(registry.own) == names[: len(registry.own)]
    with pytest.raises(UnknownNameError) as told:
        registry["no such name at all"]
    assert all(name in str(told.value) for name in names)


def test_a_name_that_is_not_there_is_answered_with_the_nearest():
    with pytest.raises(UnknownNameError, match="There is no knot 'bowlin'; did you mean 'bowline'"):
        knots()["bowlin"]
    with pytest.raises(UnknownNameError, match="No 'x' of bowline, clove_hitch, or a splice"):
        knots(unknown="No {name!r} of {names}, or a splice")["x"]


def test_what_is_no_name_is_not_in_it():
    found = knots()
    assert "bowline" in found
    assert not any(x in found for x in ("reef", 3, None))
    assert (found.get("reef"), found.get("bowline")) == (None, Knot("bowline"))


def test_nothing_is_made_before_it_is_asked_for_and_other_packages_only_where_they_must_be(
    monkeypatch,
):
    asked = []

    def own():
        asked.append("own")
        return [Knot("bowline")]

    def points(group):
        asked.append(group)
        return [SimpleNamespace(name="reef", dist=None, load=lambda: Knot("reef"))]

    monkeypatch.setattr("importlib.metadata.entry_points", points)
    found = Registry(Knot, own, what="knot", group="knots")
    assert asked == []
    assert found["bowline"].strands == 2
    assert asked == ["own"]
    assert found["reef"] == Knot("reef")
    assert list(found) == ["bowline", "reef"]
    assert asked == ["own", "knots"]
    found.reload()
    assert list(found.own) == ["bowline"]
    assert asked == ["own", "knots", "own"]


def test_a_registered_entry_takes_part_until_it_is_forgotten():
    found = knots()
    found.register(Knot("reef"))
    assert list(found) == ["bowline", "clove_hitch", "reef"]
    found.register(Knot("reef", strands=3))
    assert (found["reef"].strands, found.edition("reef")) == (3, 2)
    found.forget("reef")
    found.forget("reef")
    assert "reef" not in found
    assert found.edition("reef") == 3
    with pytest.raises(ModelError, match="already: choose another name"):
        found.register(Knot("bowline"))
    with pytest.raises(ModelError, match="no name"):
        found.register(Knot("a b"))


def test_what_is_derived_is_made_again_where_the_entries_change():
    made = []

    def strands(entries):
        made.append(1)
        return sum(entry.strands for entry in entries)

    found = knots()
    assert found.derived(strands) == found.derived(strands) == 4
    found.register(Knot("reef", strands=5))
    assert found.derived(strands) == 9
    found.forget("reef")
    assert found.derived(strands) == 4
    found.reload()
    assert found.derived(strands) == 4
    assert len(made) == 4


def test_some_may_come_first():
    assert [x.name for x in knots("a", "b", "c").ordered("c", "a")] == ["c", "a", "b"]


def test_modules_of_a_package_are_walked_in_an_order(tmp_path, monkeypatch):
    folder = tmp_path / "locker_of_a_test"
    (folder / "deep").mkdir(parents=True)
    head = "from types import SimpleNamespace as Named" + chr(10)
    for name, listed in (
        ("__init__", ""),
        ("b", f"{head}KNOTS = (Named(name='b'),)"),
        ("a", f"{head}KNOTS = (Named(name='a'),)"),
        ("none", ""),
        ("deep/__init__", ""),
        ("deep/c", f"{head}KNOTS = (Named(name='c1'), Named(name='c2'))"),
    ):
        (folder / f"{name}.py").write_text(listed, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    found = knots("reef", listed="locker_of_a_test:KNOTS", first=("deep.c",))
    assert list(found) == ["reef", "c1", "c2", "a", "b"]


def test_the_contract_of_an_entry_is_found_by_its_name():
    STRUCTURES.check(STRUCTURES["cubic"])
    MANOEUVRES.check(MANOEUVRES["straight"])
    RUN_SETTINGS.check(RUN_SETTINGS["drift"])
    TEST_KINDS.check(TEST_KINDS["static_drift"])
    with pytest.raises(AssertionError, match="Setting"):
        RUN_SETTINGS.check(RUN_SETTINGS["drift"].__class__(name="x", unit="deg", meaning="m"))
