"""Two-strut mechanisms against geometry written out here and differentiated step by step."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from own_tank import HEAD, U, record, sway, write

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.campaigns import TEST_KINDS

B, OMEGA = 1.8, 2 * math.pi / 9.0
NAMES = ("u", "v", "r", "udot", "vdot", "rdot")


def by_hand(t, amplitude, phase, *, centre=0.0, slides="aft", turned=0.0, carriage=U):
    """u, v, r and their rates of midship of a hull on two struts, by differences.

    The pivot is a point of the hull; the other strut lies on the line of the struts. The model is
    turned on that line about the point midway.
    """
    forward = amplitude * np.sin(OMEGA * t + phase / 2)
    aft = amplitude * np.sin(OMEGA * t - phase / 2)
    line = np.arctan2(forward - aft, B)
    pivot = (0.5 * B, forward) if slides == "aft" else (-0.5 * B, aft)
    half = -0.5 * B if slides == "aft" else 0.5 * B
    midway = (pivot[0] + half * np.cos(line), pivot[1] + half * np.sin(line))
    psi = line + turned
    x = carriage * t + midway[0] - centre * np.cos(psi)
    y = midway[1] - centre * np.sin(psi)

    def rate(values):
        return np.gradient(values, t, edge_order=2)

    xdot, ydot = rate(x), rate(y)
    motion = {
        "u": xdot * np.cos(psi) + ydot * np.sin(psi),
        "v": -xdot * np.sin(psi) + ydot * np.cos(psi),
        "r": rate(psi),
    }
    motion |= {f"{name}dot": rate(values) for name, values in motion.items()}
    return {"forward": forward, "aft": aft, "psi": psi, **motion}


def opened(folder: Path, keys: str, head: str = f"[struts]\nspacing = {B}\n") -> pk.Campaign:
    """A campaign of one run whose record is of no matter."""
    write(folder, [sway(9.0, 0.3)], head=head)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text[: text.index("test = ")] + keys)
    return pk.open_campaign(folder)


def stated(test: str, amplitude: float, phase: float | None, more: str = "") -> str:
    lead = "" if phase is None else f"strut_phase_deg = {math.degrees(phase)}\n"
    return f'test = "{test}"\nperiod = 9.0\nstrut_amplitude_m = {amplitude}\n{lead}{more}'


def close(found, truth, inner=slice(4, -4)) -> None:
    for name in NAMES:
        size = max(np.abs(truth[name]).max(), 0.01)
        np.testing.assert_allclose(
            getattr(found, name)[inner], truth[name][inner], atol=2e-4 * size, err_msg=name
        )


OWN = 2 * math.atan(OMEGA * B / (2 * U))
T = np.arange(0.0, 18.0, 0.002)


@pytest.mark.parametrize(
    ("test", "phase", "more", "head"),
    [
        ("pure_sway", 0.0, "", ""),
        ("pure_sway", None, "", "centre_x = 0.3\n"),
        ("sway_yaw", 1.1, "", ""),
        ("sway_yaw", -0.6, "", 'centre_x = -0.4\nslides = "forward"\n'),
        ("sway_yaw", 2.9, "drift_deg = 6.0\n", "centre_x = 0.25\n"),
    ],
)
def test_the_motion_that_struts_are_set_to(test, phase, more, head, tmp_path):
    """Closed form against geometry and differences; θ is the mean phase of the struts."""
    setup = f"[struts]\nspacing = {B}\n{head}"
    campaign = opened(tmp_path / "c", stated(test, 0.3, phase, more), setup)
    options = dict(line.split(" = ") for line in head.splitlines())
    truth = by_hand(
        T, 0.3, phase or 0.0, centre=float(options.get("centre_x", 0.0)),
        slides=options.get("slides", '"aft"').strip('"'),
        turned=math.radians(6.0) if more else 0.0,
    )  # fmt: skip
    close(campaign.runs[0].nominal_motion(T), truth)


@pytest.mark.parametrize("slides", ["aft", "forward"])
def test_struts_of_pure_yaw_lead_by_twice_the_angle_of_their_way(slides, tmp_path):
    """ε = 2 atan(ωb/2U): the point midway goes where the hull points, so v stays near zero."""
    head = f'[struts]\nspacing = {B}\nslides = "{slides}"\n'
    campaign = opened(tmp_path / "c", stated("pure_yaw", 0.3, None), head)
    run = campaign.runs[0]
    truth = by_hand(T, 0.3, OWN, slides=slides)
    # The heading is ψ0 sin θ: the point midway, a quarter of a period behind, crosses zero there.
    quarter = 0.25 * 2 * math.pi / OMEGA
    found = run.motion_at_phase(OMEGA * (T + quarter))
    close(found, truth)
    assert np.abs(found.v).max() < 0.02 * U
    assert math.tan(run.settings.yaw_amplitude) == pytest.approx(run.settings.amplitude * OMEGA / U)
    assert run.settings.yaw_amplitude == pytest.approx(np.abs(truth["psi"]).max(), rel=1e-6)


@given(
    amplitude=st.floats(0.05, 0.6), phase=st.floats(-3.0, 3.0), centre=st.floats(-1.0, 1.0),
    aft=st.booleans(), turned=st.floats(-0.3, 0.3),
)  # fmt: skip
def test_rates_are_the_derivatives_of_what_they_are_rates_of(amplitude, phase, centre, aft, turned):
    from pmmkit.campaigns import Settings
    from pmmkit.campaigns.test_kinds.kind import Struts, swung

    struts = Struts(spacing=B, centre_x=centre, slides="aft" if aft else "forward")
    midway, heading = struts.swing(amplitude, phase)
    settings = Settings(
        speed=U, period=9.0, drift=turned, amplitude=midway, yaw_amplitude=heading,
        strut_spacing=struts.signed, strut_centre=struts.centre,
    )  # fmt: skip
    theta, step = np.linspace(0.0, 6.0, 7), 1e-4
    now, back, on = (swung(settings, theta + OMEGA * x, lags=False) for x in (0.0, -step, step))
    moved = {"x": ("xdot", U), "y": ("ydot", 0.0), "psi": ("r", 0.0)}
    for of, (rate, plus) in {
        **moved, "xdot": ("xddot", 0.0), "ydot": ("yddot", 0.0), "r": ("rdot", 0.0)
    }.items():  # fmt: skip
        slope = (on[of] - back[of]) / (2 * step)
        np.testing.assert_allclose(now[rate], slope + plus, atol=1e-6, err_msg=rate)
    back_again = struts.amplitude_and_phase(settings, lags=False)
    assert back_again == pytest.approx((amplitude, phase), abs=1e-9)


@pytest.mark.parametrize("slides", ["aft", "forward"])
@pytest.mark.parametrize(("test", "turned"), [("sway_yaw", 0.0), ("yaw_drift", 8.0)])
def test_recorded_struts_tell_the_motion(test, turned, slides, tmp_path):
    """Columns y_forward_m and y_aft_m: no amplitude, no phase has to be stated."""
    phase = OWN if turned else 0.9
    rest = math.radians(turned)
    head = f'[struts]\nspacing = {B}\ncentre_x = 0.2\nslides = "{slides}"\n'

    def struts(columns):
        moved = by_hand(columns["t"], 0.3, phase)
        return {"y_forward_m": moved["forward"], "y_aft_m": moved["aft"]}

    folder = write(tmp_path / "c", [sway(9.0, 0.3)], head=head, extra=struts)
    file = folder / "campaign.toml"
    text = file.read_text()
    drift = f"drift_deg = {turned}\n" if turned else ""
    file.write_text(text[: text.index("test = ")] + f'test = "{test}"\nperiod = 9.0\n{drift}')
    run = pk.open_campaign(folder).runs[0]
    data = run.data
    assert {"x", "y", "psi"} <= set(data)
    assert not {"y_forward", "y_aft"} & set(data)
    assert "two struts 1.8 m apart" in data.attrs["conversions"]
    t = data["t"].values
    fine = np.arange(t[0] - 0.01, t[-1] + 0.01, 0.001)
    truth = by_hand(fine, 0.3, phase, centre=0.2, slides=slides, turned=rest)
    at = {name: np.interp(t, fine, values) for name, values in truth.items()}
    close(run.measured_motion(data, t), at)


def test_a_drift_that_the_struts_hold_is_not_counted_twice(tmp_path):
    offset = B * math.tan(math.radians(8.0))

    def struts(columns):
        still = 0.0 * columns["t"]
        return {"y_forward": still + offset / 2, "y_aft": still - offset / 2}

    folder = write(
        tmp_path / "c", [sway(9.0, 0.3)], head=f"[struts]\nspacing = {B}\n", extra=struts
    )
    file = folder / "campaign.toml"
    text = file.read_text()
    file.write_text(text[: text.index("test = ")] + 'test = "static_drift"\ndrift_deg = 8.0\n')
    data = pk.open_campaign(folder).runs[0].data
    np.testing.assert_allclose(data["psi"].values, math.radians(8.0))


@pytest.mark.parametrize("axes", ['y = "-y"\nz = "-z"', 'x = "-x"\nz = "-z"'])
def test_axes_that_point_the_other_way_turn_the_struts(axes, tmp_path):
    """Their y to port, or their x aft: forward is forward, and y is the y of their axes."""
    head = f"[struts]\nspacing = {B}\n[axes]\n{axes}\n"
    run = opened(tmp_path / "c", stated("sway_yaw", 0.3, 0.9), head).runs[0]
    truth = by_hand(T, -0.3 if 'y = "-y"' in axes else 0.3, 0.9)
    close(run.nominal_motion(T), truth)


@pytest.mark.parametrize(
    ("keys", "head", "words"),
    [
        (stated("pure_sway", 0.3, 0.0), "", "[struts] spacing"),
        (stated("pure_sway", 0.3, 0.2), None, "strut_phase_deg = 0"),
        (stated("pure_yaw", 0.3, 0.2), None, f"strut_phase_deg = {math.degrees(OWN):.4g}"),
        (stated("sway_yaw", 0.3, None), None, "the lead of the forward strut, strut_phase_deg"),
        ('test = "pure_yaw"\nperiod = 9.0\nstrut_phase_deg = 20.0\n', None, "yaw_amplitude_deg"),
        (stated("static_drift", 0.3, None, "drift_deg = 2.0"), None, "is not made by two struts"),
        (stated("pure_sway", 0.3, 0.0), "[struts]\nspacing = -1.0\n", "greater than 0"),
        (stated("pure_sway", 0.3, 0.0), "[struts]\nspace = 1.0\n", "did you mean 'spacing'"),
    ],
)
def test_what_struts_cannot_do_is_refused_with_what_they_can(keys, head, words, tmp_path):
    with pytest.raises(CampaignError) as caught:
        opened(tmp_path / "c", keys, f"[struts]\nspacing = {B}\n" if head is None else head)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "head", "words"),
    [
        (("y_forward",), f"[struts]\nspacing = {B}\n", "y_forward is there without y_aft"),
        (("y_forward", "y_aft"), "", "need the distance of the struts"),
    ],
)
def test_half_a_mechanism_is_refused(columns, head, words, tmp_path):
    write(
        tmp_path / "c", [sway(9.0, 0.3)], head=head,
        extra=lambda found: dict.fromkeys(columns, found["y"]),
    )  # fmt: skip
    with pytest.raises(CampaignError, match=words):
        _ = pk.open_campaign(tmp_path / "c").runs[0].data


def test_struts_survive_being_saved_and_exported(tmp_path):
    campaign = opened(tmp_path / "c", stated("sway_yaw", 0.3, 0.9), f"[struts]\nspacing = {B}\n")
    pk.save_campaign(campaign, tmp_path / "all.h5")
    pk.export(campaign, tmp_path / "csv", to="csv")
    for again in (pk.open_campaign(tmp_path / "all.h5"), pk.open_campaign(tmp_path / "csv")):
        one, other = (item.runs[0].nominal_motion(T) for item in (campaign, again))
        for name in NAMES:
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=1e-12)


def test_the_hull_is_where_its_struts_put_it(tmp_path):
    """The place from rest, which forces in earth axes need."""
    run = opened(tmp_path / "c", stated("sway_yaw", 0.3, 0.9)).runs[0]
    place = TEST_KINDS["sway_yaw"].place(run.settings, OMEGA * T)
    forward = 0.3 * np.sin(OMEGA * T + 0.45)
    psi = np.arctan2(forward - 0.3 * np.sin(OMEGA * T - 0.45), B)
    np.testing.assert_allclose(place[0], 0.5 * B * (1 - np.cos(psi)), atol=1e-12)
    np.testing.assert_allclose(place[1], forward - 0.5 * B * np.sin(psi), atol=1e-12)


def test_the_example_of_the_documentation_is_read_as_it_says(tmp_path):
    """docs/formats.md: a carriage's recorder, gauges that drift, struts recorded and set."""
    page = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    example = page.split("### Carriage and struts", 1)[1].split("```toml\n", 1)[1].split("```")[0]
    (tmp_path / "campaign.toml").write_text(f"{HEAD}\n{example}", encoding="utf-8")
    found = record(sway(9.0, 0.25), rest=3.0, ramp=4.0, together=True)
    moved = by_hand(found["t"], 0.3, OWN)
    dice = np.random.default_rng(0)
    rows = [found["t"], *(found[x] + 0.2 * dice.normal(size=found["t"].size) + 1.0 for x in "XYN")]
    rows.append(found["U_carriage"])
    names = ["t", "X", "Y", "N", "Wagengeschwindigkeit [m/s]"]
    for name, more in (
        ("ps1", {}),
        ("py1", {"Strut 1": 1e3 * moved["forward"], "Strut 2": 1e3 * moved["aft"]}),
    ):
        np.savetxt(
            tmp_path / f"{name}.txt", np.column_stack([*rows, *more.values()]), delimiter=";",
            header=";".join([*names, *more]), comments="", fmt="%.6f",
        )  # fmt: skip
    campaign = pk.open_campaign(tmp_path)
    for run in campaign:
        assert "tared" in run.data.attrs
        assert "U_carriage" in run.data
    assert campaign["PS1"].settings.amplitude == 0.25
    late = campaign["PY1"].data.isel(t=slice(200, None))
    heading = np.degrees(np.abs(late["psi"].values).max())
    assert heading == pytest.approx(math.degrees(math.atan(0.6 * math.sin(OWN / 2) / B)), rel=1e-3)
    assert np.abs(campaign["PY1"].measured_motion(late, late["t"].values).v).max() < 0.05
