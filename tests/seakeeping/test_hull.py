"""Hulls from offsets, files and particulars: hydrostatics, maps, and what is refused."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from pmmkit.base import DataError, UnknownNameError
from pmmkit.seakeeping import Hull, Loading, hull_from_particulars, load_hull, rao, read_hull
from pmmkit.seakeeping.hull_forms.hull import Station
from pmmkit.seakeeping.hull_forms.particulars import hulls
from pmmkit.seakeeping.mapping import area, at, fit_sections, fitted, is_conformal, lewis, misfit

X = np.linspace(-50.0, 50.0, 21)


def box(draught=5.0, half=8.0, x=X):
    corner = np.array([0.0, half, half]), np.array([0.0, 0.0, draught + 3.0])
    return Hull(
        name="box",
        L=100.0,
        draught=draught,
        stations=tuple(Station(x=float(at_), y=corner[0], z=corner[1]) for at_ in x),
    )


def test_hydrostatics_of_a_box():
    """Volume LBT, KB = T/2, BM = B²/(12T)."""
    found = box().hydrostatics
    assert found.volume == pytest.approx(100 * 16 * 5)
    assert pytest.approx(2.5) == found.KB
    assert pytest.approx(16**2 / (12 * 5)) == found.KM - found.KB
    assert found.along == pytest.approx(16 * 100**3 / 12, rel=6e-3)  # straight between stations
    assert (found.xB, found.xF) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_hydrostatics_of_a_wedge():
    """A section that is a triangle: half the area, KB = 2T/3."""
    y, z = np.array([0.0, 6.0]), np.array([0.0, 4.0])
    hull = Hull(
        name="v", L=100, draught=4.0, stations=tuple(Station(x=float(a), y=y, z=z) for a in X)
    )
    assert hull.areas == pytest.approx(np.full(21, 24.0))
    assert pytest.approx(8 / 3) == hull.hydrostatics.KB


def test_s175_is_followed_by_its_maps(shared_data):
    hull = read_hull(shared_data / "s175_seakeeping_veres" / "shipx_geometry.mgf", draught=9.5)
    found = fit_sections(hull.contours, [f"x = {x:g} m" for x in hull.x])
    assert np.abs(area(found.maps) / hull.areas - 1).max() < 0.02
    assert len(found.notes) == 2  # the two stations of the bulb with a neck


@pytest.mark.parametrize(
    ("b", "T", "full"), [(20, 8, 0.6), (20, 8, 0.9), (4, 9, 0.7), (30, 2, 0.8)]
)
def test_close_fit_of_a_lewis_form_is_that_form(b, T, full):
    form = lewis(b, T, full * b * T)
    contour = at(form, np.linspace(0, math.pi / 2, 400))
    again = fitted(contour, 5)
    np.testing.assert_allclose(again[:3], form, atol=2e-3 * T)
    assert np.abs(again[3:]).max() < 2e-3 * T
    assert misfit(again, contour) < 3e-3 * max(T, b / 2)


def test_a_lewis_form_that_does_not_exist_is_refused_with_the_range():
    with pytest.raises(DataError, match=r"between 0\.29"):
        lewis(2.0, 1.0, 0.4)


def test_a_hull_from_particulars_has_them():
    hull = hull_from_particulars(
        name="tanker", L=320, B=58, d=20.8, block=0.81, midship=0.997, waterplane=0.886, xB=8.0
    )
    found = hull.hydrostatics
    assert found.volume == pytest.approx(0.81 * 320 * 58 * 20.8, rel=2e-3)
    assert found.waterplane == pytest.approx(0.886 * 320 * 58, rel=5e-3)
    assert found.xB == pytest.approx(8.0, abs=0.3)
    assert found.xF == pytest.approx(0.0, abs=0.3)
    assert hull.areas.max() == pytest.approx(0.997 * 58 * 20.8, rel=3e-3)
    assert "not the ship's" in hull.notes[0]


def test_files_of_offsets_and_of_curves_give_the_hull(tmp_path):
    points = ["x,y,z"]
    points += [f"{x},{y},{z}" for x in X for y, z in ((0, 0), (8, 0), (8, 8))]
    (tmp_path / "box.csv").write_text("\n".join(points))
    assert read_hull(tmp_path / "box.csv", draught=5.0, L=100.0).hydrostatics == box().hydrostatics
    curves = ["# a ship of half circles", "x,breadth,draught,area"]
    curves += [f"{x},10,5,{12.5 * math.pi}" for x in X]
    (tmp_path / "round.csv").write_text("\n".join(curves))
    found = read_hull(tmp_path / "round.csv", draught=5.0, L=100.0)
    assert found.hydrostatics.volume == pytest.approx(1250 * math.pi, rel=1e-3)


def test_the_layout_of_shipx_runs_aft_and_downward(tmp_path):
    lines = ["boxlike", "", "", "", "100.0"]
    for number, x in enumerate(X[::-1], start=1):
        lines += [str(number), f"{-x}", "3", "8.0 8.0", "8.0 0.0", "0.0 0.0"]
    (tmp_path / "box.mgf").write_text("\n".join(lines))
    found = read_hull(tmp_path / "box.mgf", draught=5.0)
    assert found.name == "boxlike"
    assert found.hydrostatics == box().hydrostatics


WIGLEY = {"L": 80.0, "B": 8.0, "d": 5.0}


def wigley_panels(*, whole=False, quarter=False, side=1.0, base=False, lid=False):
    """Corners (n, 4, 3) of a Wigley hull, y = B/2 (1 - (2x/L)²)(1 - (z/d)²) below the water."""
    L, B, d = WIGLEY.values()
    x, z = np.meshgrid(np.linspace(0 if quarter else -L / 2, L / 2, 61), np.linspace(-d, 0, 31))
    y = B / 2 * (1 - (2 * x / L) ** 2) * (1 - (z / d) ** 2)
    found = []
    for sign in (side, -side) if whole else (side,):
        points = np.stack([x, sign * y, z + (d if base else 0.0)], axis=-1)
        flat = np.stack([x, sign * y * (1 + z / d), 0 * z + (d if base else 0.0)], axis=-1)
        for grid in (points, flat) if lid else (points,):
            corners = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
            found.append(np.stack(corners, axis=2).reshape(-1, 4, 3))
    return np.concatenate(found)


def as_gdf(path, panels, isx=0, scale=1.0):
    rows = [" ".join(f"{x / scale:.6f}" for x in corner) for panel in panels for corner in panel]
    head = ["a Wigley hull", f"{scale} 9.81 ULEN GRAV", f"{isx} 1 ISX ISY", str(len(panels))]
    path.write_text("\n".join([*head, *rows]))


def as_stl(path, panels, *, plain):
    triangles = np.concatenate([panels[:, [0, 1, 2]], panels[:, [0, 2, 3]]])
    if plain:
        rows = ["solid hull"]
        for triangle in triangles:
            rows += ["facet normal 0 0 0", "outer loop"]
            rows += [f"vertex {x:.6f} {y:.6f} {z:.6f}" for x, y, z in triangle]
            rows += ["endloop", "endfacet"]
        path.write_text("\n".join([*rows, "endsolid"]))
        return
    facets = b"".join(
        np.r_[[0.0] * 3, triangle.ravel()].astype("<f4").tobytes() + b"\0\0"
        for triangle in triangles
    )
    path.write_bytes(
        b"solid in name only".ljust(80) + len(triangles).to_bytes(4, "little") + facets
    )


MESHES = {
    "port.gdf": lambda path: as_gdf(path, wigley_panels()),
    "starboard.gdf": lambda path: as_gdf(path, wigley_panels(side=-1.0), scale=2.0),
    "quarter.gdf": lambda path: as_gdf(path, wigley_panels(quarter=True), isx=1),
    "base.stl": lambda path: as_stl(path, wigley_panels(whole=True, base=True), plain=True),
    "lid.stl": lambda path: as_stl(path, wigley_panels(whole=True, lid=True), plain=False),
}


@pytest.mark.parametrize("name", MESHES)
def test_a_wigley_hull_comes_back_from_a_mesh(name, tmp_path):
    """∇ = 4/9 LBd, waterplane 2/3 LB, KB = 5/8 d, both centres midship."""
    MESHES[name](tmp_path / name)
    L, B, d = WIGLEY.values()
    hull = read_hull(tmp_path / name, draught=d)
    found = hull.hydrostatics
    assert pytest.approx(L, rel=1e-6) == hull.L
    assert found.volume == pytest.approx(4 / 9 * L * B * d, rel=0.01)
    assert found.waterplane == pytest.approx(2 / 3 * L * B, rel=0.01)
    assert pytest.approx(5 / 8 * d, rel=0.01) == found.KB
    assert (found.xB, found.xF) == pytest.approx((0.0, 0.0), abs=0.01 * L)
    assert any("length of the mesh" in note for note in hull.notes)


@pytest.mark.parametrize("suffix", [".gdf", ".stl"])
def test_a_hull_comes_back_from_the_mesh_that_it_was_written_to(suffix, tmp_path):
    ship = load_hull("s175-design")
    ship.write(tmp_path / f"ship{suffix}")
    there, back = ship.hydrostatics, read_hull(tmp_path / f"ship{suffix}", draught=9.5).hydrostatics
    assert back.volume == pytest.approx(there.volume, rel=0.01)
    assert pytest.approx(there.KM, rel=0.02) == back.KM
    assert (back.xB, back.xF) == pytest.approx((there.xB, there.xF), abs=0.002 * 175)


def test_panels_are_closed_below_the_water():
    """Of a closed surface the areas add up to none, but for the water above and the middle line."""
    hull = load_hull("s175-design")
    panels = hull.panels(across=40)
    area = 0.5 * np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1])
    assert area[:, 0].sum() == pytest.approx(0.0, abs=1.0)
    assert -2 * area[:, 2].sum() == pytest.approx(hull.hydrostatics.waterplane, rel=0.01)
    middle = panels.mean(axis=1)
    volume = 2 * np.sum(middle * area, axis=-1).sum() / 3
    assert volume == pytest.approx(hull.hydrostatics.volume, rel=0.01)


def test_a_hull_is_not_written_as_anything(tmp_path):
    with pytest.raises(DataError, match=r"written as \.gdf and \.stl"):
        load_hull("s175-design").write(tmp_path / "ship.iges")


def test_a_bulb_below_the_water_keeps_its_volume(tmp_path):
    """8 m of a ring of 4 m², of which 3 lie in the ship."""
    panels = wigley_panels()
    bulb = np.linspace(-3.0, 5.0, 9)
    ring = np.array([[1.0, -4.0], [1.5, -3.0], [0.0, -2.0]])
    corners = [
        [[40 + a, *ring[i]], [40 + b, *ring[i]], [40 + b, *ring[i + 1]], [40 + a, *ring[i + 1]]]
        for a, b in itertools.pairwise(bulb)
        for i in range(2)
    ]
    as_gdf(tmp_path / "bulb.gdf", np.concatenate([panels, corners]))
    hull = read_hull(tmp_path / "bulb.gdf", draught=5.0, L=80.0)
    assert hull.x.max() > 44.0
    assert any("keep their volume under a narrow neck" in note for note in hull.notes)
    as_gdf(tmp_path / "bare.gdf", panels)
    bare = read_hull(tmp_path / "bare.gdf", draught=5.0, L=80.0)
    more = hull.hydrostatics.volume - bare.hydrostatics.volume
    assert 5 * 4.0 < more < 8 * 4.0
    assert hull.hydrostatics.waterplane == pytest.approx(bare.hydrostatics.waterplane, rel=0.01)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.gdf", "a\n1.0 9.81\n0 1\n2\n0 0 0\n", "no low-order geometry"),
        ("a.gdf", "FPSO\n1 9.81\n0 1\n6 -11\n3\n30 150 20 XBOW\n", "no low-order geometry"),
        ("a.stl", "solid\nvertex 0 0 0\nvertex 1 0 0\n", "whole triangles"),
        ("a.stl", "", "no panels"),
        ("a.stl", "solid\n" + "vertex 0 0 99\n" * 3, "reaches down to z = 99 m"),
        ("a.stl", "solid\n" + "vertex 0 0 nan\n" * 3, "finite"),
    ],
)
def test_what_is_no_mesh_of_a_hull(tmp_path, name, content, says):
    (tmp_path / name).write_text(content)
    with pytest.raises(DataError, match=says):
        read_hull(tmp_path / name, draught=5.0)


def offsets(place=lambda x: x, y=8.0, z=8.0):
    """A box of 100 x 16 x 5 m as a file of offsets, its places, half breadths, heights changed."""
    points = [f"{place(x)},{a},{b}" for x in X for a, b in ((0, 0), (y, 0), (y, z))]
    return "\n".join(["x,y,z", *points])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (offsets(lambda x: x + 50), "from the aft perpendicular. Subtract 50 m"),
        (offsets(lambda x: x - 50), "from the forward perpendicular. Add 50 m"),
        (offsets(lambda x: 1000 * x), "are both in metres"),
        (offsets(y=8000.0), "are half breadths in metres"),
        (offsets(lambda x: x / 100), "are both in metres"),
        (offsets(y=0.08, z=8.0), "are half breadths in metres"),
    ],
)
def test_a_wrong_frame_or_unit_is_refused_with_what_it_may_be(tmp_path, text, says):
    (tmp_path / "box.csv").write_text(text)
    with pytest.raises(DataError, match=says):
        read_hull(tmp_path / "box.csv", draught=5.0, L=100.0)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_hull_whose_bow_stands_aft_is_doubted(sign, tmp_path):
    ship = load_hull("s175-design")
    rows = [
        f"{sign * x},{point.imag},{9.5 - point.real}"
        for x, contour in zip(ship.x, ship.contours, strict=True)
        for point in contour
    ]
    (tmp_path / "s175.csv").write_text("\n".join(["x,y,z", *rows]))
    notes = read_hull(tmp_path / "s175.csv", draught=9.5, L=175.0).notes
    assert any("positive aft" in note for note in notes) is (sign < 0)


def test_what_a_drawing_leaves_is_no_error(tmp_path):
    """A keel with a step of .01 mm, and a stem above the water."""
    points = [f"{x},{a},{b}" for x in X for a, b in ((0, 0), (8, 1e-5), (8, 0), (8, 8))]
    points += [f"52,0,{z}" for z in (6, 8)]
    (tmp_path / "box.csv").write_text("\n".join(["x,y,z", *points]))
    found = read_hull(tmp_path / "box.csv", draught=5.0, L=100.0)
    assert found.notes == ("Stations above the water are left out: x = 52 m.",)
    assert found.hydrostatics.volume == pytest.approx(8000.0, rel=1e-5)


def test_motions_say_how_the_hull_floats():
    told = str(rao(box(), speeds=5.0, omega=[0.5], loading=Loading.of(box(), GM=1.5)))
    assert "L 100 m, B 16 m, T 5 m (L/B 6.25, B/T 3.20)" in told
    assert "8000 m³, CB 1.000" in told
    assert "KM 6.77 m. GM 1.5 m." in told


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a,b\n1,2\n", "x,y,z"),
        ("x,y,z\n0,1,two\n0,1,nan\n", "2 problems"),
        ("x,y,z\n0,1,0\n0,1,9\n", "11 or more"),
        ("x,y,z\n" + "".join(f"{x},0,0\n{x},5,3\n" for x in X), "below the water"),
        ("x,y,z\n" + "".join(f"{x},0,1\n{x},5,0\n{x},5,9\n" for x in X), "goes down again"),
        ("x,y,z\n" + "".join(f"{x},-1,0\n{x},5,9\n" for x in X), "below zero"),
        ("x,y,z\n" + "".join(f"{x},3,0\n{x},0,4\n{x},0,9\n" for x in X), "closed below"),
    ],
)
def test_a_damaged_file_is_refused_with_its_place(tmp_path, text, says):
    (tmp_path / "hull.csv").write_text(text)
    with pytest.raises(DataError, match=says):
        read_hull(tmp_path / "hull.csv", draught=5.0, L=100.0)


def test_a_torn_file_of_shipx_says_where(tmp_path):
    (tmp_path / "torn.mgf").write_text("a\n\n\n\n100.0\n1\n-50.0\n3\n8.0 8.0\n")
    with pytest.raises(DataError, match=r"torn\.mgf, row"):
        read_hull(tmp_path / "torn.mgf", draught=5.0)


def test_a_csv_needs_its_length(tmp_path):
    (tmp_path / "hull.csv").write_text("x,y,z\n")
    with pytest.raises(DataError, match="Give L"):
        read_hull(tmp_path / "hull.csv", draught=5.0)


@pytest.mark.parametrize("name", [*hulls(), "kvlcc2", "s175"])
def test_every_hull_by_name_floats(name):
    hull = load_hull(name)
    assert hull.hydrostatics.volume > 0
    assert "not the ship's" in hull.notes[0]


def test_the_tanker_has_the_displacement_that_is_stated():
    """312 698.9 m³; CWL .886; the centre of gravity .534 L from the after perpendicular."""
    found = load_hull("tanker-320").hydrostatics
    assert found.volume == pytest.approx(312698.9, rel=2e-3)
    assert found.waterplane == pytest.approx(0.886 * 320 * 58, rel=5e-3)
    assert (found.xB + 160) / 320 == pytest.approx(0.534, abs=2e-3)


def test_particulars_in_a_file_are_checked(tmp_path):
    (tmp_path / "own.toml").write_text('name = "x"\nL = 100.0\nB = "wide"\nsheer = 2.0\n')
    with pytest.raises(DataError, match="lacks d") as caught:
        load_hull(tmp_path / "own.toml")
    assert "sheer is not known" in str(caught.value)
    assert "B must be a finite number" in str(caught.value)


def test_a_name_that_is_not_there_is_answered_with_those_there_are():
    with pytest.raises(UnknownNameError, match="tanker-320"):
        load_hull("tanker-321")


def test_a_hollow_section_with_flare_is_followed_by_a_smoother_map():
    """A skeg under a flare has corners that no unsmoothed map of few coefficients follows."""
    contour = Station(x=0.0, y=np.array([0, 1, 9.0]), z=np.array([0, 3, 5.5])).contour(5.0)
    found = fit_sections([contour], ["it"])
    assert found.notes == ()
    assert area(found.maps)[0] == pytest.approx(19.8, rel=0.01)
    assert is_conformal(found.maps[0])


def test_a_bulb_under_a_neck_is_a_lewis_form_of_its_area_and_the_note_says_so():
    y, z = np.array([0, 6, 1, 1.0]), np.array([0, 2, 5, 9.0])
    contour = Station(x=0.0, y=y, z=z).contour(6.0)
    found = fit_sections([contour], ["it"])
    assert area(found.maps)[0] == pytest.approx(-2 * np.trapezoid(contour.imag, contour.real))
    assert "necked above a bulb" in found.notes[0]


def as_offsets(file, across=1.0, along=1.0, up=0.0):
    """S175 as a table of offsets, in somebody's frame."""
    ship = load_hull("s175-design")
    rows = [
        f"{along * x},{across * point.imag},{up + 9.5 - point.real}"
        for x, contour in zip(ship.x, ship.contours, strict=True)
        for point in contour
    ]
    file.write_text("\n".join(["x,y,z", *rows]))
    return file


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"across": 2.0}, r"displace 49306 t, not 24653 t as stated\. Are these whole breadths"),
        ({"across": 1.1}, r"displace 27118 t, not 24653 t as stated\.$"),
        ({"along": -1.0}, r"lies 2\.63 m forward of midship, not -2\.63 m.*positive aft"),
    ],
)
def test_sections_that_contradict_the_loading_are_refused(given, says, tmp_path):
    hull = read_hull(as_offsets(tmp_path / "s175.csv", **given), draught=9.5, L=175.0)
    with pytest.raises(DataError, match=says):
        Loading.of(hull, mass=24653e3, xG=-2.63)


def test_heights_may_count_from_the_water(tmp_path):
    hull = read_hull(as_offsets(tmp_path / "s175.csv", up=-9.5), draught=9.5, L=175.0)
    assert hull.hydrostatics.volume == pytest.approx(24052, rel=1e-3)
    Loading.of(hull, mass=24653e3, xG=-2.63)


def test_what_is_wrong_with_every_station_is_said_once(tmp_path):
    with pytest.raises(DataError) as told:
        read_hull(as_offsets(tmp_path / "s175.csv", across=-1.0), draught=9.5, L=175.0)
    assert "41 stations, x = -86.625 to 86.625 m: half breadths lie below zero." in str(told.value)
    assert "problems" not in str(told.value)
