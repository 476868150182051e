"""Entries of the catalogue hidden in the runs of a user: what a name may stand for."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.base import DataError
from pmmkit.diagnosis import begin, candidate_of
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.hidden_entries import digest_of, end_of
from pmmkit.diagnosis.evidence import PRICE, Visible
from pmmkit.diagnosis.outside import (
    FILE,
    HiddenEntries,
    HiddenEntry,
    read_hidden_entries,
    save_hidden_entries,
)
from pmmkit.effects import CATALOGUE

FEW = [
    candidate_of(CATALOGUE[name])
    for name in ("fault_misalignment", "current", "memory", "asymmetry", "even_hull_terms")
]
"""Two that turn the flow, which are alike, and three others; what each run draws takes part too."""


class Interrupted(Exception):
    """What Control-C is to a user."""


def asked(folder, effects=None, *, seed=5, candidates=FEW, outside=True, **settings):
    """A diagnosis of the small programme, whose campaign lies in a folder."""
    campaign = replace(hidden_campaign("small", effects or {}, seed=seed), folder=folder)
    return diagnose_captive(campaign, BASE, candidates=candidates, outside=outside, **settings)


def without(name):
    return [item for item in FEW if item.name != name]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with the table of the small programme."""
    folder = tmp_path_factory.mktemp("made")
    asked(folder)
    return folder


def table_of(folder):
    (table,) = read_hidden_entries(folder / FILE).values()
    return table


# The probability, by hand


def visible(name, signal, left):
    return Visible(
        name=name,
        family="",
        signal=signal,
        without_a_run=left,
        hides=1.0,
        shown=True,
        why="",
        mimics={},
    )


def by_hand(*called):
    """Four entries of two families, one of them alone in its own: q = 1/4; eight hidden entries."""
    ends = [HiddenEntry(effect="d", size=1.0, end="named", names=x, log_odds=y) for x, y in called]
    nothing = HiddenEntry(effect="d", size=1.0, end="noise")
    return HiddenEntries(
        digest="",
        families={"a": "one", "b": "one", "c": "one", "d": "two"},
        ends=(*ends, *[nothing] * (8 - len(ends))),
    )


def test_the_probability_is_that_of_bayes():
    """At the score of the stand-in, and of the entry itself, every density is one: with one of
    eight called so, and one of two sizes found, 4 q/(1 - q) (1/8)/(1/2) to 1."""
    covered = [visible("a", 2 * (50.0 + PRICE), 20.0)]  # seen at its usual size alone
    table = by_hand((("a",), (50.0,)))
    odds = 4 * 0.25 / 0.75 * (1 / 8) / (1 / 2)
    assert table.unknown_family == 0.25
    assert table.probability({"a": 50.0}, covered) == pytest.approx(odds / (1 + odds))


def test_a_score_far_from_that_of_the_stand_in_speaks_for_the_name():
    """Ten times the size is a hundred times the score: it falls by e for each 1/0.3."""
    covered = [visible("a", 2 * (500.0 + PRICE), 20.0)]
    table = by_hand((("a",), (5.0,)))
    odds = 4 * 0.25 / 0.75 * (1 / 8) / (1 / 2) * np.exp(-np.log(100.0) / np.log(1 / 0.3))
    assert table.probability({"a": 500.0}, covered) == pytest.approx(odds / (1 + odds))


def test_a_name_that_nothing_got_has_a_share_of_those_still_unseen():
    """One name was got once: 1/8 of what is hidden next gets a new one, each of three alike."""
    covered = [visible(x, 2 * (50.0 + PRICE), 20.0) for x in "ab"]
    table = by_hand((("a",), (50.0,)))
    odds = 4 * 0.25 / 0.75 * (1 / 8 / 3) / (1 / 2)
    assert table.probability({"b": 50.0}, covered) == pytest.approx(odds / (1 + odds))


def test_two_names_for_one_thing_outside_cost_the_odds_of_an_entry_more():
    """Both names right is as rare as an entry squared: 80 times as much for what got both."""
    covered = [visible(x, 2 * (50.0 + PRICE), 20.0) for x in "ab"]
    table = by_hand((("a", "b"), (50.0, 50.0)))
    odds = 4 * 0.25 / 0.75 * 80.0 * (1 / 8) / (1 / 2) ** 2
    found = table.probability({"a": 50.0, "b": 50.0}, covered)
    assert found == pytest.approx(odds / (1 + odds))


# The virtual tank, whose forms are its own


@pytest.mark.slow
def test_a_turned_model_is_called_a_current_as_was_foretold(made):
    """The table hides the catalogue's misalignment in other noise; the tank turns its model."""
    (foretold,) = (
        x for x in table_of(made).ends if (x.effect, x.size) == ("fault_misalignment", 1.0)
    )
    assert (foretold.end, foretold.names) == ("named", ("current",))
    campaign = hidden_campaign("small", {"fault_misalignment": 1.0}, seed=77)
    plain = diagnose_captive(campaign, BASE, candidates=without("fault_misalignment"))
    assert (plain.best, plain.flags, plain.outside) == (("current",), (), None)
    told = plain.beside(table_of(made))
    assert told.flags == ("perhaps_outside", str(told.outside))
    assert told.outside.probability > 0.05
    assert told.outside.may_be == ("current", "fault_misalignment")
    assert "fault_misalignment got this name" in str(told)
    assert "not the whole story" not in str(told)
    assert told.to_dict()["outside"]["may_be"] == ["current", "fault_misalignment"]


@pytest.mark.slow
def test_a_name_that_nothing_else_gets_is_surer(made):
    """Even terms of the tank's own form: of four families two have one entry, so much is unknown;
    but nothing that was hidden is called so with such odds."""
    campaign = hidden_campaign("small", {"even_hull_terms": 1.0}, seed=78)
    told = diagnose_captive(campaign, BASE, candidates=FEW).beside(table_of(made))
    campaign = hidden_campaign("small", {"current": 1.0}, seed=78)
    turned = diagnose_captive(campaign, BASE, candidates=FEW).beside(table_of(made))
    assert told.best == ("even_hull_terms",)
    assert turned.best[0] in ("current", "fault_misalignment")
    assert told.outside.probability < 0.5 * turned.outside.probability


@pytest.mark.slow
def test_hidden_forces_are_those_of_the_tank(made):
    """An effect is called the same by the catalogue's form of it and by the tank's own."""
    for effect in ("memory", "even_hull_terms"):
        (foretold,) = (x for x in table_of(made).ends if (x.effect, x.size) == (effect, 1.0))
        campaign = hidden_campaign("small", {effect: 1.0}, seed=79)
        found = diagnose_captive(campaign, BASE, candidates=without(effect))
        end = end_of(effect, 1.0, found)
        silent = {"not_shown": "noise"}  # too small in these runs for anybody to ask
        assert (end.end, end.names) == (silent.get(foretold.end, foretold.end), foretold.names)


# The table and its file


@pytest.mark.slow
def test_it_is_used_without_being_asked_again(made, tmp_path):
    shutil.copy(made / FILE, tmp_path)
    found = asked(tmp_path, outside=False)
    assert found.verdict == "noise"
    assert found.outside is None  # nothing is named
    one = SimpleNamespace(count=0)
    asked(tmp_path, progress=lambda done, total, what: setattr(one, "count", one.count + 1))
    assert one.count == 1  # that it was there
    assert (tmp_path / FILE).read_bytes() == (made / FILE).read_bytes()


@pytest.mark.slow
def test_a_session_uses_it_too(tmp_path):
    campaign = replace(hidden_campaign("small", {"current": 1.0}, seed=80), folder=tmp_path)
    made = begin(BASE, campaign, candidates=FEW[:2], outside=True).diagnose()
    found = begin(BASE, campaign, candidates=FEW[:2]).diagnose()
    assert found.best == ("current",)
    assert found.outside == made.outside
    assert found.outside.probability is not None


@pytest.mark.slow
def test_an_interrupted_one_loses_nothing_whoever_works(made, tmp_path):
    told = []

    def stop(done, total, what):
        told.append((done, total))
        if done == 4:
            raise Interrupted

    with pytest.raises(Interrupted):
        asked(tmp_path, progress=stop)
    assert not table_of(tmp_path).complete
    assert len(table_of(tmp_path).ends) == 4
    assert asked(tmp_path, outside=False).outside is None  # of half a table nothing is said
    told.clear()
    asked(tmp_path, executor=2, progress=lambda done, total, what: told.append((done, total)))
    assert told == [*((done, 12) for done in range(5, 13)), (12, 12)]
    assert (tmp_path / FILE).read_bytes() == (made / FILE).read_bytes()


@pytest.mark.slow
def test_a_damaged_file_is_told_and_made_anew(made, tmp_path):
    text = (made / FILE).read_text()
    other = json.loads(text)
    other["tables"][0]["ends"][0]["size"] = 0.7
    for spoiled in (text[: len(text) // 2], "[1, 2]", "", json.dumps(other)):
        (tmp_path / FILE).write_text(spoiled)
        with pytest.raises(DataError, match="damaged"):
            read_hidden_entries(tmp_path / FILE)
    found = asked(tmp_path, outside=False)
    assert any("damaged and not used" in note for note in found.notes)
    assert asked(tmp_path).notes == ()
    assert (tmp_path / FILE).read_bytes() == (made / FILE).read_bytes()


def test_tables_of_other_bases_stay(tmp_path):
    first = by_hand((("a",), (50.0,)))
    other = replace(first, digest="other", ends=first.ends[:3])
    assert save_hidden_entries(tmp_path / FILE, first)
    assert save_hidden_entries(tmp_path / FILE, other)
    assert read_hidden_entries(tmp_path / FILE) == {"": first, "other": other}
    assert read_hidden_entries(tmp_path / "nothing.json") == {}


@pytest.mark.slow
def test_the_digest_is_that_of_programme_noise_base_and_catalogue():
    def of(campaign, base=BASE, candidates=FEW, given=(), **settings):
        return digest_of(captive_system(campaign, base, candidates=candidates, **settings), given)

    plain = hidden_campaign("small", seed=5)
    later = plain.with_(runs=(*plain.runs[:-1], replace(plain.runs[-1], id="another")))
    assert of(plain) == of(hidden_campaign("small", seed=5)) == of(later)
    turned = plain.runs[0].with_(settings=replace(plain.runs[0].settings, drift=0.1))
    others = [
        of(plain.with_(runs=(turned, *plain.runs[1:]))),
        of(plain.with_(runs=plain.runs[:-1])),
        of(hidden_campaign("small", seed=5, noise="double")),
        of(plain, base=BASE[:-1]),
        of(plain, candidates=FEW[:-1]),
        of(plain, given=("memory",)),
        of(plain, floor=0.01),
    ]
    assert len({of(plain), *others}) == 1 + len(others)


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    campaign = replace(hidden_campaign("small", seed=5), folder=tmp_path / "file")
    found = diagnose_captive(campaign, BASE, candidates=FEW[:2], outside=True)
    assert any("cannot be written" in note for note in found.notes)
