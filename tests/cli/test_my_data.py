"""`pmmkit demo --my-data`: as far as a stranger's files go, and what is missing."""

from __future__ import annotations

import hashlib
import shutil

import pytest

from pmmkit.cli import main
from scripts.datasets.strangers import laboratories
from scripts.datasets.strangers.hulls import TANKER, turn
from scripts.studies.strangers import filled, particulars
from tests.support.commands import said


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Folders of strangers, which nobody may write to."""
    place = tmp_path_factory.mktemp("strangers")
    laboratories.workbook(place / "workbook")
    laboratories.sea_trial(place / "trial")
    return place


@pytest.fixture
def desk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def prints(folder):
    """Every file with its content."""
    return {
        path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }


def answer(file, *more):
    """The ship as a person fills it in."""
    text = filled(file.read_text(encoding="utf-8"), [*particulars(TANKER), *more])
    file.write_text(text, encoding="utf-8")


def confirm(file):
    """What is right loses its mark."""
    text = file.read_text(encoding="utf-8").replace("TODO", "yes,")
    file.write_text(text, encoding="utf-8")


@pytest.mark.slow
def test_without_particulars_it_stops_with_the_lines_that_open_the_way(files, desk, capsys):
    before = prints(files)
    status, told, words = said(capsys, "demo", "--my-data", files / "workbook")
    assert status == 0
    assert prints(files) == before
    assert told["campaign"] == "workbook-first/campaign.toml"
    assert told["result"] is None
    assert "L, B, d, Izz, mass or volume are missing" in told["stopped"]
    lines = (desk / "workbook-first" / "campaign.toml").read_text(encoding="utf-8").splitlines()
    needed = {it["key"]: it["lines"][0] for it in told["questions"] if it["kind"] == "needed"}
    assert set(needed) == {"ship.L", "ship.B", "ship.d", "ship.mass", "ship.Izz"}
    assert lines[needed["ship.L"] - 1].startswith("# L = ...")
    assert f"line {needed['ship.L']}, ship.L: length" in words
    assert words.rstrip().endswith("Next: pmmkit demo --my-data workbook-first")


@pytest.mark.slow
def test_with_particulars_it_turns_and_says_what_is_only_guessed(files, desk, capsys):
    said(capsys, "demo", "--my-data", files / "workbook" / "tests.xlsx", "--out", "first")
    answer(desk / "first" / "campaign.toml")
    status, told, words = said(capsys, "demo", "--my-data", "first")
    assert (status, told["stopped"], told["provisional"]) == (0, "", True)
    assert [stage["name"] for stage in told["stages"]] == [
        "read", "check", "reduce", "model", "turn",
    ]  # fmt: skip
    assert "PROVISIONAL: computed with 1 guess below." in words
    report = (desk / "first-reduced" / "report.html").read_text(encoding="utf-8")
    assert "1 guess not confirmed" in report
    kinds = {item["key"]: item["kind"] for item in told["questions"]}
    assert kinds["water.rho"] == "guessed"
    assert "campaign.forces" not in kinds  # the runs show that no inertia is inside
    assert "campaign.rudder_positive" not in kinds  # there is no rudder
    assert kinds["propeller.D"] == kinds["rudder.area"] == "estimated"
    (circle,) = told["result"]["turns"]
    low, high = told["tactical_diameter_L"]
    assert low < turn(TANKER, laboratories.SLOW).tactical_diameter < high
    assert low < circle["tactical_diameter_L"] < high
    assert told["next"] == "pmmkit compare first-reduced/model.toml first"
    assert words.rstrip().endswith("Once the guesses are confirmed: pmmkit demo --my-data first")
    confirm(desk / "first" / "campaign.toml")
    status, told, words = said(capsys, "demo", "--my-data", "first")
    assert (status, told["provisional"]) == (0, False)
    assert told["next"] == "pmmkit compare first-reduced-2/model.toml first"
    assert "PROVISIONAL" not in words
    assert "Once the guesses" not in words


@pytest.mark.slow
def test_what_the_data_contradict_stops_it_before_anything_is_computed(files, desk, capsys):
    said(capsys, "demo", "--my-data", files / "workbook")
    wrong = ('forces = "hydrodynamic"', 'forces = "balance"')
    answer(desk / "workbook-first" / "campaign.toml", wrong)
    status, told, _ = said(capsys, "demo", "--my-data", "workbook-first")
    assert status == 1
    assert "already removed" in told["stopped"]
    assert told["result"] is None
    assert not list(desk.glob("*reduced*"))


@pytest.mark.slow
def test_free_running_records_are_measured_and_lead_to_a_model(files, desk, capsys):
    said(capsys, "demo", "--my-data", files / "trial")
    answer(desk / "trial-first" / "campaign.toml")
    status, told, _ = said(capsys, "demo", "--my-data", "trial-first")
    assert status == 0
    runs = {item["run"]: item for item in told["result"]["runs"]}
    assert len(runs) == 3
    confirm(desk / "trial-first" / "campaign.toml")
    told = said(capsys, "demo", "--my-data", "trial-first")[1]
    assert told["next"] == "pmmkit card form"  # a ship of no library becomes a model by her card


@pytest.mark.slow
def test_a_comparison_comes_next_only_where_the_revolutions_are_named(files, desk, capsys):
    shutil.copytree(files / "trial", desk / "trial")
    for file in (desk / "trial").iterdir():
        file.write_text(file.read_text().replace("Revolutions [rpm]", "Gauge"))
    status, told, words = said(capsys, "demo", "--my-data", "trial", "--ship", "kvlcc2-l7")
    (asked,) = [x for x in told["questions"] if x["key"] == "columns.n"]
    assert (status, len(told["result"]["runs"]), asked["kind"]) == (0, 3, "needed")
    assert "stop  1 answer below must be given first" in words
    assert told["next"] == "pmmkit demo --my-data trial-first"
    file = desk / "trial-first" / "campaign.toml"
    lines = file.read_text().splitlines()
    lines[asked["lines"][0] - 1] = 'n = { name = "Gauge", unit = "rpm" }'
    file.write_text("\n".join(lines))
    told = said(capsys, "demo", "--my-data", "trial-first")[1]
    assert told["next"] == "pmmkit compare kvlcc2-l7 trial-first"
    assert main(told["next"].split()[1:]) == 0


def test_a_draft_that_is_there_is_never_replaced(files, desk, capsys):
    status, _, words = said(capsys, "demo", "--my-data", files / "trial", "--out", "mine")
    assert status == 0
    before = prints(desk)
    status, _, words = said(capsys, "demo", "--my-data", files / "trial", "--out", "mine")
    assert status == 1
    assert "To go on with it: pmmkit demo --my-data mine" in words
    assert prints(desk) == before


def test_a_campaign_file_that_is_there_is_taken_and_stays(files, desk, capsys):
    shutil.copytree(files / "trial", desk / "own")
    (desk / "own" / "campaign.toml").write_text("[campaign]\ntitle = 'mine'\n", encoding="utf-8")
    before = prints(desk)
    status, told, _ = said(capsys, "demo", "--my-data", "own")
    assert status == 0
    assert told["stages"][0]["words"].startswith("own/campaign.toml is there")
    assert "cannot be used" in told["stopped"]
    assert prints(desk) == before


@pytest.mark.parametrize("name", ["empty", "nowhere"])
def test_a_folder_with_nothing_to_read_is_refused(name, desk, capsys):
    (desk / "empty").mkdir()
    (desk / "empty" / "notes.md").write_text("no numbers", encoding="utf-8")
    assert main(["demo", "--my-data", name]) == 1
    assert name in capsys.readouterr().err
    assert not list(desk.glob("*-first"))


def test_a_ship_alone_is_a_mistake(capsys):
    assert main(["demo", "--ship", "kvlcc2"]) == 2
    assert "--my-data" in capsys.readouterr().err
