"""OpenFOAM's results: every layout, restarts, folders, damage."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from foam_texts import (
    LAYOUTS,
    body_state,
    coefficients,
    esi,
    every,
    foundation,
    notes,
    numbers,
    old,
    old_local,
    total,
    written,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.intake import examine
from pmmkit.readers import READERS
from pmmkit.readers.openfoam.header import layout_of
from pmmkit.readers.openfoam.mesh_motion import density_doubt, entries_of, number_in, parsed
from scripts.datasets.campaign_text import S175

T, PARTS = numbers()
TOML = (
    """[campaign]
kind = "captive"
"""
    + S175
    + """{extra}
[[runs]]
id = "SD"
test = "static_drift"
file = "{file}"
speed = 1.5
drift_deg = 8.0
"""
)


def naive(text: str) -> np.ndarray:
    """Every number of every row, by the plainest means."""
    rows = [line for line in text.splitlines() if line and not line.startswith("#")]
    return np.array([[float(word) for word in re.sub(r"[()]", " ", row).split()] for row in rows])


@pytest.fixture(params=list(LAYOUTS))
def layout(request):
    return LAYOUTS[request.param]


def test_every_layout_gives_the_same_numbers(layout, tmp_path):
    write, groups = layout
    found = every(written(tmp_path / "postProcessing/forces/0", write(T, PARTS)))
    assert found["Time [s]"] == pytest.approx(T, rel=1e-15)
    for letter, unit in (("F", "N"), ("M", "N m")):
        for axis, name in enumerate("xyz"):
            whole = total(letter, axis, groups)
            assert found[f"{letter}{name} [{unit}]"] == pytest.approx(whole, rel=2e-6, abs=1e-6)
            for group in groups:
                mine = found[f"{letter}{name}_{group} [{unit}]"]
                assert np.array_equal(mine, PARTS[f"{letter}_{group}"][:, axis])


def test_sums_are_what_a_naive_reader_finds(tmp_path):
    text = foundation(T, PARTS)
    found = every(written(tmp_path, {"forces.dat": text}))
    table = naive(text)
    assert np.array_equal(found["Fx [N]"], table[:, 1] + table[:, 4])
    assert np.array_equal(found["Mz [N m]"], table[:, 9] + table[:, 12])


def test_other_programs_find_the_same(layout, tmp_path):
    """fluidfoam takes the file apart on its own; its columns follow the text."""
    reader = pytest.importorskip("fluidfoam.readpostpro")
    write, groups = layout
    files = write(T, PARTS)
    folder = written(tmp_path / "postProcessing/forces/0", files)
    found = every(folder)
    name = next(iter(files)).removesuffix(".dat")
    table = reader.readforce(str(tmp_path), namepatch="forces", time_name="0", name=name)
    first = 1 if name == "forces" else 4
    for axis, letter in enumerate("xyz"):
        columns = [first + 3 * group + axis for group in range(len(groups))]
        assert found[f"F{letter} [N]"] == pytest.approx(table[:, columns].sum(1), rel=1e-5)


def test_foamlib_finds_the_same(tmp_path):
    tables = pytest.importorskip("foamlib.postprocessing.table_reader", exc_type=ImportError)
    folder = written(tmp_path, {"force.dat": esi(T, PARTS, "F", brackets=False)})
    table = tables.TableReader().read(folder / "force.dat")
    assert every(folder)["Fy [N]"] == pytest.approx(table.iloc[:, 2].to_numpy(float), rel=1e-12)


def test_the_second_row_of_a_time_is_the_local_one(tmp_path):
    turned = {name: -2.0 * part for name, part in PARTS.items()}
    found = every(written(tmp_path, {"forces.dat": old_local(T, PARTS, turned)}))
    groups = ("pressure", "viscous", "porous")
    assert len(found["Time [s]"]) == len(T)
    assert found["Fy [N]"] == pytest.approx(total("F", 1, groups))
    assert found["local_Fy [N]"] == pytest.approx(-2.0 * total("F", 1, groups))


def test_the_same_time_twice_without_local_axes_is_refused(tmp_path):
    rows = old(T, PARTS).splitlines(keepends=True)
    with pytest.raises(CampaignError, match=r"row 9: the time does not rise"):
        every(written(tmp_path, {"forces.dat": "".join([*rows[:8], rows[7], *rows[8:]])}))


COEFFICIENTS = {
    "foundation": ("Cm", "Cd", "Cl", "Cl(f)", "Cl(r)"),
    "v2006": ("Cd", "Cs", "Cl", "CmRoll", "CmPitch", "CmYaw", "Cd(f)", "Cd(r)", "Cs(f)", "Cs(r)"),
    "v2412": ("Cd", "Cd(f)", "Cd(r)", "Cl", "Cl(f)", "Cl(r)", "CmPitch", "CmYaw", "Cs"),
}


@pytest.mark.parametrize("names", COEFFICIENTS.values(), ids=list(COEFFICIENTS))
def test_coefficients_go_by_name(names, tmp_path):
    rng = np.random.default_rng(2)
    values = {name: rng.normal(size=len(T)) for name in names}
    found = every(written(tmp_path, {"coefficient.dat": coefficients(T, values, names)}))
    assert set(found) == {"Time [s]", *(f"{name} [-]" for name in names)}
    for name in names:
        assert found[f"{name} [-]"] == pytest.approx(values[name], rel=1e-6)


def test_nothing_of_a_file_of_coefficients_is_taken_as_a_force(tmp_path):
    names = COEFFICIENTS["v2412"]
    written(tmp_path, {"c.dat": coefficients(T, dict.fromkeys(names, T), names)})
    (tmp_path / "campaign.toml").write_text(
        TOML.format(file="c.dat", extra='[source]\nformat = "openfoam"')
    )
    with pytest.raises(CampaignError, match="there is no column X"):
        open_campaign(tmp_path)["SD"].data  # noqa: B018
    (tmp_path / "campaign.toml").write_text(
        TOML.format(
            file="c.dat",
            extra='[source]\nformat = "openfoam"\n[columns]\nX = "Cd"\nY = "Cs"\nN = "CmYaw"',
        )
    )
    with pytest.raises(CampaignError, match="X is stated without dimension"):
        open_campaign(tmp_path)["SD"].data  # noqa: B018


@pytest.mark.parametrize("degrees", [True, False])
def test_the_motion_of_a_body(degrees, tmp_path):
    centre = np.column_stack([3.0 + 0.1 * np.sin(T), 0.2 * np.cos(T), 0 * T])
    angle = np.column_stack([0 * T, 0 * T, 10.0 * np.sin(T)])
    written(tmp_path, {"state.dat": body_state(T, centre, angle, degrees=degrees)})
    found = every(tmp_path)
    unit = "deg" if degrees else "rad"
    assert found[f"rotation_z [{unit}]"] == pytest.approx(angle[:, 2], rel=1e-12)
    assert found["centreOfRotation_x [m]"] == pytest.approx(centre[:, 0], rel=1e-12)
    assert found["displacement_y [m]"] == pytest.approx(centre[:, 1] - centre[0, 1], abs=1e-14)


def test_the_header_decides_and_not_the_name(tmp_path):
    written(tmp_path, {"hull v11.txt": foundation(T, PARTS), "0/forces.dat": "t,X\n1,2\n"})
    assert "Mz [N m]" in every(tmp_path / "hull v11.txt")
    assert READERS["openfoam"].recognises(tmp_path / "hull v11.txt", foundation(T, PARTS).encode())
    assert not READERS["openfoam"].recognises(tmp_path / "forces.dat", b"t,X\n1,2\n")
    with pytest.raises(CampaignError, match="header is not one of OpenFOAM"):
        every(tmp_path / "0/forces.dat")


@given(head=st.binary(max_size=300))
@settings(max_examples=150, deadline=None)
def test_no_header_is_too_odd(head):
    layout_of(b"# Force\n# Time\ttotal_x" + head)
    assert READERS["openfoam"].recognises(Path("x.dat"), head + b"\n") in (True, False)


# ---------------------------------------------------------------- folders and restarts


@pytest.fixture
def case(tmp_path) -> Path:
    """A case that was started twice; the second start computed the last ten rows anew."""
    again = {name: 2.0 * part for name, part in PARTS.items()}
    first = {f"postProcessing/hull/9/{n}": x for n, x in LAYOUTS["esi, flat"][0](T, PARTS).items()}
    second = LAYOUTS["esi, flat"][0](T[30:], {name: part[30:] for name, part in again.items()})
    return written(
        tmp_path / "case", first | {f"postProcessing/hull/10/{n}": x for n, x in second.items()}
    )


@pytest.mark.parametrize("place", ["", "postProcessing", "postProcessing/hull"])
def test_starts_in_numeric_order_the_later_one_counts(case, place):
    found = every(case / place)
    groups = ("pressure", "viscous")
    assert found["Time [s]"] == pytest.approx(T)
    assert found["Fy [N]"][:30] == pytest.approx(total("F", 1, groups)[:30], rel=1e-5, abs=1e-5)
    assert found["Mz [N m]"][30:] == pytest.approx(
        2 * total("M", 2, groups)[30:], rel=1e-5, abs=1e-4
    )
    assert "10 rows from t = 1.55 on replaced" in notes(case / place)


def test_a_start_time_folder_or_a_file_alone(case):
    assert len(every(case / "postProcessing/hull/10")["Time [s]"]) == 10
    found = every(case / "postProcessing/hull/9/moment.dat")
    assert len(found["Fx [N]"]) == len(found["Mx [N m]"]) == len(T)


def test_files_that_were_opened_again_in_one_folder(tmp_path):
    half = {name: -part[:8] for name, part in PARTS.items()}
    written(
        tmp_path / "0",
        {"forces.dat": foundation(T, PARTS), "forces_0.dat": foundation(T[:8], half)},
    )
    found = every(tmp_path)
    assert len(found["Time [s]"]) == 8
    assert found["Fx [N]"] == pytest.approx(-total("F", 0, ("pressure", "viscous"))[:8])
    assert "40 rows from t = 0.05 on replaced" in notes(tmp_path)


def test_rows_computed_beyond_a_later_start_are_not_mixed_in(tmp_path):
    """What the first start computed after the second began belongs to another history."""
    late = {name: part[10:12] for name, part in PARTS.items()}
    written(
        tmp_path,
        {"0/forces.dat": foundation(T, PARTS), "0.5/forces.dat": foundation(T[10:12], late)},
    )
    assert every(tmp_path)["Time [s]"] == pytest.approx(T[:12])


def test_a_start_that_wrote_nothing(tmp_path):
    text = foundation(T, PARTS)
    head = "".join(text.splitlines(keepends=True)[:3])
    written(tmp_path, {"0/forces.dat": text, "2/forces.dat": head, "3/forces.dat": ""})
    assert len(every(tmp_path)["Time [s]"]) == len(T)
    assert "2/forces.dat: there are no rows" in notes(tmp_path)
    assert "3/forces.dat: the file is empty" in notes(tmp_path)


def test_several_function_objects_are_listed(case):
    written(case, {"postProcessing/rudder/0/forces.dat": foundation(T, PARTS)})
    with pytest.raises(CampaignError, match=r"several function objects: hull, rudder") as caught:
        every(case)
    assert "case/postProcessing/hull" in str(caught.value)


def test_coefficients_beside_forces_do_not_compete(case):
    names = COEFFICIENTS["v2412"]
    text = coefficients(T, dict.fromkeys(names, T), names)
    written(case, {"postProcessing/coeffs/0/coefficient.dat": text})
    assert "Fx [N]" in every(case)
    assert "Cd [-]" in every(case / "postProcessing/coeffs")


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({"a/b.txt": "x"}, "no forces, coefficients or motions"),
        ({"0/bins.dat": "# bins\n1 2\n"}, "bins.dat hold something else"),
        ({"postProcessing/probes/0/p": "1 2\n"}, "it has probes"),
        ({"0/a.dat": foundation(T, PARTS), "0/b.dat": foundation(T, PARTS)}, "several files"),
        (
            {"0/forces.dat": foundation(T, PARTS), "1/forces.dat": old(T + 2, PARTS)},
            "columns are not those of",
        ),
        (
            {
                "0/forces.dat": foundation(T, PARTS),
                "1/forces.dat": foundation(T + 2, PARTS).replace("(3.5", "(4.5", 1),
            },
            "CofR is",
        ),
        ({"0/forces.dat": foundation(T, PARTS), "1/forces.dat": "x" * 99}, "header is not one"),
    ],
)
def test_folders_that_do_not_hold_one_history(files, words, tmp_path):
    with pytest.raises(CampaignError, match=words):
        every(written(tmp_path / "case", files))


def test_forces_and_moments_of_different_computations(tmp_path):
    for moment, words in ((T + 0.01, "row 1 of numbers is at t = 0.05"), (T[:30], "40 and 30")):
        parts = {name: part[: len(moment)] for name, part in PARTS.items()}
        written(
            tmp_path,
            {
                "force.dat": esi(T, PARTS, "F", brackets=True),
                "moment.dat": esi(moment, parts, "M", brackets=True),
            },
        )
        with pytest.raises(CampaignError, match=words):
            every(tmp_path)


# ---------------------------------------------------------------- campaigns


def campaign(folder: Path, file: str, extra: str = ""):
    (folder / "campaign.toml").write_text(TOML.format(file=file, extra=extra), encoding="utf-8")
    return open_campaign(folder)


def test_a_case_needs_no_more_than_its_folder(case):
    """Where [columns] says nothing, X, Y, N, K are Fx, Fy, Mz, Mx."""
    data = campaign(case.parent, "case")["SD"].data
    found = every(case)
    for ours, theirs in (("X", "Fx [N]"), ("Y", "Fy [N]"), ("N", "Mz [N m]"), ("K", "Mx [N m]")):
        assert np.array_equal(data[ours].values, found[theirs])
    assert "moments about CofR (3.5" in data.attrs["conversions"]


def test_what_the_campaign_file_says_counts_before_what_is_usual(case):
    data = campaign(
        case.parent, "case", '[columns]\nX = { name = "Fx_pressure", scale = -1 }\nK = false'
    )["SD"].data
    assert np.array_equal(data["X"].values, -every(case)["Fx_pressure [N]"])
    assert "K" not in data


def test_hashes_of_a_folder_are_those_of_the_files_that_were_read(case):
    hashes = campaign(case.parent, "case").file_hashes()
    assert sorted(hashes) == [
        f"case/postProcessing/hull/{start}/{half}.dat"
        for start in ("10", "9")
        for half in ("force", "moment")
    ]


def test_a_folder_of_another_format_is_refused(tmp_path):
    (tmp_path / "runs").mkdir()
    with pytest.raises(CampaignError, match="runs"):
        campaign(tmp_path, "runs", '[source]\nformat = "csv"')["SD"].data  # noqa: B018
    with pytest.raises(CampaignError, match="no forces, coefficients or motions"):
        campaign(tmp_path, "runs")["SD"].data  # noqa: B018


def test_rows_of_a_table_are_not_sought_in_a_case(case):
    text = TOML.format(file="case", extra="") + 'row = { "Time" = 1.0 }\n'
    (case.parent / "campaign.toml").write_text(text)
    with pytest.raises(CampaignError, match="a history, not a table"):
        open_campaign(case.parent)


CONTROL = """/*--------*- C++ -*--------*\\
FoamFile { version 2.0; format ascii; class dictionary; }
application interFoam; // rhoInf 5;
#include "more"
density 998.2;
#codeStream { code #{ rhoInf 3; #}; }
functions
{
    #includeFunc residuals
    "hull"
    {
        type forces; libs ("libforces.so"); patches ("hull.*" rudder);
        rho rhoInf; %s
        CofR (0.35 0 0.02);
    }
}
"""


@pytest.mark.parametrize(
    ("rho_inf", "doubtful"),
    [
        ("rhoInf 1;", True),
        ("rhoInf 1.0;", True),
        ("", True),
        ("rhoInf rhoInf [1 -3 0 0 0 0 0] 1;", True),
        ("rhoInf 998.2;", False),
        ("rhoInf $density;", False),
        ('rhoInf #calc "1";', False),
    ],
)
def test_forces_per_density_are_doubted_unless_the_campaign_says_so(case, rho_inf, doubtful):
    comment_closed = CONTROL.replace("*\\", "*/", 1)
    written(case, {"system/controlDict": comment_closed % rho_inf})
    said = campaign(case.parent, "case")["SD"].data.attrs["conversions"]
    assert ("doubtful" in said) == doubtful
    assert "controlDict: rho rhoInf" in said
    assert "CofR" in said
    stated = campaign(case.parent, "case", "[cfd]\nrho_inf = 1.0")["SD"].data
    assert "doubtful" not in stated.attrs["conversions"]
    assert stated["Y"].values == pytest.approx(999.1 * every(case)["Fy [N]"])


def test_a_doubted_density_is_a_warning_of_the_checks(case):
    written(case, {"system/controlDict": CONTROL.replace("*\\", "*/", 1) % "rhoInf 1;"})
    (found,) = [each for each in examine(campaign(case.parent, "case")) if each.check == "density"]
    assert found.severity == "warning"
    assert found.runs == ("SD",)
    settled = examine(campaign(case.parent, "case", "[cfd]\nrho_inf = 1.0"))
    assert "density" not in {each.check for each in settled}


def test_a_dictionary_is_only_looked_at(case):
    written(case, {"system/controlDict": CONTROL.replace("*\\", "*/", 1) % "rhoInf 998.2;"})
    entries = entries_of(case / "postProcessing/hull/9/force.dat")
    assert entries["CofR"] == "(0.35 0 0.02)"
    assert entries["patches"] == '("hull.*" rudder)'
    assert number_in(entries["rhoInf"]) == 998.2
    assert density_doubt({"type": "forces"}) is None


@given(text=st.text(alphabet='{}();"/*# \nabc$[]\\1.', max_size=200))
@settings(max_examples=200, deadline=None)
def test_no_dictionary_is_too_odd(text):
    assert isinstance(parsed(text), dict)


@pytest.mark.slow
@pytest.mark.parametrize("bomb", ["{", "/*", '"', "#{", "(", "a{b{c;"])
def test_a_dictionary_of_nothing_but_openings_takes_no_time(bomb):
    assert isinstance(parsed(bomb * 100_000), dict)
