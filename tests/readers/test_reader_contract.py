"""Readers keep their word: those of pmmkit, one of one file, one of another package."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
import warnings
from dataclasses import fields, replace
from pathlib import Path

import lab_log
import numpy as np
import pytest
from installed_readers import installed
from lab_log import Log

import pmmkit.readers as folder
from pmmkit import open_campaign, save_campaign
from pmmkit.base import CampaignError
from pmmkit.cli import main
from pmmkit.readers import READERS, Cells, Options, Reader, recognise
from pmmkit.testing import readers as testing
from pmmkit.testing.readers import RULES, check_reader
from scripts.documentation.campaign_file import format_table
from scripts.studies import damage

FORMS = damage.FORMATS.values()
FOAM = {"t": "Time", "X": "Fx", "Y": "Fy", "N": "Mz"}
TITLES = {"openfoam": FOAM, "star-ccm+": {**FOAM, "t": "Physical Time"}}
STATED = {name: damage.truth()[name][:40] for name in ("t", "X", "Y", "N")}


def written(form: damage.Format, folder: Path) -> Path:
    path = folder / (form.damaged or form.file)
    path.parent.mkdir(parents=True, exist_ok=True)
    form.write(path, damage.truth())
    return folder / form.file


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS, ids=[form.name for form in FORMS])
def test_every_reader_keeps_its_word(form, tmp_path):
    path = written(form, tmp_path)
    name = recognise(path)
    title = TITLES.get(name, {})
    stated = {title.get(key, key): numbers for key, numbers in damage.truth().items()}
    check_reader(READERS[name], path, stated)


def test_the_reader_of_saved_campaigns_keeps_its_word(tmp_path):
    damage.good_folder(damage.FORMATS["csv"], tmp_path)
    save_campaign(open_campaign(tmp_path), tmp_path / "all.h5")
    check_reader(READERS["pmmkit"], tmp_path / "all.h5", damage.truth(), run="SD")


def test_no_reader_is_left_out(tmp_path):
    seen = {recognise(written(form, tmp_path / str(place))) for place, form in enumerate(FORMS)}
    assert seen | {"pmmkit", "zip"} == set(READERS)


def test_every_key_of_a_source_is_tried():
    assert set(testing._ODD) == {item.name for item in fields(Options)}
    assert not [key for key, odd in testing._ODD.items() if odd == getattr(Options(), key)]


# A reader of one's own.


def log_of(columns) -> str:
    rows = ["|".join(f"{x:.6f}" for x in row) for row in zip(*columns.values(), strict=True)]
    return "\n".join(["LOG", "|".join(columns), *rows, "END", ""])


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "run.log"
    path.write_text(log_of(STATED), encoding="utf-8", newline="")
    return path


def test_a_reader_of_one_file_keeps_its_word(log):
    check_reader(Log(), log, STATED)
    check_reader(Log(), log)


def used_everywhere(folder: Path, capsys) -> None:
    """A log is recognised, inspected and read in a campaign, its format stated or not."""
    (folder / "campaign").mkdir()
    path = folder / "campaign" / "run.dat"
    path.write_text(log_of(STATED), encoding="utf-8")
    assert recognise(path) == "lab log"
    for source in ("", 'source = { format = "lab log" }'):
        text = f'{damage.CAMPAIGN}file = "run.dat"\n{source}\n'
        (path.parent / "campaign.toml").write_text(text, encoding="utf-8")
        (run,) = open_campaign(path.parent).runs
        assert np.array_equal(run.data["X"].values, STATED["X"])
    assert main(["inspect", str(path)]) == 0
    assert "log of the laboratory" in capsys.readouterr().out


def test_a_reader_is_one_file_in_the_folder(tmp_path, monkeypatch, capsys):
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "lab_log.py").write_text(inspect.getsource(lab_log), encoding="utf-8")
    monkeypatch.setattr(folder, "__path__", [*folder.__path__, str(tmp_path / "more")])
    READERS.reload()
    try:
        assert type(READERS["lab log"]).__module__ == "pmmkit.readers.lab_log"
        used_everywhere(tmp_path, capsys)
    finally:
        READERS.reload()
        sys.modules.pop("pmmkit.readers.lab_log", None)


def test_another_package_brings_a_reader(tmp_path, monkeypatch, capsys):
    about = tmp_path / "site" / "their_lab-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their-lab\nVersion: 1.0\n")
    points = "[pmmkit.readers]\nlog = their_lab:Log\nlost = their_lab_lost:Log\n"
    (about / "entry_points.txt").write_text(points)
    (about.parent / "their_lab.py").write_text(inspect.getsource(lab_log), encoding="utf-8")
    monkeypatch.syspath_prepend(about.parent)
    READERS.reload()
    try:
        with pytest.warns(UserWarning, match="'lost' of their-lab is left out"):
            assert "lab log" in READERS
        used_everywhere(tmp_path, capsys)
    finally:
        READERS.reload()
        sys.modules.pop("their_lab", None)


def test_a_format_that_is_not_there_is_refused_with_those_that_are(tmp_path):
    text = f'{damage.CAMPAIGN}file = "a.csv"\nsource = {{ format = "lab log" }}\n'
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    known = re.escape(f"is not one of {', '.join(READERS)}")
    with pytest.raises(CampaignError, match=f"'lab log' {known}"):
        open_campaign(tmp_path)
    (tmp_path / "campaign.toml").write_text(text.replace('"lab log"', '["csv"]'), encoding="utf-8")
    with pytest.raises(CampaignError, match=known):
        open_campaign(tmp_path)


def test_a_reader_that_cannot_be_made_does_not_stop_the_others():
    class Abstract(Reader):
        name = "abstract"

    class Taken(Log):
        name = "csv"

    with installed(Abstract, Taken, Log), warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert [name for name in READERS if name not in BUILT_IN] == ["lab log"]
    assert len(told) == 2


BUILT_IN = tuple(READERS)


# Wrong ones.


class Lost(Log):
    def columns(self, request, choose):
        raise KeyError("t")


class Renaming(Log):
    def names(self, request):
        return tuple(f"{name} [-]" for name in super().names(request))


class Sorting(Log):
    def columns(self, request, choose):
        wanted = []

        def kept(headers, count):
            wanted.extend(choose(headers, count))
            return sorted(wanted)

        return replace(super().columns(request, kept), positions=tuple(wanted))


class Dropping(Log):
    def cells(self, request):
        found = super().cells(request)
        return replace(found, rows=found.rows[1:], lines=found.lines[1:])


class Doubling(Log):
    def cells(self, request):
        found = super().cells(request)
        return replace(found, rows=tuple((row[1], *row[1:]) for row in found.rows))

    def columns(self, request, choose):
        return Log().columns(request, choose)


class Counting(Log):
    calls = 0

    def columns(self, request, choose):
        self.calls += 1
        found = super().columns(request, choose)
        return replace(found, notes=(f"call {self.calls}",))


class Writing(Log):
    def columns(self, request, choose):
        request.path.with_suffix(".index").write_text("40")
        return super().columns(request, choose)


class Greedy(Log):
    def recognises(self, path, head):
        return b"|" in head or b"," in head


class Failing(Log):
    def recognises(self, path, head):
        return head[0] == ord("L")


class Reading(Log):
    def recognises(self, path, head):
        return path.is_file() and path.read_bytes()[:4] == b"LOG\n"


class Short(Log):
    """Takes what is there."""

    binary = True

    def cells(self, request):
        lines = request.path.read_bytes().decode("ascii", "replace").split("\n")
        if lines[0] != "LOG" or len(lines) < 5:
            raise request.error("it is no log.")
        rows = [tuple(line.split("|")) for line in lines[1:-1] if line != "END"]
        return Cells(headers=rows[0], rows=tuple(rows[1:]), lines=tuple(range(3, len(rows) + 2)))


class Torn(Short):
    """Takes half a number for a number."""

    binary = False

    def cells(self, request):
        lines = request.path.read_bytes().decode("ascii", "replace").split("\n")
        if lines[0] != "LOG" or len(lines) < 5:
            raise request.error("it is no log.")
        rows = [tuple(line.split("|")) for line in lines[1:] if line not in ("END", "", "E", "EN")]
        whole = [row for row in rows if len(row) == len(rows[0]) and row[-1] not in ("", "-")]
        return Cells(headers=whole[0], rows=tuple(whole[1:]), lines=tuple(range(3, len(whole) + 2)))


class Careless(Log):
    def cells(self, request):
        request.path.read_text(encoding="ascii")
        return super().cells(request)


class Inventing(Log):
    def cells(self, request):
        if request.path.exists() and not request.path.read_bytes().startswith(b"LOG\n"):
            names = tuple(STATED)
            return Cells(headers=names, rows=(("0",) * 4,) * 3, lines=(1, 2, 3))
        return super().cells(request)


class Skipping(Log):
    def cells(self, request):
        found = super().cells(request)
        skipped = request.options.skip_rows
        return replace(found, rows=found.rows[skipped:], lines=found.lines[skipped:])


def declared(**said):
    return type("Declared", (Log,), said)


WRONG = [
    (declared(words=" "), "declarations", "words is ' '"),
    (declared(name="tdms"), "declarations", "the name 'tdms' is taken"),
    (declared(suffixes=(".LOG",)), "declarations", "not a dot and small letters"),
    (declared(suffixes=(".log", ".log")), "declarations", "comes twice"),
    (declared(suffixes=(".mat",)), "declarations", "'.mat' is that of 'matlab'"),
    (declared(suffixes=(), container=True), "declarations", "has no suffixes"),
    (declared(fallback="file"), "declarations", "'csv' is read if nothing tells"),
    (declared(keys=("sheets",)), "declarations", "no keys sheets"),
    (Lost, "a good file is read", "KeyError"),
    (Renaming, "names, columns and files agree", "names gives"),
    (Sorting, "columns come in the order asked", "come as others"),
    (Dropping, "nothing is lost", "39 values, 40 are stated"),
    (Doubling, "cells agree with columns", "other numbers in column 't'"),
    (Counting, "the same input gives the same output", "holds something"),
    (Writing, "files are not touched", "others after reading"),
    (Greedy, "other files are not taken for its own", "takes columns of text"),
    (Failing, "other files are not taken for its own", "fails on an empty file: IndexError"),
    (Reading, "recognising does not read the file", "bytes for a file of"),
    (Short, "a file cut short is not read for a shorter one", "rows are lost and nothing is said"),
    (Torn, "a file cut short is not read for a shorter one", "gives other numbers"),
    (Careless, "what is no file of the format is refused", "UnicodeDecodeError"),
    (Inventing, "what is no file of the format is refused", "columns come out of zeros"),
    (Skipping, "keys that count are declared", "skip_rows changes what is read"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("reader", "rule", "fault"), WRONG)
def test_a_reader_that_breaks_its_word_is_caught(reader, rule, fault, log):
    with pytest.raises(AssertionError) as caught:
        check_reader(reader(), log, STATED)
    assert any(
        line.startswith(f"- {rule}: ") and fault in line for line in str(caught.value).split("\n")
    ), str(caught.value)


def test_each_rule_is_broken_by_one():
    assert {rule for _, rule, _ in WRONG} == {*RULES, "declarations", "a good file is read"}


# The documentation.


def test_the_documentation_lists_all_formats():
    page = Path(__file__).parents[2] / "docs" / "formats.md"
    assert format_table() in page.read_text(encoding="utf-8"), "run make_docs.py"


# What is not needed is not imported.


@pytest.mark.slow
def test_a_text_file_needs_no_library_of_another_format(tmp_path):
    damage.good_folder(damage.FORMATS["csv"], tmp_path)
    code = (
        "import sys, pmmkit as pk\n"
        "assert 'numpy' not in sys.modules\n"
        "pk.open_campaign(sys.argv[1]).runs[0].data.load()\n"
        "print([name for name in ('h5py', 'nptdms', 'python_calamine') if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert (done.stdout.strip(), done.stderr) == ("[]", "")
