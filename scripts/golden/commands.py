"""Every command, on every data set that it takes."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from scripts.golden.job import AMPLIFIED, ITERATED, SPEEDS, Job
from scripts.golden.typed import typed

S175 = "datasets/s175"
REDUCED = f"reduce {S175} --json --out reduced"
CHANGES = ("--system bis", "--system prime-d", "--coriolis separate", "--sway beta")
FORMATS = (("mss", ".m"), ("shipmmg", ".py"), ("fmu", ".fmu"), ("fmu --fmi 2", "2.fmu"))
LINES: dict[str, tuple[str, ...]] = {
    "lists": ("--help", "effects --json", "ships --json", "ships", "--no-such-option"),
    "mistakes": (
        "simulat s175",
        "simulate kvlcc2",
        "compare kvlcc2",
        "effects kross",
        "reduce datasets/hulls",
        "model set kvlcc2 rudder.arae=3 --because tests",
        "simulate s175 --manoeuvre zigzag --speed 80 --json",
    ),
    "effects": ("effects flow_straightening", "effects fault_time_lag --json"),
    "models": (
        *(f"model show {ship} --json" for ship in SPEEDS),
        "model set kvlcc2 hull_polynomial.Yv=-0.32 --because tests -o changed.toml --json",
        "model replace kvlcc2 propeller --from kcs -o replaced.toml --json",
        "model astern kvlcc2 -o astern.toml --json",
        "scale kvlcc2-l7 --length 320 --speed 8 --json --out full",
        "scale kvlcc2-l7 --length 320 --froude-only --json --out froude",
    ),
    "demo": ("demo --json --out demo",),
    "s175_check": (
        f"check {S175} --json --out checked",
        f"check {S175}",
        f"inspect {S175} --json",
        f"inspect {S175}/runs.h5 --json",
    ),
    "s175_each": (
        REDUCED,
        "simulate reduced/model.toml --speed 1.5 --json --no-figures --out turn",
        f"compare reduced/model.toml {S175} --json --no-figures --out beside",
        *(f"convert reduced/derivatives.csv {how} --json --out made" for how in CHANGES),
        "convert reduced/derivatives.csv --surge constant --format xlsx --json --out book",
        *(
            f"export reduced/derivatives.csv --to {to} -o {file}"
            for to, file in (("latex", "t.tex"), ("excel", "t.xlsx"), ("mss", "t.m"))
        ),
    ),
    "s175_pooled": (
        f"reduce {S175} --fn pooled --structure cubic --json --out pooled",
        f"diagnose cubic {S175} --no-figures --json --out asked",
        f"diagnose s175-3dof {S175} --candidates asymmetry,crossflow_drag --no-figures --out few",
    ),
    "s175_structures": (
        f"reduce {S175} --structure modulus --out plain",
        f"reduce {S175} --structure auto --parts s175-3dof --fn pooled --json --out auto",
    ),
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
    "s175_export": (
        f"export {S175} --to csv -o campaign",
        f"export {S175} --to simman -o simman.zip",
        "inspect simman.zip --json",
        "reduce simman.zip --structure cubic --fn pooled --json --out again",
        f"compare simman.zip {S175} --json --no-figures --out beside",
    ),
    "uncertainty": (
        "uncertainty kvlcc2 --speed 8 --spread 0.05 --ships 200 --seed 3 --json --out sure",
        "sweep kvlcc2 --speeds 6,8 --json --out swept",
        "sweep s175 --speeds 8 --over rudder_deg --values 10,20,35 --json --out rudders",
    ),
    "stability": tuple(
        f"stability {ship} --speed {speed} --json --out {ship}" for ship, speed in SPEEDS.items()
    ),
    "imo": (
        "imo kvlcc2 --speed 7.97 --spread 0.05 --ships 100 --json --out kvlcc2",
        *(f"imo {ship} --speed {SPEEDS[ship]} --json --out {ship}" for ship in ("esso190k", "kcs")),
        "imo esso190k --speed 8 --astern -0.6 --reversal 60 --json --out astern",
    ),
    "simulate": (
        "simulate kvlcc2 --speed 7.97 --no-figures --json --out turn",
        "export turn/track.csv --to csv -o track.csv",
        "simulate kcs --manoeuvre zigzag --speed '24 kn' --no-figures --out weave",
        "simulate s175-3dof --rudder-deg 20 --speed 8 --wave-height 3 --wave-period 8"
        " --waves-from-deg 30 --wave-motion --no-figures --json --out waves",
        "simulate kvlcc2 --speed 'Fn 0.142' --depth 30 --no-figures --json --out shallow",
        "simulate patrol-vessel-44 --manoeuvre stopping --speed '28.3 kn'"
        " --turns -1 --set reversal_s=15 --no-figures --json --out patrol",
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
    "exports": tuple(
        f"export {ship} --to {to} --speed {speed} -o {ship}{ending}"
        for ship, speed in SPEEDS.items()
        for to, ending in FORMATS
    ),
}  # fmt: skip
FREE = "free --no-figures --json"
MADE: dict[str, tuple[str, ...]] = {
    "free": (
        "inspect free --json",
        "check free --json",
        "trial free --json --out tried",
        f"compare s175-3dof {FREE} --out beside",
        "identify free --model s175-3dof --method all --derivatives 'Yv Yr Nv Nr' --json"
        " --out found",
        f"diagnose s175-3dof {FREE} --candidates asymmetry,rudder_stall --out asked",
        "add s175-3dof asymmetry --fit free -o better.toml --no-figures --json --out added",
        "plan s175-3dof free --json --out next",
        "uncertainty better.toml --speed 8 --ships 100 --json --out sure",
    ),
    "together": (
        "reduce tank.h5 --fn pooled --structure cubic --parts s175-3dof --json --out reduced",
        f"diagnose reduced/model.toml tank.h5 {FREE}"
        " --candidates asymmetry,crossflow_drag,rudder_stall --out asked",
    ),
}
HSVA = "datasets/kvlcc2_hsva --data DATA"
MEASURED: dict[str, tuple[str, ...]] = {
    "hmri": (
        "check datasets/kvlcc2_hmri --data DATA --json",
        "reduce datasets/kvlcc2_hmri --data DATA --structure mmg --json --out reduced",
        "reduce datasets/kvlcc2_hmri/as_published.toml --data DATA --json",
        "diagnose linear datasets/kvlcc2_hmri --data DATA --noise 0.03 --floor 0.02 --no-figures"
        " --json --out asked",
        f"scale reduced/model.toml --like {HSVA} --json --out carried",
        f"compare carried/model.toml {HSVA} --runs 'Z_10*' --json --no-figures --out beside",
    ),
    "hsva": (
        f"check {HSVA} --json",
        f"compare kvlcc2-l7 {HSVA} --json --no-figures --out beside",
        f"trial {HSVA} --json --out tried",
        f"identify {HSVA} --model kvlcc2-l7 --derivatives 'Yv Yr Nv Nr' --runs 'Z_10*' --json"
        " --out found",
    ),
    "esso_osaka": (
        "check datasets/esso_osaka --data DATA --json",
        "trial datasets/esso_osaka --data DATA --json --out tried",
        "compare esso-osaka-3m datasets/esso_osaka --data DATA --json --no-figures --out beside",
    ),
    "veres": (
        "seakeeping DATA/s175_seakeeping_veres/shipx_geometry.mgf --draught 9.5 --speeds 0,8"
        " --headings 180,90 --gm 1 --gyration 9,43.75,44 --hs 4 --tp 9.7 --no-figures --json"
        " --out veres",
    ),
}
FAR = dict.fromkeys(("simulate", "hmri"), AMPLIFIED)


def campaigns(folder: Path) -> None:
    """Zigzags and a turn of the free tank's S175, whose rudder stalls, and captive tests of it."""
    import pmmkit as pk
    from scripts.studies.hidden_effects import tank
    from tests.support.free_tank.campaigns import Setup, write

    write(Setup(case="stall", runs=3, seed=1), folder).rename(folder / "free")
    pk.save_campaign(
        tank().hidden_campaign("small", {"asymmetry": 1.0}, seed=1), folder / "tank.h5"
    )


JOBS = (
    *(
        Job(f"typed_{name}", partial(typed, *lines), tolerance=FAR.get(name, ITERATED))
        for name, lines in LINES.items()
    ),
    *(
        Job(f"typed_{name}", partial(typed, *lines, made=campaigns), tolerance=ITERATED)
        for name, lines in MADE.items()
    ),
    *(
        Job(
            f"typed_{name}",
            partial(typed, *lines),
            tolerance=FAR.get(name, ITERATED),
            measured=True,
        )
        for name, lines in MEASURED.items()
    ),
)
