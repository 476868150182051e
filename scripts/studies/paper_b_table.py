"""Linear derivatives of a 280 000 dwt tanker by four formulas, against a printed table.

    python -m scripts.studies.paper_b_table

The table (11.1; L 320 m, B 58 m, T 20.8 m, CB 0.81) is printed in a text on empirical estimates and
seakeeping of a tanker. Where it disagrees with the published formulas, the reason that
reproduces it is named. Its stability column measures the centre of gravity from the after
perpendicular (x' = 0.534) where the criterion needs it from midship (0.034).
"""

from __future__ import annotations

from pmmkit.conventions import Ship
from pmmkit.models import estimate
from pmmkit.models.empirical import criterion

TANKER = Ship(
    name="280 000 dwt tanker", L=320.0, B=58.0, d=20.8, volume=0.81 * 320.0 * 58.0 * 20.8,
    mass=1025.0 * 0.81 * 320.0 * 58.0 * 20.8, Izz=2.0e12,
)  # fmt: skip
MASS = 2 * TANKER.volume / TANKER.L**3
PRINTED = {
    "wagner-smitt": {"Yv": -0.0211, "Yr": 0.00425, "Nv": -0.00823, "Nr": -0.00279},
    "norrbin": {"Yv": -0.0232, "Yr": 0.00497, "Nv": -0.00846, "Nr": -0.00454},
    "inoue": {"Yv": -0.02663, "Yr": 0.00664, "Nv": -0.00845, "Nr": -0.0033},
    "clarke": {"Yv": -0.02527, "Yr": 0.00416, "Nv": -0.00871, "Nr": -0.00209},
}
REASONS = {
    ("norrbin", "Yr"): "not reproduced",
    ("norrbin", "Nv"): "0.04 T/L in place of 0.04 CB B/(πT)",
    ("norrbin", "Nr"): "not reproduced",
    ("clarke", "Yr"): "not reproduced (3 %)",
    ("clarke", "Nr"): "0.15 in place of 1/4 (eq. 11.31)",
}


def main() -> None:
    print("method        derivative   formula    printed   remark")
    for method, printed in PRINTED.items():
        values = estimate(TANKER, method).values
        for name, theirs in printed.items():
            off = abs(values[name] / theirs - 1)
            remark = REASONS.get((method, name), "" if off < 0.006 else "?")
            print(f"{method:14}{name:10}{values[name]:10.5f} {theirs:10.5f}   {remark}")
    print("\nStability: lever of yaw > lever of sway   at xG' 0.034        at xG' 0.534 (printed)")
    for method in PRINTED:
        values = estimate(TANKER, method).values
        yaw, sway = criterion(values, MASS, 0.034)
        wrong, _ = criterion(values, MASS, 0.534)
        verdict = "stable" if yaw > 1.01 * sway else "neutral" if yaw > 0.99 * sway else "unstable"
        print(f"{method:14}{yaw:24.4f} {sway:8.4f} {verdict:10}{wrong:14.4f}")


if __name__ == "__main__":
    main()
