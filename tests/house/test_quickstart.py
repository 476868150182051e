"""docs/quickstart.md as somebody types it who has the files of a tank, a CFD or a sea trial."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from pmmkit.cli import main
from scripts.datasets.strangers import laboratories

PAGE = (Path(__file__).parents[2] / "docs" / "quickstart.md").read_text(encoding="utf-8")
INTRODUCTION, *SECTIONS = re.split(r"^## ", PAGE, flags=re.M)
FILES = {
    "Towing tank": ("my-tank", laboratories.workbook),
    "CFD": ("my-cases", laboratories.openfoam),
    "Sea trial": ("my-trial", laboratories.sea_trial),
}
STEP = re.compile(r"^```toml file=(\S+)\n(.*?)^```|^    pmmkit ([^\n]*)$", re.S | re.M)
SHOWN = re.compile(r"^    (?!pmmkit )(.*\S.*)$", re.M)


def write(file, lines):
    """Put the lines of a page where their keys stand in a draft, below the table named before."""
    draft = file.read_text(encoding="utf-8").splitlines()
    place = 0
    for line in lines.splitlines():
        start = re.escape(line if line.startswith("[") else f"{line.partition(' = ')[0]} = ")
        places = [k for k, own in enumerate(draft) if re.match(rf"(# )?{start}", own)]
        at = next(k for k in places if k >= place)
        draft[at] = line
        place = at if line.startswith("[") else place
    file.write_text("\n".join(draft) + "\n", encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("section", SECTIONS, ids=lambda text: text.partition("\n")[0])
def test_the_commands_lead_from_the_files_to_a_turn(section, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        "pmmkit.simulation.bands.Bands.SHIPS", 8
    )  # of those drawn: each kept in full
    title = section.partition("\n")[0]
    folder, make = FILES[title]
    make(tmp_path / folder)
    monkeypatch.chdir(tmp_path)
    text = INTRODUCTION + section if title == "Towing tank" else section
    last = ""
    for file, lines, command in STEP.findall(text):
        if file:
            write(tmp_path / file, lines)
        else:
            assert main(shlex.split(command)) == 0, capsys.readouterr().err
            last = command
    assert last.split()[0] in ("simulate", "uncertainty")
    assert list(tmp_path.glob("my-turn*/metrics.json"))
    printed = {line.strip() for line in capsys.readouterr().out.splitlines()}
    shown = [line.strip() for line in SHOWN.findall(text) if "…" not in line]
    assert [line for line in shown if line not in printed] == []
