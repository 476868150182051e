"""Transfer functions of other programs: axes, sides, directions and units of each."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from few_stations import thinned

from pmmkit.base import DataError
from pmmkit.seakeeping import (
    Rao,
    Sea,
    added_resistance,
    drift_part,
    hull_from_particulars,
    rao,
    read_hull,
    read_rao,
    response,
)
from pmmkit.seakeeping.second_order.mean_drift import drift

G, RHO, L, B = 9.80665, 1025.0, 120.0, 20.0
OMEGA = np.array([0.3, 0.45, 0.6, 0.8, 1.1, 1.5])
HEADINGS = np.array([0.0, 30.0, 90.0, 150.0, 180.0])
K = OMEGA**2 / G


def floats(heading_deg, *, port):
    """A raft that goes with the water of long waves, x forward, y to port, z up (6, b, w).

    With exp(iωt) the surface is exp(-ik x·e), its water moves by -i along the direction e of the
    waves, and the raft leans as the surface does.
    """
    beta = np.radians(heading_deg)[:, None]
    e = np.stack([np.cos(beta), np.sin(beta) if port else -np.sin(beta)]) + 0 * K
    along, across = e
    return np.stack([-1j * along, -1j * across, 1 + 0j * along, -1j * K * across, 1j * K * along])


def wamit(folder, scale=2.0, height=0.0):
    """What WAMIT writes of the raft: waves of 0° run ahead, of 90° to port."""
    path = folder / "raft.4"
    moved = np.concatenate([floats(HEADINGS, port=True), np.full((1, 5, OMEGA.size), 0.25j)])
    # about a point above the water: it goes along by the rotations
    moved[0] += height * moved[4]
    moved[1] -= height * moved[3]
    moved[3:] *= scale
    force = np.arange(1, 7)[:, None, None] * np.exp(1j * np.arange(5 * OMEGA.size).reshape(5, -1))
    with path.open("w") as file, path.with_suffix(".3").open("w") as excited:
        for c, omega in reversed(list(enumerate(OMEGA))):
            for b, heading in enumerate(HEADINGS):
                for mode in range(6):
                    for values, to in ((moved, file), (force, excited)):
                        x = values[mode, b, c]
                        to.write(
                            f" {2 * math.pi / omega:.9e} {heading:.6e} {mode + 1:5d} "
                            f"{abs(x):.9e} {math.degrees(np.angle(x)):.9e} {x.real:.9e} "
                            f"{x.imag:.9e}\n"
                        )
    path.with_suffix(".gdf").write_text(f"raft\n{scale} {G} ULEN GRAV\n0 1\n0\n")
    return path, force


def pushed(path, suffix, scale=2.0):
    """Mean drift as WAMIT writes it, beside crossing waves and body axes, which do not count."""
    with path.with_suffix(suffix).open("w") as file:
        for omega in OMEGA:
            for heading in HEADINGS:
                for other in (heading, heading + 10.0):
                    for mode, value in ((1, 3.0), (2, 5.0), (6, 7.0), (-6, 99.0)):
                        size = value * omega if other == heading else 1e3
                        file.write(
                            f" {2 * math.pi / omega:.9e} {heading:.6e} {other:.6e} {mode} "
                            f"{size:.9e} 0.0 {size:.9e} 0.0\n"
                        )
    return scale


def test_a_raft_of_wamit_goes_with_the_water(tmp_path):
    path, force = wamit(tmp_path)
    found = read_rao(path, L=L, B=B)
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-8)
    np.testing.assert_allclose(np.degrees(found.heading), HEADINGS)
    np.testing.assert_allclose(found.motion[:5, 0], floats(HEADINGS, port=False), atol=1e-8)
    np.testing.assert_allclose(found.motion[5, 0], -0.25j, atol=1e-8)  # the mirror of +.25
    sizes = RHO * G * np.array([4.0, -4.0, 4.0, -8.0, 8.0, -8.0])
    np.testing.assert_allclose(found.force[:, 0], sizes[:, None, None] * force, rtol=1e-7)
    assert (found.engine, found.speed.tolist(), found.g) == ("WAMIT", [0.0], G)


def test_an_origin_above_the_water_is_carried_down(tmp_path):
    path, _ = wamit(tmp_path, height=3.0)
    found = read_rao(path, L=L, B=B, z=3.0)
    np.testing.assert_allclose(found.motion[:5, 0], floats(HEADINGS, port=False), atol=1e-8)


@pytest.mark.parametrize("suffixes", [(".8",), (".9",), (".8", ".9")])
def test_mean_drift_of_wamit_about_midship(tmp_path, suffixes):
    path, _ = wamit(tmp_path)
    scale = min(pushed(path, suffix) for suffix in suffixes)
    if len(suffixes) > 1:  # by momentum before by pressure
        path.with_suffix(".9").write_text("")
    found = read_rao(path, L=L, B=B, x=10.0)
    unit = RHO * G * scale * OMEGA
    X, Y, N = found.second_order[:, 0, 2]
    np.testing.assert_allclose(X, 3.0 * unit, rtol=1e-8)
    np.testing.assert_allclose(Y, -5.0 * unit, rtol=1e-8)  # waves of 90° run to starboard here
    np.testing.assert_allclose(N, -7.0 * scale * unit - 10.0 * 5.0 * unit, rtol=1e-8)
    added = added_resistance(found)
    np.testing.assert_allclose(added.methods["WAMIT"], -found.second_order[0])
    table = drift_part(found, Sea(Hs=1.0, Tp=12.0)).values
    assert min(table["DX"]) > 0.0
    assert max(table["DY"]) < 0.0  # from starboard they push to port


def test_without_a_scale_it_is_taken_as_a_metre_and_said(tmp_path):
    path, _ = wamit(tmp_path, scale=1.0)
    path.with_suffix(".gdf").unlink()
    found = read_rao(path, L=L, B=B, g=G)
    np.testing.assert_allclose(found.motion[:5, 0], floats(HEADINGS, port=False), atol=1e-8)
    assert any("1 m" in note for note in found.notes)


def capytaine(path, *, split=True, drop=(), **more):
    """A dataset as capytaine writes it, of a raft of which mass and water are drawn at random."""
    rng = np.random.default_rng(4)
    modes = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]

    def matrix(*shape):
        drawn = rng.normal(size=(*shape, 6, 6))
        return drawn @ np.swapaxes(drawn, -1, -2) + 6.0 * np.eye(6)

    mass, still, added, damping = matrix(), matrix(), matrix(OMEGA.size), matrix(OMEGA.size)
    raft = np.concatenate([floats(HEADINGS, port=True), np.full((1, 5, OMEGA.size), 0.25j)]).conj()
    w = OMEGA[:, None, None]
    system = still - w**2 * (mass + added) - 1j * w * damping
    force = np.einsum("wij,jbw->wbi", system, raft)
    dofs = ("influenced_dof", "radiating_dof")
    around = ("omega", "wave_direction", "influenced_dof")
    data = xr.Dataset(
        {
            "inertia_matrix": (dofs, mass),
            "hydrostatic_stiffness": (dofs, still),
            "added_mass": (("omega", *dofs), added),
            "radiation_damping": (("omega", *dofs), damping),
            "Froude_Krylov_force": (around, 0.25 * force),
            "diffraction_force": (around, 0.75 * force),
            "rho": RHO,
            "g": G,
            **more,
        },
        coords={
            "omega": OMEGA,
            "wave_direction": np.radians(HEADINGS),
            "body": "raft",
            "influenced_dof": modes,
            "radiating_dof": modes,
        },
    ).drop_vars(drop)
    if split:
        for name in ("Froude_Krylov_force", "diffraction_force"):
            if name in data:
                parts = [data[name].real, data[name].imag]
                data[name] = xr.concat(parts, dim="complex").assign_coords(complex=["re", "im"])
        data.to_netcdf(path, engine="h5netcdf")
    return path


def test_a_raft_of_capytaine_whose_time_runs_the_other_way(tmp_path):
    found = read_rao(capytaine(tmp_path / "raft.nc"), L=L, B=B)
    np.testing.assert_allclose(found.motion[:5, 0], floats(HEADINGS, port=False), atol=1e-9)
    assert (found.engine, found.name) == ("capytaine", "raft")
    assert any("damped by waves alone" in note for note in found.notes)


@pytest.mark.parametrize("name", ["inertia_matrix", "hydrostatic_stiffness"])
def test_a_dataset_without_mass_or_stiffness_says_what_it_lacks(tmp_path, name):
    with pytest.raises(DataError, match=name):
        read_rao(capytaine(tmp_path / "raft.nc", drop=(name,)), L=L, B=B)


@pytest.fixture(scope="module")
def own() -> Rao:
    hull = thinned(hull_from_particulars(name="ship", L=100.0, B=18.0, d=6.0, block=0.65, xB=-0.5))
    return rao(
        hull, speeds=[0.0, 6.0], headings_deg=[0, 60, 180], omega=[0.3, 0.4, 0.55, 0.7, 0.9, 1.3]
    )


def test_its_own_dataset_comes_back(own, tmp_path):
    own.to_xarray().to_netcdf(tmp_path / "rao.nc", engine="h5netcdf")
    found = read_rao(tmp_path / "rao.nc")
    np.testing.assert_allclose(found.motion, own.motion, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(found.encounter, own.encounter)
    assert (found.L, found.B, found.x) == (own.L, own.B, own.x)
    assert (found.name, found.engine) == ("ship", "strip theory")


def test_its_own_table_comes_back_in_any_order(own, tmp_path):
    own.to_pandas().sample(frac=1.0, random_state=1).to_csv(tmp_path / "rao.csv", index=False)
    found = read_rao(tmp_path / "rao.csv", L=own.L, B=own.B, x=own.x, g=own.g)
    np.testing.assert_allclose(found.motion, own.motion, rtol=1e-12, atol=1e-14)
    sea = Sea(Hs=2.0, Tp=11.0)
    lifted, as_before = (
        response(each, sea, speed=6.0, heading_deg=180.0).motions["heave"].m0
        for each in (found, own)
    )
    assert lifted == pytest.approx(as_before, rel=1e-12)


def test_forces_and_mean_drift_come_back_too(own, tmp_path):
    pushed = replace(own, second_order=added_resistance(own).drift)
    pushed.to_xarray().to_netcdf(tmp_path / "rao.nc", engine="h5netcdf")
    pushed.to_pandas().to_csv(tmp_path / "rao.csv", index=False)
    for found in (
        read_rao(tmp_path / "rao.nc"),
        read_rao(tmp_path / "rao.csv", L=own.L, B=own.B, x=own.x),
    ):
        size = np.abs(own.force).max(axis=(1, 2, 3), keepdims=True)
        assert (np.abs(found.force - own.force) <= 1e-12 * size).all()
        np.testing.assert_allclose(found.second_order, pushed.second_order, rtol=1e-9, atol=1e-3)


def test_a_ship_at_rest_as_a_dataset_of_capytaine_moves_as_before(own, tmp_path):
    """capytaine 3.0.0 itself moves by it to 1e-15 of the wave."""
    own.to_capytaine().to_netcdf(tmp_path / "ship.nc", engine="h5netcdf")
    found = read_rao(tmp_path / "ship.nc", L=own.L, B=own.B, x=own.x)
    np.testing.assert_allclose(found.motion[:, 0], own.motion[:, 0], atol=1e-12)
    assert found.name == "ship"
    with pytest.raises(DataError, match="0 be among the speeds"):
        own.at_speed(1).to_capytaine()


def test_with_its_hull_mean_drift_is_computed_by_sections_too(own, tmp_path):
    own.to_xarray().to_netcdf(tmp_path / "rao.nc", engine="h5netcdf")
    bare = read_rao(tmp_path / "rao.nc")
    with pytest.raises(DataError, match="without a hull"):
        added_resistance(bare)
    found = read_rao(tmp_path / "rao.nc", hull=own.strips.hull, loading=own.loading)
    there = ~own.quasi_static
    for name, values in added_resistance(own).methods.items():
        ours = added_resistance(found).methods[name]
        np.testing.assert_allclose(ours[there], values[there], rtol=1e-6, equal_nan=True)


@pytest.mark.parametrize("kept", [0.2, 0.5, 0.99])
def test_a_file_that_breaks_off_is_refused(shared_data, tmp_path, kept):
    whole = shared_data / "s175_seakeeping_veres" / "input.re1"
    content = whole.read_bytes()
    (tmp_path / "input.re1").write_bytes(content[: int(kept * len(content))])
    with pytest.raises(DataError, match="ends before"):
        read_rao(tmp_path / "input.re1")


def test_a_drift_of_other_headings_is_refused(shared_data, tmp_path):
    folder = shared_data / "s175_seakeeping_veres"
    shutil.copy(folder / "input.re1", tmp_path)
    text = (folder / "input.re2").read_text(encoding="latin-1")
    (tmp_path / "input.re2").write_text(text.replace("     5    19    36", "     5    18    36"))
    with pytest.raises(DataError, match="other headings"):
        read_rao(tmp_path / "input.re1")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.dat", "1 2 3", "read from"),
        ("a.4", "1.0 0.0 1 1.0 0.0 1.0\n", "6 numbers, not 7"),
        ("a.4", "", "frequencies"),
        ("a.re1", "nothing", "ends before"),
        ("a.csv", "speed,heave\n1,2\n", "heading_deg"),
        ("a.nc", "nothing", "cannot be read"),
    ],
)
def test_what_is_no_transfer_function(tmp_path, name, content, says):
    (tmp_path / name).write_text(content)
    with pytest.raises(DataError, match=says):
        read_rao(tmp_path / name, L=L, B=B)


def test_length_and_breadth_must_be_stated(tmp_path):
    with pytest.raises(DataError, match="no length and no breadth"):
        read_rao(wamit(tmp_path)[0])


@pytest.mark.slow
def test_drift_of_s175_in_oblique_waves_beside_that_of_veres(shared_data):
    """At rest: in the shortest waves (6 m) Y to 2 and N to 6 % of another strip program; over all
    headings and waves up to 400 m half of their rms, by what each section does alone: in beam waves
    as long as the ship its Y is 140 times that of a panel method, so by momentum nobody is near."""
    folder = shared_data / "s175_seakeeping_veres"
    hull = read_hull(folder / "shipx_geometry.mgf", draught=9.5)
    theirs = read_rao(folder / "input.re1", hull=hull)
    own = replace(theirs, second_order=None)
    ours, alone = (drift(own, method=name)[:, 0] for name in ("momentum", "sections"))
    other = theirs.second_order[:, 0]
    oblique = [int(np.argmin(np.abs(np.degrees(theirs.heading) - h))) for h in (30, 60, 120, 150)]
    for row, most in ((1, 0.02), (2, 0.06)):
        given = other[row, oblique, -1]
        np.testing.assert_allclose(ours[row, oblique, -1], given, rtol=most)
        waves = theirs.omega > 0.4
        off, size = (x[row][:, waves] for x in (alone - other, other))
        assert math.sqrt(np.mean(off**2) / np.mean(size**2)) < 0.52
