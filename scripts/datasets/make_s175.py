"""Make datasets/s175: the histories of the synthetic S175 programme and its campaign file.

    python -m scripts.datasets.make_s175

The same seed gives the same file to the byte.
"""

from __future__ import annotations

from scripts.datasets.s175_programme import SPEEDS, UNCERTAINTY, Plan, campaign, programme
from scripts.datasets.s175_truth import load_truth
from scripts.datasets.virtual_tank import SHIP, WATER

from pmmkit.campaigns import save_campaign
from pmmkit.files import datasets_folder, write_text

SEED = 1

HEAD = f"""\
# The S175 container ship at 1:36, a PMM programme at {", ".join(map(str, SPEEDS))} m/s.
#
# SYNTHETIC. The histories in runs.h5 were made by scripts/datasets/make_s175.py (seed {SEED}) from the
# derivatives in truth.toml: Son and Nomoto's at the lowest speed, changing with Fn². They hold
# noise, one draw of the errors stated under [uncertainty], and start-up transients.
# Bare hull: no propeller, no rudder. Forces are those of the water on the hull.

[campaign]
title = "S175 at 1:36, synthetic PMM programme"
kind = "captive"
forces = "hydrodynamic"
rudder_positive = "starboard"
drift_positive = "starboard-bow"
free = ["heave", "pitch"]

[ship]
name = "S175 model"
L = {SHIP.L}
B = {SHIP.B}
d = {SHIP.d}
mass = {SHIP.mass}
xG = {SHIP.xG}
Izz = {SHIP.Izz}
volume = {SHIP.volume}

[water]
rho = {WATER.rho}
g = {WATER.g}

[source]
format = "pmmkit"

[uncertainty]
X_gauge = {{ std = 0.04, unit = "N", shared = true }}
Y_gauge = [
    {{ std = 0.15, unit = "N", shared = true }},
    {{ std = 0.2, unit = "%", shared = true }},
]
N_gauge = [
    {{ std = 0.25, unit = "N m", shared = true }},
    {{ std = 0.2, unit = "%", shared = true }},
]
drift_deg = [{{ std = 0.03, shared = true }}, {{ std = 0.02 }}]
speed = 0.001
"""


def entry(plan: Plan) -> str:
    """One [[runs]] of the campaign file."""
    lines = [
        "[[runs]]",
        f'id = "{plan.id}"',
        f'test = "{plan.test}"',
        'file = "runs.h5"',
        f"speed = {plan.speed}",
    ]
    if plan.test in ("static_drift", "yaw_drift"):
        lines.append(f"drift_deg = {plan.drift_deg}")
    if plan.period is not None:
        lines.append(f"period = {plan.period}")
    if plan.amplitude_m is not None:
        lines.append(f"amplitude_m = {plan.amplitude_m}")
    if plan.yaw_amplitude_deg is not None:
        lines.append(f"yaw_amplitude_deg = {plan.yaw_amplitude_deg}")
    return "\n".join(lines)


def main() -> None:
    folder = datasets_folder() / "s175"
    made = campaign(load_truth(), SEED)
    save_campaign(made, folder / "runs.h5")
    entries = "\n\n".join(entry(plan) for plan in programme())
    write_text(folder / "campaign.toml", f"{HEAD}\n{entries}\n")
    size = (folder / "runs.h5").stat().st_size / 1e6
    print(f"{len(made)} runs, {size:.2f} MB, {len(UNCERTAINTY)} stated uncertainties -> {folder}")


if __name__ == "__main__":
    main()
