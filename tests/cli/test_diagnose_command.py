"""Diagnosis from the command line: the contract's JSON, files, words, the model that add writes."""

from __future__ import annotations

import json
import shlex
from itertools import product

import numpy as np
import pytest
import small_campaign
from commands import rows_of
from hidden_effects import hidden_campaign
from pages import answers_in, texts_in
from test_identify_command import write_free_campaign

from pmmkit import open_campaign, save_campaign, without_effect
from pmmkit.cli import main
from pmmkit.models import load_model, save_model
from pmmkit.simulation import simulate
from tests.support.free_tank.campaigns import Setup, write


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Middle programmes with nothing hidden and with two effects, and a model of the ship."""
    place = tmp_path_factory.mktemp("hidden")
    save_campaign(hidden_campaign("middle", {}, seed=3), place / "quiet.h5")
    hidden = {"yaw_sway_coupling": 1.0, "fault_misalignment": 1.0}
    save_campaign(hidden_campaign("middle", hidden, seed=3), place / "hidden.h5")
    ship = load_model("s175-3dof")
    save_model(without_effect(ship, "yaw_sway_coupling"), place / "model.toml")
    return place


def steady_tests(folder):
    """Nine towed runs at three drift and three rudder angles, a row each, and nothing that yaws."""
    folder.mkdir(exist_ok=True)
    rows, scatter = ["drift_deg,rudder_deg,X,Y,N"], np.random.default_rng(9)
    for drift, rudder in product((-6.0, 0.0, 6.0), (-20.0, 0.0, 20.0)):
        beta, delta = np.radians([drift, rudder])
        still = np.zeros(1)
        f = small_campaign.forces(np.cos([beta]), -np.sin([beta]), *([still] * 4))
        pressure = 0.5 * small_campaign.RHO * small_campaign.L**2
        side, turn = -3e-3 * pressure * delta, 1.4e-3 * pressure * small_campaign.L * delta
        measured = [f["X"][0], f["Y"][0] + side, f["N"][0] + turn] + scatter.normal(size=3) * 0.05
        rows.append(",".join(map(str, (drift, rudder, *measured))))
    (folder / "steady.csv").write_text("\n".join([*rows, ""]), encoding="utf-8")
    table = (
        '\n[[tables]]\nid = "DR_{row}"\ntest = "drift_rudder"\nfile = "steady.csv"\nspeed = 1.0\n'
    )
    (folder / "campaign.toml").write_text(small_campaign.HEAD + table, encoding="utf-8")
    return folder


def run(capsys, *arguments):
    status = main([str(item) for item in arguments])
    output = capsys.readouterr()
    return status, output.out, output.err


@pytest.fixture(scope="module")
def diagnosed(folder):
    status = main(
        [
            "diagnose",
            str(folder / "model.toml"),
            str(folder / "hidden.h5"),
            "--out",
            str(folder / "found"),
        ]
    )
    assert status == 0
    return json.loads((folder / "found" / "diagnosis.json").read_text())


def test_without_yaw_tests_what_they_would_show_is_named(tmp_path, capsys):
    asked = ("diagnose", "cubic", steady_tests(tmp_path), "--noise", "0.01", "--out", tmp_path)
    status, words, _ = run(capsys, *asked)
    assert status == 0
    assert "yaw_sway_coupling" in words.partition("These runs could not show")[2]
    assert (tmp_path / "report.html").exists()


@pytest.mark.slow
def test_entries_are_hidden_once_and_known_from_then_on(tmp_path, capsys):
    """Nine steady tests, few of whose entries can be hidden."""
    place = steady_tests(tmp_path / "tests")
    asked = ("diagnose", "cubic", place, "--noise", "0.01", "--no-figures", "--json", "--out")
    status, first, told = run(capsys, *asked, tmp_path / "first", "--outside", "--workers", "1")
    assert status == 0
    assert "hidden: " in told
    (table,) = json.loads((place / "hidden_entries.json").read_text())["tables"]
    assert len(table["ends"]) == 2 * len(table["families"])
    _, second, told = run(capsys, *asked, tmp_path / "second")
    assert "hidden: " not in told
    assert json.loads(first)["outside"] == json.loads(second)["outside"]


@pytest.mark.slow
def test_the_json_holds_what_the_contract_says(diagnosed):
    assert diagnosed["verdict"] == "missing_effect"
    best = diagnosed["group"][0]
    assert set(best["effects"]) == {"yaw_sway_coupling", "fault_misalignment"}
    assert best["odds"] == 1.0
    assert diagnosed["flags"] == []
    for item in diagnosed["findings"]:
        assert {
            "effect",
            "family",
            "channels",
            "coefficients",
            "std",
            "evidence",
            "error_before",
            "error_after",
            "rivals",
            "separating_test",
        } <= set(item)
        assert item["error_after"] < item["error_before"]
        assert set(item["std"]) == set(item["coefficients"])
    for item in diagnosed["not_testable"]:
        assert {"effect", "why", "size_that_could_hide"} == set(item)
    assert "fault_gauge_gain" in {item["effect"] for item in diagnosed["not_testable"]}


@pytest.mark.slow
def test_the_files_of_a_diagnosis(folder, diagnosed):
    names = {file.name for file in (folder / "found").iterdir()}
    written = {"diagnosis.json", "effects.csv", "error_fall.csv", "report.html", "homogeneity.svg"}
    assert names == written
    page = answers_in(folder / "found" / "report.html")
    assert list(page["state"]["places"]) == ["data", "missing"]
    assert page["missing"]["sentence"] in texts_in(page["told missing"]["folded"])


@pytest.mark.slow
def test_the_page_of_a_diagnosis_holds_what_the_command_says(folder, diagnosed):
    page = answers_in(folder / "found" / "report.html")
    named = {item["effect"]: item for item in page["missing"]["candidates"] if item["named"]}
    assert set(named) == {item["effect"] for item in diagnosed["findings"]}
    for item in diagnosed["findings"]:
        told = {own["name"]: own["value"] for own in named[item["effect"]]["coefficients"]}
        assert told == pytest.approx(item["coefficients"], rel=1e-4)
    rows = rows_of(folder / "found" / "error_fall.csv")
    assert [step["step"] for step in page["fall"]["steps"]] == list(
        dict.fromkeys(row["step"] for row in rows)
    )


@pytest.mark.slow
def test_words_say_family_rivals_and_what_could_not_be_shown(folder, capsys):
    _, out, _ = run(
        capsys,
        "diagnose",
        folder / "model.toml",
        folder / "hidden.h5",
        "--no-figures",
        "--out",
        folder / "words",
    )
    assert "Verdict: An effect is missing." in out
    assert "Family: " in out
    assert "These runs could not show\n  - " in out
    assert "pmmkit add" in out
    assert not (folder / "words" / "report.html").exists()


@pytest.mark.slow
def test_nothing_hidden_is_nothing_named(folder, capsys):
    status, out, err = run(
        capsys,
        "diagnose",
        folder / "model.toml",
        folder / "quiet.h5",
        "--json",
        "--no-figures",
        "--out",
        folder / "quiet",
    )
    found = json.loads(out)
    assert (status, found["verdict"], found["group"]) == (0, "noise", [])
    assert "Nothing is missing" in err


@pytest.mark.slow
def test_what_is_known_is_given(folder, capsys):
    _, out, _ = run(
        capsys,
        "diagnose",
        folder / "model.toml",
        folder / "hidden.h5",
        "--json",
        "--no-figures",
        "--given",
        "fault_misalignment",
        "--out",
        folder / "given",
    )
    found = json.loads(out)
    assert found["given"] == ["fault_misalignment"]
    assert found["group"][0]["effects"] == ["yaw_sway_coupling"]


@pytest.mark.slow
def test_what_comes_next_runs_with_what_was_given_and_typed(folder, capsys, monkeypatch):
    """A path with a space, a floor of one's own, an effect that is known: `add` needs them all."""
    monkeypatch.chdir(folder)
    save_campaign(open_campaign("hidden.h5"), "my tests.h5")
    asked = ("diagnose", "model.toml", "my tests.h5", "--no-figures", "--floor", "0.006")
    status, words, _ = run(capsys, *asked, "--given", "fault_misalignment")
    assert status == 0
    (line,) = (x for x in words.splitlines() if x.startswith("Next: pmmkit add "))
    _, *following = shlex.split(line.removeprefix("Next: "))
    assert following[:4] == ["add", "model.toml", "fault_misalignment", "yaw_sway_coupling"]
    assert "--floor 0.006" in line
    assert run(capsys, *following)[0] == 0
    made = load_model(following[-1])
    added = [step.effect for step in made.steps][-2:]
    assert added == ["fault_misalignment", "yaw_sway_coupling"]


@pytest.mark.slow
def test_a_formula_is_added_as_the_last_line_says(tmp_path, capsys, monkeypatch):
    """What no effect explains, v r³ in surge and v |r|³ in sway: the model says what they are."""
    monkeypatch.chdir(tmp_path)
    save_campaign(hidden_campaign("full", {"outside_vr3": 1.0}, seed=7000), tmp_path / "tests.h5")
    save_model(
        without_effect(load_model("s175-3dof"), "yaw_sway_coupling"), tmp_path / "model.toml"
    )
    status, words, _ = run(capsys, "diagnose", "model.toml", "tests.h5", "--no-figures")
    assert status == 0
    assert "These are numbers, no cause." in words
    head = "Next, as numbers without a cause: pmmkit "
    (line,) = (x for x in words.splitlines() if x.startswith(head))
    told = json.loads((tmp_path / "tests-diagnosed" / "diagnosis.json").read_text())
    assert {x["term"] for x in told["formula"]["terms"]} == {"Xvrrr", "Yvrr|r|"}
    assert told["formula"]["error_after"] < told["formula"]["error_level"]
    status, words, _ = run(capsys, *shlex.split(line.removeprefix(head)))
    assert status == 0
    assert "empirical_xvrrr" in words
    made = load_model("model2.toml")
    assert [x.note for x in made.steps[-2:]] == 2 * ["empirical term, no physical cause is named"]
    status, words, _ = run(capsys, "diagnose", "model2.toml", "tests.h5", "--no-figures", "--force")
    assert "Verdict: Nothing is missing" in words
    assert "formula" not in words


def test_effects_that_are_given_one_by_one_are_all_taken(tmp_path, capsys):
    tests = steady_tests(tmp_path)
    two = ("--given", "asymmetry", "--given", "fault_misalignment")
    out = ("--noise", "0.01", "--no-figures", "--json", "--out", tmp_path / "out")
    _, said, _ = run(capsys, "diagnose", "cubic", tests, *two, *out)
    assert json.loads(said)["given"] == ["asymmetry", "fault_misalignment"]


@pytest.mark.slow
def test_add_writes_a_model_and_the_error_falls(folder, capsys):
    target = folder / "better.toml"
    status, out, _ = run(
        capsys,
        "add",
        folder / "model.toml",
        "yaw_sway_coupling",
        "fault_misalignment",
        "--fit",
        folder / "hidden.h5",
        "-o",
        target,
        "--out",
        folder / "added",
        "--json",
    )
    assert status == 0
    content = json.loads(out)
    shares = {
        row["step"]: row["share"]
        for row in content["errors"]
        if row["test"] == "all" and row["channel"] == "N"
    }
    assert shares["fault_misalignment"] < shares["yaw_sway_coupling"] < shares["base"]
    made = load_model(target)
    assert made.values("hull_polynomial")["Nvvr"] == pytest.approx(-0.0424, rel=0.1)
    assert made.history[-1].startswith("Added fault_misalignment")
    assert {"error_fall.csv", "error_fall.svg"} == {f.name for f in (folder / "added").iterdir()}
    assert content["turning"]["after"].keys() == content["turning"]["before"].keys()
    given = load_model(folder / "model.toml")
    speeds = sorted({run.settings.speed for run in open_campaign(folder / "hidden.h5")})
    scale = given.ship.L / open_campaign(folder / "hidden.h5").ship.L
    speed = speeds[len(speeds) // 2] * scale**0.5
    turned = simulate(given, "turning", rudder_deg=35, speed=speed, compiled=False).metrics
    told = content["turning"]["before"]["tactical_diameter_L"]
    assert told == pytest.approx(turned["tactical_diameter_L"], rel=1e-3)

    status, out, _ = run(
        capsys,
        "add",
        target,
        "--undo",
        "--fit",
        folder / "hidden.h5",
        "-o",
        folder / "back.toml",
        "--json",
    )
    assert json.loads(out)["taken_out"] == "fault_misalignment"
    history = load_model(folder / "back.toml").history
    assert [line.split(":")[0] for line in history if line.startswith("Added")] == [
        "Added yaw_sway_coupling"
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (["add", "model.toml", "--fit", "hidden.h5"], 2, "Name an effect"),
        (["add", "model.toml", "memory", "--undo", "--fit", "hidden.h5"], 2, "Name an effect"),
        (["add", "model.toml", "ghost", "--fit", "hidden.h5"], 1, "These do"),
        (["diagnose", "model.toml", "absent.h5"], 1, "absent.h5"),
        (["diagnose", "cubics", "hidden.h5"], 1, "cubics"),
    ],
)
def test_what_cannot_be_done_is_said(folder, arguments, status, said, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    found, _, err = run(capsys, *arguments)
    assert found == status
    assert said in err
    assert not (folder / "model-extended.toml").exists()


# Free-running records


@pytest.mark.slow
def test_records_of_a_ship_that_is_the_model_name_nothing(tmp_path, capsys):
    place = write_free_campaign(tmp_path / "zigzags")
    status, out, err = run(
        capsys,
        "diagnose",
        "kvlcc2-l7",
        place,
        "--runs",
        "ZZ1*",
        "--test-runs",
        "ZZ35",
        "--spread",
        "0.02",
        "--window",
        "40",
        "--candidates",
        "asymmetry,rudder_stall,yaw_sway_coupling,fault_rudder_zero",
        "--json",
        "--out",
        tmp_path / "found",
    )
    assert status == 0
    found = json.loads(out)
    assert found["group"] == []
    assert found["held_out"]["runs"] == ["ZZ35"]
    assert {"held out, model as given", "held out, base refitted"} <= set(found["errors"])
    assert "Root mean square errors" in err
    names = {file.name for file in (tmp_path / "found").iterdir()}
    assert {"diagnosis.json", "effects.csv", "evidence.svg", "model_refitted.toml"} <= names


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--noise", "0.01"], "captive tests"),
        (["--given", "memory"], "captive tests"),
        (["--outside"], "captive tests"),
        (["--windage", "0.1"], "two areas"),
    ],
)
def test_options_of_the_other_kind_of_tests_are_refused(options, said, tmp_path, capsys):
    place = write_free_campaign(tmp_path / "zigzags")
    status, _, err = run(capsys, "diagnose", "kvlcc2-l7", place, *options)
    assert status in (1, 2)
    assert said in err


@pytest.mark.slow
def test_captive_tests_know_no_windows(folder, capsys):
    status, _, err = run(capsys, "diagnose", "cubic", folder / "quiet.h5", "--runs", "PS*")
    assert status == 1
    assert "free-running" in err


def test_a_structure_cannot_sail(tmp_path, capsys):
    place = write_free_campaign(tmp_path / "zigzags")
    status, _, err = run(capsys, "diagnose", "cubic", place)
    assert status == 1
    assert "cubic" in err


@pytest.mark.slow
def test_an_effect_is_fitted_to_records_and_taken_out_again(tmp_path, capsys):
    place = write_free_campaign(tmp_path / "zigzags")
    target = tmp_path / "model2.toml"
    out = tmp_path / "added"
    order = ("add", "kvlcc2-l7", "asymmetry", "--fit", place, "-o", target, "--out", out)
    status, said, err = run(capsys, *order, "--why", "by hand", "--json")
    assert status == 0, err
    content = json.loads(said)
    assert [row["step"] for row in content["errors"]] == ["base", "asymmetry"]
    assert {"position", "heading", "speed", "yaw_rate"} < content["errors"][0].keys()
    assert {"error_fall.csv", "error_fall.svg"} == {file.name for file in out.iterdir()}
    made = load_model(target)
    assert made.steps[-1].effect == "asymmetry"
    assert "(by hand)" in made.history[-1]
    assert {"Y0", "N0"} <= made.values("hull_polynomial").keys()
    assert "turning" in content

    order = ("add", target, "--undo", "--fit", place, "-o", tmp_path / "back.toml", "--json")
    status, said, _ = run(capsys, *order)
    assert status == 0
    assert json.loads(said)["taken_out"] == "asymmetry"
    back = load_model(tmp_path / "back.toml")
    assert "Y0" not in back.values("hull_polynomial")
    assert all(step.effect != "asymmetry" for step in back.steps)


@pytest.mark.slow
def test_several_campaigns_vote_together(folder, capsys, tmp_path, monkeypatch):
    other = hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=8)
    save_campaign(other, folder / "other.h5")
    out = folder / "together"
    status, said, _ = run(
        capsys, "diagnose", folder / "model.toml", folder / "hidden.h5", folder / "other.h5",
        "--test-runs", "YD_2.0*", "--workers", "1", "--out", out,
    )  # fmt: skip
    assert status == 0
    assert "Together missing effect by 2 campaigns: yaw_sway_coupling" in said
    content = json.loads((out / "diagnosis.json").read_text())
    assert content["group"][0] == {"effects": ["yaw_sway_coupling"], "odds": 1.0}
    assert [item["owner"] for item in content["belongs"]] == ["the ship's"]
    assert {file.name for file in out.iterdir()} == {
        "diagnosis.json",
        "effects.csv",
        "evidence.svg",
        "model.toml",
    }
    head, *rows = (out / "effects.csv").read_text().splitlines()
    first, second = content["campaigns"]
    assert head.startswith("effect,family,")
    assert first in head
    assert second in head
    assert rows[0].startswith("yaw_sway_coupling,")
    assert "Yvvr" in load_model(out / "model.toml").parts["hull_polynomial"].values
    for rows in content["errors"].values():
        before, after = rows.values()
        assert after["force"] < 0.5 * before["force"]
    assert content["proposed"] == ["yaw_sway_coupling"]
    (line,) = [x for x in said.splitlines() if x.startswith("Next: pmmkit add")]
    monkeypatch.chdir(tmp_path)
    status, said, _ = run(capsys, *shlex.split(line)[2:])
    assert status == 0
    assert "fault_misalignment (hidden effects, middle)" in said


def test_what_one_campaign_alone_can_take_is_refused_for_several(folder, capsys):
    status, _, error = run(
        capsys, "diagnose", folder / "model.toml", *2 * [folder / "quiet.h5"], "--outside"
    )
    assert status != 0
    assert "belongs to the diagnosis of one campaign" in error


def test_a_structure_cannot_be_asked_by_several_campaigns(folder, capsys):
    status, _, error = run(capsys, "diagnose", "cubic", *2 * [folder / "quiet.h5"])
    assert status != 0
    assert "Give a model file" in error


@pytest.mark.slow
def test_an_effect_is_fitted_to_several_campaigns(folder, tmp_path, capsys):
    """Both are called the same: the second has a number. The fault is that of the first."""
    both = ("--fit", folder / "hidden.h5", "--fit", folder / "quiet.h5")
    asked = ("add", folder / "model.toml", "yaw_sway_coupling")
    fault = "fault_misalignment"
    status, _, err = run(capsys, *asked, fault, *both, "-o", tmp_path / "m.toml")
    assert status == 1
    assert "say of which (hidden effects, middle, hidden effects, middle (2))" in err
    status, out, _ = run(
        capsys, *asked, f"{fault}@hidden effects, middle", *both,
        "-o", tmp_path / "m.toml", "--out", tmp_path / "added", "--no-figures", "--json",
    )  # fmt: skip
    assert status == 0
    found = json.loads(out)
    steps = {(x["campaign"], x["step"]) for x in found["errors"]}
    assert ("hidden effects, middle", fault) in steps
    assert ("hidden effects, middle (2)", fault) not in steps
    made = load_model(tmp_path / "m.toml").parts["hull_polynomial"].values
    assert made["Nvvr"] == pytest.approx(
        load_model("s175-3dof").parts["hull_polynomial"].values["Nvvr"], rel=0.1
    )


@pytest.mark.slow
def test_two_seas_are_asked_together(tmp_path, capsys):
    """Two programmes of a tanker with a coupling that the library's has not, in a tank that shares
    no code with the package; their turns are held out."""
    seas = [
        write(Setup(case="coupling", runs=3, seed=seed, ship="kvlcc2-l7"), tmp_path / str(seed))
        for seed in (1, 2)
    ]
    status, said, _ = run(
        capsys, "diagnose", "kvlcc2-l7", *seas, "--candidates", "yaw_sway_coupling,asymmetry",
        "--test-runs", "turning_*", "--workers", "1", "--no-figures", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 0
    content = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert content["proposed"] == ["yaw_sway_coupling"]
    (belongs,) = content["belongs"]
    assert belongs["owner"] == "the ship's"
    truth = {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156}
    another = belongs["another_laboratory"][0]
    for name, value, std in zip(
        belongs["coefficients"], another["values"], another["std"], strict=True
    ):
        assert abs(value - truth[name]) < 2.5 * std
    for rows in content["errors"].values():
        given, other = (rows[f"held out, {x}"] for x in ("model as given", "another laboratory"))
        assert other["heading"] < 0.02 * given["heading"]
        assert other["position"] < 0.03 * given["position"]
    for row in content["turn"].values():
        assert row["low"] < row["ship_low"] < row["mean"] < row["ship_high"]
    assert "Next: pmmkit add kvlcc2-l7 yaw_sway_coupling" in said
    assert f"--fit {seas[0]} --fit {seas[1]}" in said
