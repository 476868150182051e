"""The tanker of 320 m: its turn, motions and added resistance as the pages quote them.

    python -m scripts.studies.tanker_in_waves

The preliminary design that it is from draws heave, pitch and added resistance at 180°, 135° and
45°, 15.5 knots and a significant height of 4 m, without numbers and without a period.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import pmmkit as pk
from pmmkit.seakeeping.figures import over_wave_length

IMAGE = Path(__file__).parents[2] / "docs" / "images" / "tanker_in_waves.png"
SPEED = 15.5 * 0.514444
HEADINGS = (180, 135, 45)


def main() -> None:
    for rudder in (35.0, -35.0):
        for name in ("tanker-320", "kvlcc2"):
            found = pk.simulate(name, rudder_deg=rudder, speed=SPEED, compiled=False).metrics
            lengths = (found[x] for x in ("advance_L", "tactical_diameter_L", "steady_diameter_L"))
            print(f"{name:12}{rudder:+4.0f}°", *(f"{x:7.2f}" for x in lengths))
    hull = pk.load_hull("tanker-320")
    ratio = np.geomspace(3.5, 0.25, 160)
    motions = pk.rao(
        hull,
        speeds=SPEED,
        headings_deg=HEADINGS,
        omega=np.sqrt(2 * np.pi * 9.81 / (ratio * hull.L)),
    )
    added = pk.added_resistance(motions)
    shown = [f"{heading}°" for heading in HEADINGS]
    heave, pitch = (np.abs(motions.mode(name)[0]) for name in ("heave", "pitch"))
    pushed = added.methods["with reflection"][0] / added.unit
    panels = {
        "heave / ζ": dict(zip(shown, heave, strict=True)),
        "pitch / kζ": dict(zip(shown, pitch / motions.wavenumber, strict=True)),
        "R / ρgζ²B²/L": dict(zip(shown, pushed, strict=True)),
    }
    over_wave_length(ratio, panels, longest=2.5).save(IMAGE)
    for heading, one, other, resistance in zip(shown, heave, pitch, pushed, strict=True):
        print(f"{heading:5} heave largest {one.max():.2f} at {ratio[one.argmax()]:.2f} L")
        print(f"      pitch/kζ largest {(other / motions.wavenumber).max():.2f}")
        print(f"      R largest {resistance.max():.1f} at {ratio[resistance.argmax()]:.2f} L")


if __name__ == "__main__":
    main()
