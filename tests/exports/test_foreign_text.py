"""Names, titles and notes out of files stay comments, strings and cells in every language."""

from __future__ import annotations

import ast
import csv
import io
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from html.parser import HTMLParser

import openpyxl
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.exports.matlab.hull import table_to_mss
from pmmkit.exports.matlab.model import model_to_mss
from pmmkit.exports.shipmmg import model_to_shipmmg
from pmmkit.files import toml_string, write_results
from pmmkit.models import Part, Step, from_values
from pmmkit.models.tables.io import to_latex
from pmmkit.presentation import Section, printable, safe_cell, text_of_cell
from pmmkit.syntax import comment, plain

CANARY = "open('canary', 'w')"
BREAKS = ["\n", "\r", "\r\n", "\x0b", "\x0c", "\x1c", "\x1d", "\x1e", "\x85", "\u2028", "\u2029"]
NASTY = [
    f"coding: unicode_escape \\n{CANARY}#",
    f"{'a' * 60} coding: unicode_escape {'b' * 60} \\n{CANARY}#",
    f"coding=unicode-escape \\x0a{CANARY}#",
    f"vim: set fileencoding=raw_unicode_escape : \\u000a{CANARY}#",
    f"-*- coding: utf-7 -*- +AAo-{CANARY}#",
    f"CODING: utf-7 +AAo-{CANARY}",
    f"coding: rot13 {CANARY}",
    *(f"a{sign}{CANARY}{sign}system('touch canary')" for sign in BREAKS),
    f"'; {CANARY}; '",
    f'"""\n{CANARY}\n"""',
    f"'''\n{CANARY}\n'''",
    f"\\\n{CANARY}",
    f"\\' + {CANARY} + \\'",
    "ends with a backslash \\",
    "%{\nsystem('touch canary')\n%}",
    "x ...\nsystem('touch canary')",
    "'); system('touch canary'); disp('",
    "\x00\x1b[2J\x7f\ud800",
    "end; quit(3)",
]
SHIP = pk.load_model("s175-3dof").ship


def named(text: str) -> pk.Model:
    """A model that carries a text wherever it can."""
    known = pk.load_model("kvlcc2-l7")
    parts = {
        name: Part(effect=name, values=part.values, options=part.options, source=text)
        for name, part in known.parts.items()
    }
    return known.with_(
        name=text,
        title=text,
        scale=text,
        notes=(text, text),
        steps=(Step(action="noted", note=text),),
        ship=replace(known.ship, name=text),
        parts=parts,
    )


def uncommented(text: str, sign: str) -> list[str]:
    """Lines of code without comments; in these files the sign stands in no string."""
    return [line for row in text.splitlines() if (line := row.split(sign)[0].rstrip())]


@pytest.mark.parametrize("text", NASTY)
def test_what_is_computed_does_not_depend_on_names(text):
    known = pk.load_model("kvlcc2-l7")
    assert uncommented(model_to_shipmmg(named(text), speed=1.2), "#") == uncommented(
        model_to_shipmmg(known, speed=1.2), "#"
    )
    ours, plainly = model_to_mss(named(text)), model_to_mss(known)
    assert uncommented(ours, "%")[1:] == uncommented(plainly, "%")[1:]
    assert re.fullmatch(r"function \[xdot,U\] = [A-Za-z]\w*\(x,ui\)", ours.splitlines()[0])


def test_a_python_file_is_nothing_but_imports_and_values():
    allowed = (ast.ImportFrom, ast.Assign)
    for text in NASTY:
        written = model_to_shipmmg(named(text), speed=1.2)
        tree = ast.parse(written.encode("ascii"))
        assert all(isinstance(node, allowed) for node in tree.body), text
        calls = {ast.unparse(x.func) for x in ast.walk(tree) if isinstance(x, ast.Call)}
        assert calls == {"Mmg3DofBasicParams", "Mmg3DofManeuveringParams", "KTParams"}


def test_running_the_python_files_leaves_no_trace(tmp_path):
    """Python's own decoder and parser decide, one process for all of them."""
    package = tmp_path / "shipmmg"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "kt.py").write_text("KTParams = dict\n")
    names = "Mmg3DofBasicParams = Mmg3DofManeuveringParams = dict\n"
    (package / "mmg_3dof.py").write_text(names)
    for number, text in enumerate(NASTY):
        pk.export(named(text), tmp_path / f"ship_{number}.py", speed=1.2)
    (tmp_path / "all.py").write_text(
        "import glob, runpy\n"
        "done = [runpy.run_path(name) for name in sorted(glob.glob('ship_*.py'))]\n"
        "assert all(item['basic_params']['L_pp'] == 7.0 for item in done)\n"
    )
    subprocess.run([sys.executable, "all.py"], cwd=tmp_path, check=True)
    assert not (tmp_path / "canary").exists()


@pytest.mark.parametrize("text", NASTY)
def test_comments_give_no_orders_to_python_and_editors(text):
    for line in comment(text, "#"):
        assert not re.match(r"^[ \t\f]*#.*?coding[:=]", line, re.IGNORECASE)
        assert not re.search(r"\b(vim?|ex)[:=]", line)
        assert line.startswith("# ")
        assert line.isascii()
        assert line.isprintable()


@pytest.mark.parametrize("text", NASTY)
def test_a_structure_for_matlab_holds_the_text_in_one_string(text):
    table = from_values(
        {"Yv": -0.01}, ship=replace(SHIP, name=text), water=pk.Water(), notes=(text,)
    )
    written = table_to_mss(table)
    (line,) = [row for row in written.splitlines() if row.startswith("table.ship.name")]
    assert re.fullmatch(r"table\.ship\.name = '(?:[^']|'')*';", line)
    assert all(
        re.match(r"(%|table\.\S+ = |function table = \w+\(\)$|end$|$)", row)
        for row in written.splitlines()
    )


def test_latex_holds_names_of_derivatives_and_numbers_only():
    evil = r"\input{/etc/passwd}\write18{touch canary}"
    table = from_values(
        {"Yv": -0.01}, ship=replace(SHIP, name=evil), water=pk.Water(), notes=(evil,)
    )
    assert "input" not in to_latex(table)
    with pytest.raises(pk.PmmkitError):
        from_values({evil: 1.0}, ship=SHIP, water=pk.Water())


FORMULAS = [
    "=1+1",
    "+1+cmd|' /C calc'!A0",
    "-2+3",
    "@SUM(1)",
    "\t=1",
    "\r=1",
    "  =1",
    "'=1",
    "a;=1",
    "a\n=1",
    "＝1",
]


@pytest.mark.parametrize("text", FORMULAS)
def test_no_cell_is_a_formula_and_every_text_comes_back(text):
    written = safe_cell(text)
    assert written.startswith("'") or written[2] == "'"
    for part in re.split(r"[;\t\r\n]", written):
        assert not re.match(r" *[=+\-@＝]", part)
    assert text_of_cell(written) == text


@given(text=st.text(alphabet=st.sampled_from("'=+-@;\t\r\n a1.e"), max_size=12))
def test_cells_come_back_whatever_the_text(text):
    assert text_of_cell(safe_cell(text)) == text


@pytest.mark.parametrize("number", ["-4", "+4.5", "-1e-3", ".5", "0"])
def test_numbers_stay_numbers(number):
    assert safe_cell(number) == number


def test_tables_of_results_hold_no_formulas(tmp_path):
    frame = pd.DataFrame({"run": ["=1+1", "SD", None], "=x": [-1.5, 2.0, 3.0]})
    write_results(tmp_path / "out", [("runs.csv", frame)])
    rows = list(csv.reader(io.StringIO((tmp_path / "out" / "runs.csv").read_text())))
    assert rows == [["run", "'=x"], ["'=1+1", "-1.5"], ["SD", "2.0"], ["", "3.0"]]
    assert list(frame["run"][:2]) == ["=1+1", "SD"]


@pytest.mark.parametrize("ending", ["csv", "xlsx"])
def test_a_table_whose_method_looks_like_a_formula(ending, tmp_path):
    table = from_values({"Yv": -0.01}, ship=SHIP, water=pk.Water())
    table = table.with_(method=table.method.astype("<U20"))
    table.method[...] = '=HYPERLINK("x")'
    table = table.with_(method=table.method)
    file, *_ = pk.export(table, tmp_path / f"table.{ending}")
    assert pk.read_table(file).method[0, 0] == '=HYPERLINK("x")'
    if ending == "csv":
        assert ",'=HYPERLINK" in file.read_text(encoding="utf-8").replace('"', "")
    else:
        book = openpyxl.load_workbook(file)
        assert {cell.data_type for row in book["derivatives"] for cell in row} <= {"s", "n"}


def test_a_run_named_like_a_formula_is_exported_as_text(tmp_path):
    folder = write_campaign(tmp_path / "small")
    campaign = pk.open_campaign(folder)
    first = replace(campaign.runs[0], id="=cmd|' /C calc'!A0")
    pk.export(campaign.with_(runs=(first,), excluded=()), tmp_path / "out")
    assert pk.open_campaign(tmp_path / "out").runs[0].id == first.id
    for file in (tmp_path / "out").glob("*.csv"):
        for row in csv.reader(io.StringIO(file.read_text(encoding="utf-8"))):
            assert not [item for item in row if re.match("[=@]", item)]


@pytest.mark.parametrize("text", [*NASTY, '"]\n[evil]\na = "'])
def test_toml_strings_and_comments_cannot_end(text):
    content = tomllib.loads(f"a = {toml_string(text)}  # {printable(text)}\n")
    assert set(content) == {"a"}
    assert content["a"] == text.replace("\ud800", "?")


class _Elements(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: set[str] = set()

    def handle_starttag(self, tag, attrs):
        self.seen |= {tag, *(name for name, _ in attrs)}


@pytest.mark.parametrize(
    "text", ["<script>alert(1)</script>", "--><img src=x onerror=alert(1)>", "' onload='x"]
)
def test_a_notebook_shows_names_as_text(text):
    parser = _Elements()
    parser.feed(Section(title=text, paragraphs=[text], points=[text]).html())
    assert parser.seen == {"h3", "p", "ul", "li"}


@given(text=st.text(max_size=80))
def test_plain_text_is_one_line_of_ascii(text):
    line = plain(text)
    assert line.isascii()
    assert line.isprintable() or not line
    assert plain(line) == line


@pytest.mark.parametrize(
    "metrics",
    ["[" * 100_000 + "]" * 100_000, '{"": 2, "d/e": 3, "f\\u0000": "x", "g": "\\ud800", "h": 4.5}'],
    ids=["nested without end", "names that no file keeps"],
)
def test_metrics_beside_a_track_that_are_made_to_do_harm(metrics, tmp_path):
    rows = "".join(f"{i},{i},0,0\n" for i in range(4))
    (tmp_path / "track.csv").write_text(f"t [s],x [m],y [m],psi [rad]\n{rows}", encoding="utf-8")
    (tmp_path / "metrics.json").write_text(metrics, encoding="utf-8")
    if metrics.startswith("["):
        with pytest.raises(pk.PmmkitError, match=r"metrics\.json.*cannot be read"):
            pk.export(tmp_path / "track.csv", tmp_path / "track.nc")
        return
    with xr.open_dataset(pk.export(tmp_path / "track.csv", tmp_path / "t.nc")[0]) as found:
        assert found.attrs["h"] == 4.5
        assert "d/e" not in found.attrs


def test_a_run_whose_name_is_no_text_is_refused(tmp_path):
    campaign = pk.open_campaign(write_campaign(tmp_path / "small"))
    named = campaign.with_(runs=(replace(campaign.runs[0], id="\ud800"),), excluded=())
    with pytest.raises(pk.PmmkitError, match="no text in UTF-8"):
        pk.export(named, tmp_path / "out")
