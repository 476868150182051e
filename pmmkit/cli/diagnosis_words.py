"""A diagnosis in sentences."""

from __future__ import annotations

import math

from pmmkit.diagnosis.findings import UNITS, Diagnosis, Finding
from pmmkit.report.loop import VERDICTS


def words(found: Diagnosis) -> list[str]:
    """A diagnosis in sentences.

    Parameters
    ----------
    found : Diagnosis
        As `diagnose` gives it.
    """
    lines = [
        f"What is smooth and below {100 * found.floor:g} % of a channel's rms force is left alone.",
        f"Verdict: {VERDICTS[found.verdict]}",
    ]
    if found.given:
        lines.append(f"The base has already: {', '.join(found.given)}.")
    if found.findings:
        lines.append(f"Family: {', '.join(found.families)}.")
    for item in found.findings:
        lines += ["", *_finding(item)]
    if found.flags and found.findings:
        lines += [
            "",
            "It is not the whole story: something is left that no named effect explains. "
            "Take it as the nearest relative.",
        ]
    lines += [f"  {reason}" for reason in found.flags[1:]]
    rivals = found.group[1:]
    if rivals:
        lines += ["", "These runs cannot tell it from:"]
        lines += [f"  {' and '.join(names)} ({_against(odds)})" for names, odds in rivals]
    hidden = found.not_testable
    if hidden:
        lines += ["", "These runs could not show:"]
        lines += [f"  {item.name}: {item.why}{_hides(item.hides)}" for item in hidden]
    return lines


def _finding(item: Finding) -> list[str]:
    """One effect: evidence, sizes, how the error of left-out conditions falls."""
    lines = [f"{item.effect}: {item.summary} Evidence {item.evidence}."]
    for name, value in item.coefficients.items():
        lines.append(f"  {_size(name, value, item.std[name], item.typical[name])}")
    if item.parameter:
        lines.append(f"  {item.parameter}: about {item.value:g}")
    if math.isfinite(item.error_before):
        falls = [
            f"{name} {before:.3g} to {after:.3g} {UNITS[name]}"
            for name, (before, after) in item.errors.items()
            if name in item.channels
        ]
        shares = (
            f" {100 * item.error_before:.2f} % to {100 * item.error_after:.2f} % of the rms forces"
            if "heading" not in item.errors
            else ""
        )
        how = f" ({', '.join(falls)})." if shares and falls else f" {', '.join(falls)}."
        lines.append(
            f"  Error of what was left out:{shares}{how if falls else ' it does not fall.'}"
        )
    if item.rivals:
        lines.append(f"  On such runs it resembles: {', '.join(item.rivals)}.")
    if item.separating_test:
        lines.append(f"  To be sure: {item.separating_test}.")
    return lines


def _size(name: str, value: float, std: float, typical: float) -> str:
    """A coefficient with its uncertainty beside its usual size; a warning where it is far off."""
    text = f"{name} {value:.3g} ± {1.96 * std:.2g}, usual size {typical:.2g}"
    if abs(value) - 1.96 * std > _LARGE * abs(typical):
        text += " - far more than usual"
    elif abs(value) > 1.96 * std and value * typical < 0.0 and "[" not in name:
        text += " - of the other sign than usual"
    return text


_LARGE = 3.0


def _against(odds: float) -> str:
    return f"about {1.0 / odds:.0f} to 1 against it" if odds < 0.7 else "as likely"


def _hides(share: float) -> str:
    return f"; up to {share:.2g} of its usual size could hide" if math.isfinite(share) else ""
