"""Recorded motions against positions, against the settings, and stated amplitudes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.expected import round_factor
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, name_runs
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

AGREES: Final = 0.02
TURNS: Final = 0.5 * math.pi
"""Range of headings from which a record tells a current from a gain."""
ALIKE: Final = 0.5
"""Share of a current by which it may differ between records."""
DIFFERS: Final = 0.10
LAG_GAIN: Final = 0.85
LENGTH: Final = 0.002


def examine_velocities(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Velocity columns against differentiated positions and headings, in ship and earth axes."""
    compared = [item for item in summaries if item.facts.get("speed")]
    earth = [
        item
        for item in compared
        if "body" in item.facts
        and item.facts["earth"] < 0.3 * item.facts["body"]
        and item.facts["body"] > AGREES * item.facts["speed"]
    ]
    if earth:
        worst = max(earth, key=lambda item: item.facts["body"] / item.facts["speed"])
        yield CheckFinding(
            check="velocities",
            severity="error",
            message=f"The columns u and v are the velocities in earth axes in {len(earth)} runs: "
            f"in {worst.run.id} they differ from dx/dt, dy/dt by "
            f"{figure(worst.facts['earth'])} m/s (rms), but from the velocities in ship axes by "
            f"{figure(worst.facts['body'])} m/s.",
            runs=tuple(item.run.id for item in earth),
            remedy="Call these columns xdot and ydot under [columns].",
            numbers={"earth": worst.facts["earth"], "body": worst.facts["body"]},
        )
    turned = [
        item
        for item in compared
        if item.facts.get("dot_body", math.inf) < 0.3 * item.facts.get("dot_earth", 0.0)
    ]
    if turned:
        item = turned[0]
        yield CheckFinding(
            check="velocities",
            severity="error",
            message=f"The columns xdot and ydot are velocities in ship axes: in {item.run.id} "
            f"they differ from those by {figure(item.facts['dot_body'])} m/s (rms), from dx/dt "
            f"and dy/dt by {figure(item.facts['dot_earth'])} m/s.",
            runs=tuple(item.run.id for item in turned),
            remedy="Call these columns u and v under [columns].",
            numbers={"earth": item.facts["dot_earth"], "body": item.facts["dot_body"]},
        )
    rest = [item for item in compared if "body" in item.facts and item not in earth]
    flow = _flow(rest)
    still = rest if flow is None else [item for item in rest if item.run.id not in flow.runs]
    if flow is not None:
        yield flow
    yield from _late(still)
    yield from _apart(still)
    yield from _jumps([item for item in summaries if item not in earth])
    for name, of in (("r", "psi"), ("udot", "u"), ("vdot", "v"), ("rdot", "r")):
        yield from _rates(summaries, name, of)


def _flow(items: Sequence[Summary]) -> CheckFinding | None:
    """Velocities through water that moves: one and the same vector between columns and positions.

    Only a record that turns tells a current from a gain of the columns.
    """
    apart = [
        item
        for item in items
        if item.facts["body"] > AGREES * item.facts["speed"]
        and item.facts["flown"] <= max(AGREES * item.facts["speed"], 0.3 * item.facts["body"])
    ]
    turned = [item for item in apart if item.facts["swung"] > TURNS]
    if not turned:
        return None
    vectors = np.array([[item.facts["flow_x"], item.facts["flow_y"]] for item in apart])
    ways = np.array([[item.facts["flow_x"], item.facts["flow_y"]] for item in turned])
    mean = ways.mean(axis=0)
    speed = math.hypot(*mean)
    if float(np.hypot(*(vectors - mean).T).max()) > ALIKE * speed:
        return None
    towards = math.degrees(math.atan2(mean[1], mean[0])) % 360.0
    return CheckFinding(
        check="velocities",
        severity="info",
        message=f"The columns u and v are velocities through the water: the positions go "
        f"{figure(speed, 2)} m/s towards {towards:.0f}° (from x to y) besides, the same in "
        f"{len(apart)} of {len(items)} runs.",
        runs=tuple(item.run.id for item in apart),
        remedy="Give the model this current, or let the diagnosis find it.",
        numbers={"x": float(mean[0]), "y": float(mean[1])},
    )


def _late(items: Sequence[Summary]) -> Iterator[CheckFinding]:
    late = [
        item
        for item in items
        if item.facts["lagged"] < LAG_GAIN * item.facts["body"]
        and abs(item.facts["lag"]) > 2 * item.facts.get("step", 0.0)
        and item.facts["body"] > 0.005 * item.facts["speed"]
    ]
    if late:
        lags = np.array([item.facts["lag"] for item in late])
        middle = float(np.median(lags))
        before, after = (
            float(np.median([item.facts[key] for item in late])) for key in ("body", "lagged")
        )
        yield CheckFinding(
            check="velocities",
            severity="warning",
            message=f"The velocity columns are {'late' if middle > 0 else 'early'} by "
            f"{figure(abs(middle), 2)} s against the differentiated positions in {len(late)} "
            f"of {len(items)} runs ({figure(float(lags.min()), 2)} to "
            f"{figure(float(lags.max()), 2)} s, 0 expected); allowing for it the rms difference "
            f"falls from {figure(before)} to {figure(after)} m/s.",
            runs=tuple(item.run.id for item in late),
            remedy="Shift the columns, or take the velocities from the positions.",
            numbers={"lag": middle, "before": before, "after": after},
        )


def _apart(items: Sequence[Summary]) -> Iterator[CheckFinding]:
    apart = [item for item in items if _left(item) > AGREES * item.facts["speed"]]
    if apart:
        worst = max(apart, key=lambda item: _left(item) / item.facts["speed"])
        share, scale = _left(worst) / worst.facts["speed"], worst.facts["scale"]
        factor = round_factor(scale, spread=1.05) if abs(scale - 1) > 0.2 else None
        yield CheckFinding(
            check="velocities",
            severity="error" if share > 3 * DIFFERS else "warning",
            message=f"The velocity columns differ from the differentiated positions by up to "
            f"{100 * share:.0f} % of the speed ({worst.run.id}: {figure(_left(worst))} m/s rms of "
            f"{figure(worst.facts['speed'])} m/s; columns over positions {figure(scale)}"
            + (f", near {factor}" if factor else "")
            + ").",
            runs=tuple(item.run.id for item in apart),
            remedy="Look at the units and axes of x, y, psi, u and v, and for jumps in x and y.",
            numbers={"difference": _left(worst), "share": share, "scale": scale},
        )


def _left(item: Summary) -> float:
    return float(np.nanmin([item.facts["body"], item.facts["lagged"]]))


def _jumps(items: Sequence[Summary]) -> Iterator[CheckFinding]:
    torn = [item for item in items if item.facts.get("jumps", 0)]
    if torn:
        worst = max(torn, key=lambda item: item.facts["jump"])
        yield CheckFinding(
            check="velocities",
            severity="warning",
            message=f"The position jumps in {name_runs([item.run.id for item in torn])}: by up to "
            f"{figure(worst.facts['jump'], 2)} m in one sample beyond what the velocity explains "
            f"({worst.run.id}, {worst.facts['jumps']:.0f} jumps).",
            runs=tuple(item.run.id for item in torn),
            remedy="Use the segments between the jumps, or trim the record there.",
            numbers={"jump": worst.facts["jump"], "jumps": worst.facts["jumps"]},
        )


def _rates(summaries: Sequence[Summary], name: str, of: str) -> Iterator[CheckFinding]:
    items = [item for item in summaries if math.isfinite(item.facts.get(f"{name}_slope", math.nan))]
    wrong = [item for item in items if abs(item.facts[f"{name}_slope"] - 1) > AGREES]
    if wrong:
        slopes = np.array([item.facts[f"{name}_slope"] for item in wrong])
        middle = float(np.median(slopes))
        severe = abs(middle - 1) > DIFFERS
        factor = round_factor(middle, spread=1.05) if severe else None
        sign = " It has the opposite sign." if middle < 0 else ""
        yield CheckFinding(
            check="velocities",
            severity="error" if severe else "warning",
            message=f"{name} is {figure(middle, 4)} times the rate of change of {of} in "
            f"{len(wrong)} of {len(items)} runs (1 expected).{sign}"
            + (f" That is near {factor}." if factor and middle > 0 else ""),
            runs=tuple(item.run.id for item in wrong),
            remedy=f"State the units and signs of {name} and {of} under [columns] and [axes].",
            numbers={"slope": middle, "runs": float(len(wrong))},
        )


def examine_settings(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Recorded motions against what the campaign file says the test was set to."""
    for motion in ("v", "r"):
        pairs = [
            (item, item.c(motion, 1) / item.c(f"nominal_{motion}", 1))
            for item in summaries
            if (leading := item.run.kind_of_test.leading) is not None
            and leading.velocity == motion
            and item.c(f"nominal_{motion}", 1)
        ]
        off = [(item, ratio) for item, ratio in pairs if abs(ratio - 1) > AGREES]
        if off:
            ratios = np.array([ratio for _, ratio in off])
            middle = float(np.median(ratios))
            severe = abs(middle - 1) > DIFFERS
            factor = round_factor(middle, spread=1.08) if severe else None
            yield CheckFinding(
                check="settings",
                severity="error" if severe else "warning",
                message=f"The recorded {motion} oscillates with {figure(middle)} times the "
                f"amplitude that period and amplitude in the campaign file give in {len(off)} of "
                f"{len(pairs)} runs (1 expected)"
                + (f"; near {factor}." if factor and middle > 0 else "."),
                runs=tuple(item.run.id for item, _ in off),
                remedy="Correct the period or amplitude of the runs, or the unit of the column.",
                numbers={"ratio": middle},
            )
    yield from _headings(summaries)


def _headings(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    off = []
    for item in summaries:
        facts, settings = item.facts, item.run.settings
        if item.run.test != "static_drift" or not {"u_mean", "v_mean"} <= set(facts):
            continue
        found = math.atan2(-facts["v_mean"], facts["u_mean"])
        speed = math.hypot(facts["u_mean"], facts["v_mean"])
        if (
            abs(found - settings.drift) > math.radians(0.5)
            or abs(speed / settings.speed - 1) > 0.02
        ):
            off.append((item, found, speed))
    if off:
        item, found, speed = max(off, key=lambda entry: abs(entry[1] - entry[0].run.settings.drift))
        settings = item.run.settings
        straight = abs(found) < math.radians(0.3) and abs(speed / settings.speed - 1) < 0.02
        yield CheckFinding(
            check="settings",
            severity="error",
            message=f"In {len(off)} static runs the recorded u and v do not give the speed and "
            f"drift of the campaign file: in {item.run.id} they give {figure(speed, 4)} m/s and "
            f"{math.degrees(found):.2f}°, stated are {figure(settings.speed, 4)} m/s and "
            f"{math.degrees(settings.drift):.2f}°."
            + (" They look like velocities along and across the tank." if straight else ""),
            runs=tuple(entry[0].run.id for entry in off),
            remedy="Correct drift_deg or drift_positive, or the units and axes of the columns.",
            numbers={"drift_deg": math.degrees(found), "speed": speed},
        )


def examine_length(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """The length of the model that the stated amplitudes imply, against the stated length.

    Where a source states r' = r L/U and ṙ' = ṙ L²/U² of a harmonic motion together with its
    frequency, ṙ'/r' = ωL/U gives L. Of sway, v̇' = a ω² L/U² gives L once the amplitude is known; a
    crank that stays at one radius for all frequencies shows in a constant a.
    """
    lengths, ids = [], []
    for item in summaries:
        stated, settings = item.run.stated, item.run.settings
        omega = settings.omega
        if omega and {"r_amplitude", "rdot_amplitude"} <= set(stated) and stated["r_amplitude"]:
            ratio = abs(stated["rdot_amplitude"] / stated["r_amplitude"])
            lengths.append(ratio * settings.speed / omega)
            ids.append(item.run.id)
    if not lengths:
        return
    found: Array = np.array(lengths)
    length = float(np.median(found))
    std = 1.4826 * float(np.median(np.abs(found - length))) / math.sqrt(len(found)) * 1.25
    own = campaign.ship.L
    if abs(length / own - 1) <= max(LENGTH, 3 * std / own):
        return
    block = campaign.ship.volume / (length * campaign.ship.B * campaign.ship.d)
    extra = ""
    if campaign.ship.block_stated is not None:
        extra = (
            f" With it the block coefficient is {block:.4f}, stated "
            f"{campaign.ship.block_stated:.4f} (with {own:.4f} m it is {campaign.ship.block:.4f})."
        )
    crank = _crank(summaries, length)
    if crank is not None:
        extra += (
            f" The sway amplitudes then come to {crank[0]:.4f} m in all runs, within "
            f"{figure(crank[1], 2)} m."
        )
    yield CheckFinding(
        check="length",
        severity="error",
        message=f"The stated amplitudes of r' and ṙ' with the frequencies of {len(found)} runs "
        f"give a length of {length:.4f} ± {figure(WIDE * max(std, 1e-4), 2)} m "
        f"({float(found.min()):.4f} to {float(found.max()):.4f}), but the campaign file says "
        f"L = {own:.4f} m.{extra}",
        runs=tuple(ids),
        remedy=f"Check L; if {length:.3f} m made the numbers non-dimensional, it is the length "
        f"to state.",
        numbers={"length": length, "std": std, "stated": own, "block": block},
    )


def _crank(summaries: Sequence[Summary], length: float) -> tuple[float, float] | None:
    """Mean and spread of the sway amplitudes that v̇' and the frequency give with a length."""
    found = [
        abs(item.run.stated["vdot_amplitude"])
        * item.run.settings.speed**2
        / (length * item.run.settings.omega**2)
        for item in summaries
        if item.run.settings.omega and "vdot_amplitude" in item.run.stated
    ]
    return (float(np.mean(found)), float(np.ptp(found)) / 2) if found else None


CHECKS = (
    Check("velocities", "velocity columns against differentiated positions", examine_velocities),
    Check("settings", "recorded motions against what the runs were set to", examine_settings),
    Check("length", "the length that stated amplitudes and frequencies imply", examine_length),
)
