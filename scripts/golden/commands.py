"""Every command, on every data set that it takes."""

from __future__ import annotations

from functools import partial

from scripts.golden.job import Job
from scripts.golden.typed import typed

S175 = "datasets/s175"
REDUCED = f"reduce {S175} --json --out reduced"
LINES: dict[str, tuple[str, ...]] = {
    "lists": ("--help", "effects --json", "ships --json", "--no-such-option", "simulat s175"),
    "effects": ("effects flow_straightening", "effects fault_time_lag --json"),
    "s175_check": (f"check {S175} --json --out checked", f"inspect {S175} --json"),
    "s175_each": (
        REDUCED,
        "simulate reduced/model.toml --speed 1.5 --json --no-figures --out turn",
        f"compare reduced/model.toml {S175} --json --no-figures --out beside",
        "convert reduced/derivatives.csv --system bis --json --out bis",
        "export reduced/derivatives.csv --to latex -o table.tex",
        "export reduced/derivatives.csv --to excel -o table.xlsx",
    ),
    "s175_pooled": (
        f"reduce {S175} --fn pooled --structure cubic --json --out pooled",
        f"diagnose cubic {S175} --no-figures --json --out asked",
    ),
    "s175_modulus": (f"reduce {S175} --structure modulus --out plain",),
    "s175_methods": (f"reduce {S175} --method all --json --out every",),
    "s175_added": (
        f"reduce {S175} --fn pooled --structure linear --json --out base",
        f"add base/model.toml yaw_sway_coupling --fit {S175} -o better.toml --no-figures --json"
        " --out added",
        f"compare better.toml {S175} --no-figures --json --out beside",
        f"add better.toml --undo --fit {S175} -o back.toml --no-figures --json --out undone",
    ),
    "s175_plan": (f"plan cubic {S175} --json --out next",),
    "s175_budget": (f"budget {S175} --of Yv,Nv --json --out budget",),
    "s175_report": (f"report {S175} -o report.html",),
    "s175_export": (f"export {S175} --to csv -o campaign",),
    "uncertainty": (
        "uncertainty kvlcc2 --speed 8 --spread 0.05 --ships 200 --seed 3 --json --out sure",
        "sweep kvlcc2 --speeds 6,8 --json --out swept",
        "sweep s175 --speeds 8 --over rudder_deg --values 10,20,35 --json --out rudders",
    ),
    "stability": tuple(
        f"stability {ship} --speed {speed} --json --out {ship}"
        for ship, speed in (("kvlcc2", 8), ("esso190k", 8), ("s175-3dof", 8), ("mariner", 7.7))
    ),
    "imo": (
        "imo kvlcc2 --speed 7.97 --spread 0.05 --ships 100 --json --out kvlcc2",
        "imo esso190k --speed 8 --json --out esso",
    ),
    "scale": (
        "scale kvlcc2-l7 --length 320 --speed 8 --json --out full",
        "model set kvlcc2 hull_polynomial.Yv=-0.32 --because tests --out changed.toml --json",
        "model astern kvlcc2 --out astern.toml --json",
    ),
    "estimate": (
        "estimate --length 180 --breadth 30 --draught 10 --block 0.8 --speed 7.5 --propeller 5.8"
        " --rudder 40 --json --out made",
        "simulate made/model.toml --speed 7.5 --no-figures --json --out turn",
    ),
    "seakeeping": (
        "seakeeping tanker-320 --speeds '15.5 kn' --headings 180,135 --hs 4 --tp 9.7"
        " --no-figures --json --out tanker",
        "seakeeping datasets/hulls/s175-design.toml --speeds 'Fn 0.2' --headings 180,90"
        " --sea-state 5 --no-figures --json --out s175",
    ),
    "export_mss": ("export kvlcc2 --to mss --speed 8 -o mss",),
    "export_shipmmg": ("export kvlcc2 --to shipmmg --speed 8 -o shipmmg",),
    "export_fmu": ("export s175 --to fmu --speed 8 -o s175.fmu",),
    "export_simman": (
        f"export {S175} --to simman -o simman.zip",
        "simulate kvlcc2 --speed 7.97 --no-figures --json --out turn",
        "export turn/track.csv --to csv -o track.csv",
    ),
}
MEASURED: dict[str, tuple[str, ...]] = {
    "hmri": (
        "check datasets/kvlcc2_hmri --data DATA --json",
        "reduce datasets/kvlcc2_hmri --data DATA --structure mmg --json --out reduced",
        "reduce datasets/kvlcc2_hmri/as_published.toml --data DATA --json",
        "diagnose linear datasets/kvlcc2_hmri --data DATA --noise 0.03 --floor 0.02 --no-figures"
        " --json --out asked",
    ),
    "hsva": (
        "compare kvlcc2-l7 datasets/kvlcc2_hsva --data DATA --json --no-figures --out beside",
        "trial datasets/kvlcc2_hsva --data DATA --json --out tried",
        "identify datasets/kvlcc2_hsva --data DATA --model kvlcc2-l7 --derivatives 'Yv Yr Nv Nr'"
        " --runs 'Z_10*' --json --out found",
    ),
    "esso_osaka": (
        "trial datasets/esso_osaka --data DATA --json --out tried",
        "compare esso-osaka-3m datasets/esso_osaka --data DATA --json --no-figures --out beside",
    ),
}
ITERATED = 1e-6
"""Of filters and of searches that end at a tolerance of their own."""
JOBS = (
    *(Job(f"typed_{name}", partial(typed, *lines)) for name, lines in LINES.items()),
    *(
        Job(f"typed_{name}", partial(typed, *lines), tolerance=ITERATED, measured=True)
        for name, lines in MEASURED.items()
    ),
)
