"""``constant/dynamicMeshDict`` of both branches of OpenFOAM: read as text, never executed."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest

from pmmkit.base import CampaignError
from pmmkit.campaigns import read_columns
from pmmkit.cli import main
from pmmkit.readers import Request
from pmmkit.readers.openfoam.mesh_motion import mesh_motion

SWAY_V2306 = """
FoamFile { version 2.0; format ascii; class dictionary; object dynamicMeshDict; }
dynamicFvMesh       dynamicMotionSolverFvMesh;
motionSolverLibs    (fvMotionSolvers);
motionSolver        solidBody;
solidBodyMotionFunction oscillatingLinearMotion;
oscillatingLinearMotionCoeffs
{
    amplitude       (0 0.25 0);   // m
    omega           0.6981317;
}
"""
YAW_V10 = """
mover
{
    type            motionSolver;
    libs            ("libfvMeshMovers.so" "libfvMotionSolvers.so");
    motionSolver    solidBody;
    solidBodyMotionFunction oscillatingRotatingMotion;
    origin          (0 0 0);
    amplitude       (0 0 8.275);
    omega           $rate;
}
rate 0.6981317;
"""
OLD = """
dynamicFvMesh solidBodyMotionFvMesh;
solidBodyMotionFvMeshCoeffs
{
    solidBodyMotionFunction multiMotion;
    multiMotionCoeffs
    {
        tow { solidBodyMotionFunction linearMotion; linearMotionCoeffs { velocity (1.2 0 0); } }
        sway
        {
            solidBodyMotionFunction oscillatingLinearMotion;
            oscillatingLinearMotionCoeffs { amplitude (0 0.4 0); omega 0.5; }
        }
        yaw
        {
            solidBodyMotionFunction oscillatingRotatingMotion;
            oscillatingRotatingMotionCoeffs { origin (0 0 0); amplitude (0 0 6); omega 0.5; }
        }
    }
}
"""


def case(folder, text, **others):
    for name, content in {"constant/dynamicMeshDict": text, **others}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content)
    return folder


def amplitude(values):
    return np.ptp(values) / 2


def test_sway_of_v2306(tmp_path):
    found = mesh_motion(case(tmp_path, SWAY_V2306))
    assert found.moves
    assert not found.notes
    t, y = found.path["t"], found.path["y"]
    np.testing.assert_allclose(y, 0.25 * np.sin(0.6981317 * t))
    assert t[-1] == pytest.approx(4 * 2 * math.pi / 0.6981317)
    assert not found.path["psi"].any()
    assert not found.path["x"].any()


def test_yaw_of_v10_in_degrees_with_a_name_for_a_number(tmp_path):
    found = mesh_motion(case(tmp_path, YAW_V10))
    assert not found.notes
    expected = math.radians(8.275) * np.sin(0.6981317 * found.path["t"])
    np.testing.assert_allclose(found.path["psi"], expected)


def test_several_motions_together(tmp_path):
    found = mesh_motion(case(tmp_path, OLD))
    assert amplitude(found.path["y"]) == pytest.approx(0.4)
    assert amplitude(found.path["psi"]) == pytest.approx(math.radians(6))
    np.testing.assert_allclose(found.path["x"], 1.2 * found.path["t"])


def test_a_table_of_six_degrees_of_freedom(tmp_path):
    t = np.linspace(0, 40, 401)
    place = [f"({1.2 * a:.6f} {0.3 * math.sin(0.5 * a):.6f} 0)" for a in t]
    turned = [f"(0 0 {5 * math.cos(0.5 * a):.6f})" for a in t]
    rows = "\n".join(f"({a:.4f} ({p} {q}))" for a, p, q in zip(t, place, turned, strict=True))
    text = (
        "dynamicFvMesh dynamicMotionSolverFvMesh; motionSolver solidBody;\n"
        "solidBodyMotionFunction tabulated6DoFMotion;\n"
        "tabulated6DoFMotionCoeffs { CofG (0 0 0); "
        'timeDataFileName "$FOAM_CASE/constant/6DoF.dat"; }\n'
    )
    table = f"// t translation rotation\n{len(t)}\n(\n{rows}\n)\n"
    found = mesh_motion(case(tmp_path, text, **{"constant/6DoF.dat": table}))
    assert not found.notes
    np.testing.assert_allclose(found.path["y"], 0.3 * np.sin(0.5 * t), atol=1e-6)
    np.testing.assert_allclose(np.degrees(found.path["psi"]), 5 * np.cos(0.5 * t), atol=1e-5)


def test_files_of_the_case_are_included_and_no_others(tmp_path):
    (tmp_path / "secret").write_text("amplitude (0 9 0); omega 9;")
    inside = SWAY_V2306.replace("    omega           0.6981317;", '    #include "rates"')
    folder = case(tmp_path / "a", inside, **{"constant/rates": "omega 0.5;"})
    assert amplitude(mesh_motion(folder).path["y"]) == pytest.approx(0.25)
    outside = inside.replace('"rates"', '"../../secret"')
    found = mesh_motion(case(tmp_path / "b", outside))
    assert found.moves
    assert not found.path
    assert any("../../secret is not followed" in note for note in found.notes)


@pytest.mark.parametrize(
    "omega",
    [
        'omega #calc "2*3.14/9";',
        'omega #codeStream { code #{ system("touch ran"); #}; };',
        "omega $::elsewhere;",
        'omega { type table; file "x"; }',
        "phaseShift 0.3; omega 0.5;",
        "",
    ],
)
def test_what_is_computed_is_named_and_not_executed(tmp_path, omega):
    text = SWAY_V2306.replace("omega           0.6981317;", omega)
    found = mesh_motion(case(tmp_path, text))
    assert found.moves
    assert not found.path
    assert any("oscillatingLinearMotion" in note for note in found.notes)
    assert not list(tmp_path.rglob("ran"))


def test_a_loop_of_includes_ends(tmp_path):
    text = SWAY_V2306 + '\n#include "dynamicMeshDict"\n'
    assert mesh_motion(case(tmp_path, text)).notes


def test_no_dictionary_and_a_mesh_that_stands_still(tmp_path):
    assert mesh_motion(tmp_path) is None
    assert not mesh_motion(case(tmp_path, "dynamicFvMesh staticFvMesh;")).moves


@pytest.mark.parametrize("text", ["{{{{", "solidBodyMotionFunction", "}" * 50, "\0" * 99, "(" * 99])
def test_rubbish_says_nothing(tmp_path, text):
    found = mesh_motion(case(tmp_path, text))
    assert found is None or not found.path


def test_the_draft_takes_kind_period_and_amplitude_from_it(tmp_path, capsys):
    """Cases named by number: sway, a yaw whose numbers are computed, and a mesh that stands."""
    t = np.arange(0.05, 30, 0.05)
    rows = "\n".join(
        f"{a:g} ((-9 {math.sin(0.698 * a):.6f} 0) (-1 0 0)) ((0 0 1) (0 0 0))" for a in t
    )
    forces = "# Time       \tforces(pressure viscous) moment(pressure viscous)\n" + rows + "\n"
    for name, text in {
        "case1": SWAY_V2306,
        "case2": YAW_V10.replace("$rate", '#calc "6.28/9"'),
        "case3": "dynamicFvMesh staticFvMesh;",
    }.items():
        case(tmp_path / name, text, **{"postProcessing/forces/0/forces.dat": forces})
    assert main(["new-campaign", str(tmp_path)]) == 0
    capsys.readouterr()
    text = (tmp_path / "campaign.toml").read_text()
    runs = {run["id"]: run for run in tomllib.loads(text)["runs"]}
    assert runs["case1"]["test"] == "pure_sway"
    assert runs["case1"]["period"] == pytest.approx(9.0, abs=1e-4)
    assert runs["case1"]["amplitude_m"] == pytest.approx(0.25)
    moving = {"forces_in": "earth", "moment_centre_moves": False}
    assert runs["case1"]["cfd"] == runs["case2"]["cfd"] == moving
    assert runs["case3"]["cfd"] == {"forces_in": "body", "moment_centre_moves": True}
    assert "omega of oscillatingRotatingMotion is no plain number" in text


TABLE = "// t [s] ((x y z) (rx ry rz))\n3\n(\n" + "".join(
    f"({t} (({1.2 * t:g} {-0.1 * t:g} 0) (0 0 {5 - t})))\n" for t in range(3)
) + ")\n"  # fmt: skip


def test_a_table_of_motions_is_read_by_itself(tmp_path):
    (tmp_path / "6DoF.dat").write_text(TABLE)
    request = Request(path=tmp_path / "6DoF.dat", shown="6DoF.dat")
    read, picked, _ = read_columns(request, {}, ("t",))
    found = {column.name: column.apply(x) for column, x in zip(picked, read.values, strict=True)}
    np.testing.assert_allclose(found["t"], [0, 1, 2])
    np.testing.assert_allclose(found["x"], [0, 1.2, 2.4])
    np.testing.assert_allclose(found["y"], [0, -0.1, -0.2])
    np.testing.assert_allclose(found["psi"], np.radians([5, 4, 3]))


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[: text.rindex("(2")] + ")",
        lambda text: text.replace("(2 ((2.4", "(2 ((2,4"),
        lambda text: text.replace("2.4 ", ""),
        lambda text: text.replace("2.4", "nan"),
        lambda text: text.replace("\n3\n", "\n4\n"),
    ],
    ids=["row lost", "comma", "number lost", "no number", "other length"],
)
def test_a_damaged_table_of_motions_is_refused(tmp_path, damage):
    (tmp_path / "6DoF.dat").write_text(damage(TABLE))
    request = Request(path=tmp_path / "6DoF.dat", shown="6DoF.dat")
    with pytest.raises(CampaignError, match="no whole table"):
        read_columns(request, {}, ("t",))
