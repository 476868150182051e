"""Every ship of the library by every criterion of IMO MSC.137(76), and its spiral.

    python -m scripts.studies.imo_table [--markdown]

Model ships are carried to 320 m (KVLCC2) and 325 m (Esso Osaka) by Froude's law alone. The speeds
are those at which the sources tested or computed them.
"""

from __future__ import annotations

import argparse
import math

import pmmkit as pk
from pmmkit.imo import Verdict

SHIPS = {
    "s175": (11.3, None),
    "s175-3dof": (11.3, None),
    "kvlcc2": (7.97, None),
    "kvlcc2-l7": (7.97, 320.0),
    "kcs": (12.35, None),
    "mariner": (7.7175, None),
    "esso190k": (8.23, None),
    "esso-osaka-3m": (5.4, 325.0),
}
COLUMNS = {
    "advance": "advance ≤ 4.5 L",
    "tactical_diameter": "tactical diameter ≤ 5 L",
    "initial_turning": "initial turning ≤ 2.5 L",
    "first_overshoot_10_10": "10/10, first",
    "second_overshoot_10_10": "10/10, second",
    "first_overshoot_20_20": "20/20, first ≤ 25°",
    "track_reach": "stop ≤ 15 L",
}


def cell(found: list[Verdict]) -> str:
    """Starboard and port in one cell, with what is not met marked."""
    if not found or math.isnan(found[0].value):
        return "-"
    unit = "°" if found[0].unit == "deg" else ""
    marks = {True: "", False: " ✗", None: " ?"}
    texts = [f"{item.value:.2f}{unit}{marks[item.passed]}" for item in found]
    engine = found[0].full_astern
    if engine and engine.assumed:
        texts = [f"{text} ({engine.low:.1f} to {engine.high:.1f})" for text in texts]
    limit = f" (≤ {found[0].limit:.3g}°)" if "10_10" in found[0].criterion else ""
    return " / ".join(texts) + limit


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--markdown", action="store_true")
    options = parser.parse_args()
    rows, spirals = [], []
    for name, (speed, length) in SHIPS.items():
        model = pk.load_model(name)
        if length is not None:
            model = pk.scaled(model, length)
        found = pk.imo_verdicts(model, speed)
        rows.append(
            [f"{name}, {speed:g} m/s"]
            + [cell([item for item in found if item.criterion == key]) for key in COLUMNS]
        )
        linear, curve = pk.stability(model, speed), pk.spiral_curve(model, speed)
        spirals.append(
            [
                name,
                f"{linear.C:.2e}",
                ("stable" if linear.stable else "unstable")
                + ("" if linear.side == "both" else f" (to {linear.side})"),
                f"{curve.loop_width_deg:.2f}",
                f"{curve.loop_height_deg_s:.3f}",
                f"{curve.neutral_deg:+.2f}",
            ]
        )
    show(["ship", *COLUMNS.values()], rows, options.markdown)
    print()
    head = ["ship", "C", "straight line", "loop wide [°]", "loop high [°/s]", "rudder [°]"]
    show(head, spirals, options.markdown)


def show(head: list[str], rows: list[list[str]], markdown: bool) -> None:
    if markdown:
        print("| " + " | ".join(head) + " |")
        print("|" + "---|" * len(head))
        for row in rows:
            print("| " + " | ".join(row) + " |")
        return
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    for row in [head, *rows]:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)))


if __name__ == "__main__":
    main()
