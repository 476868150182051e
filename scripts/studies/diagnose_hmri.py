"""HMRI's captive tests of the KVLCC2: what do a linear and a cubic model lack?

    python -m scripts.studies.diagnose_hmri [--data FOLDER] [--out FOLDER] [--noise 0.03] \
        [--floor 0.02]

The tables state no noise. The default is what the means of static runs scatter about the largest
model (3 % of the rms force, estimated by the diagnosis itself), taken for the harmonics too; what
is smooth and below 2 % is left alone. Effects are added as they are named until nothing is. Prints
the steps with the error of conditions that were left out, in newtons and by test type; writes a
figure per base. The measurements are not part of the repository: --data or PMMKIT_DATA.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import pmmkit as pk
from pmmkit.diagnosis import Diagnosis, Session, begin
from pmmkit.presentation import WIDE

ROOT = Path(__file__).parents[2]
MOST = 6
"""Rounds of naming and adding at most."""


def followed(session: Session[Diagnosis]) -> tuple[Session[Diagnosis], list[str]]:
    """Add what is named until nothing is; the verdicts on the way."""
    said = []
    for _ in range(MOST):
        found = session.diagnose()
        rivals = [" + ".join(names) for names, _ in found.group[1:]]
        flags = f" ({', '.join(found.flags)})" if found.flags else ""
        instead = f"; cannot be told from {' | '.join(rivals)}" if rivals else ""
        said.append(f"{found.verdict}: {' + '.join(found.best) or '-'}{flags}{instead}")
        if found.verdict != "missing_effect":
            break
        for item in found.findings:
            values = ", ".join(
                f"{name} {value:.3g} ± {WIDE * item.std[name]:.1g} (usual {item.typical[name]:.2g})"
                for name, value in item.coefficients.items()
            )
            said.append(f"  {item.effect}, {item.evidence}: {values}")
            session = session.add(item)
    return session, said


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    shared = ROOT.parent / "shared" / "data"
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("PMMKIT_DATA", shared)))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--noise", type=float, default=0.03)
    parser.add_argument("--floor", type=float, default=0.02)
    o = parser.parse_args()
    campaign = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hmri", data=o.data)
    for base in ("linear", "cubic"):
        session = begin(base, campaign, noise=o.noise, floor=o.floor)
        scatter = session.evidence.system.scatter
        session, said = followed(session)
        print(f"\n## Base {base}: run scatter {100 * scatter.offset:g} % of the rms force")
        print("\n".join(said))
        fall = session.fall()
        tests = fall.groups()
        print(
            "\n| | all [%] | X [N] | Y [N] | N [N m] | "
            + " | ".join(f"{name.replace('_', ' ')} [%]" for name in tests)
            + " |"
        )
        print("|---|" + "---|" * (4 + len(tests)))
        for number, step in enumerate(fall.steps):
            cells = [
                f"{fall.totals[number]:.2f}",
                *(f"{fall.errors(name)[number]:.2f}" for name in "XYN"),
                *(f"{fall.errors(fall.of, group=test)[number]:.1f}" for test in tests),
            ]
            print(f"| {'+ ' if number else ''}{step} | " + " | ".join(cells) + " |")
        print("does not lower it:", ", ".join(fall.useless) or "none")
        if o.out is not None:
            o.out.mkdir(parents=True, exist_ok=True)
            fall.plot().save(o.out / f"hmri_{base}.png")


if __name__ == "__main__":
    main()
