"""Speed of the simulation, measured side by side: C, other people's solvers, batches, cold, warm.

    python -m scripts.benchmarks.benchmark_engine [--rounds 9] [--long]

One KVLCC2 turn against shipmmg 0.0.11, heyoka and numbalsoda, and its right-hand side against a C
program compiled with -O3 -march=native -ffast-math; ten thousand ships, beside heyoka and
numbalsoda too; the time to the first turn of a session. The rounds alternate, so that a busy
machine hits all alike. The others are in the dependency group ``bench``; without them, or without
gcc, that part is left out and said so.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import pmmkit as pk
from pmmkit.equations import Gear, Prepared, prepare, run_plan
from pmmkit.equations.layouts import Constant
from pmmkit.equations.structure import FACTOR_PLACES
from pmmkit.simulation import MANOEUVRES
from scripts.benchmarks.other_solvers import Turn, Ways, installed

SHIP, SPEED, RTOL = "kvlcc2-l7", 1.179, 1e-6
SOURCE = Path(__file__).with_name("benchmark_turn.c")
SIZE, SHIPS = 200_000, 10_000
_PARAMETERS = {
    "propeller": {
        "D": "D",
        "t": "T",
        "kt0": "KT0",
        "kt1": "KT1",
        "kt2": "KT2",
        "wp": "WP",
        "xp": "XP",
        "C1": "C1",
        "C2_positive": "C2P",
        "C2_negative": "C2N",
    },
    "rudder_mmg": {
        "area": "AREA",
        "lift_slope": "FA",
        "epsilon": "EPS",
        "kappa": "KAPPA",
        "eta": "ETA",
        "gamma_positive": "GP",
        "gamma_negative": "GN",
        "lR": "LR",
        "tR": "TR",
        "aH": "AH",
        "xH": "XH",
        "xR": "XR",
    },
}


def macros(ready: Prepared) -> list[str]:
    """Compiler options that say where each constant of the C program stands."""
    found = []
    place = len(Constant)
    for factors, channels in ready.structure.products or ():
        word = "".join(FACTOR_PLACES[factor] for factor in factors).upper() or "0"
        for channel in channels:
            found.append(f"-DK_{channel}{word}=k[{place}]")
            place += 1
    places = ready.structure.places()
    for effect, names in _PARAMETERS.items():
        for name, word in names.items():
            found.append(f"-DK_{word}=k[{places[effect, name].start}]")
    return found


def c_library(ready: Prepared, folder: Path) -> ctypes.CDLL | None:
    """The C program as a library, or None without gcc."""
    if shutil.which("gcc") is None:
        return None
    target = folder / "turn.so"
    subprocess.run(
        [
            "gcc",
            "-O3",
            "-march=native",
            "-ffast-math",
            "-shared",
            "-fPIC",
            *macros(ready),
            str(SOURCE),
            "-o",
            str(target),
            "-lm",
        ],
        check=True,
    )
    library = ctypes.CDLL(str(target))
    pointer, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    library.one.argtypes = [pointer, real, real, pointer, pointer]
    library.repeat.argtypes = [pointer, pointer, ctypes.c_long, pointer]
    library.repeat.restype = real
    library.turn.argtypes = [pointer, pointer, real, real, real, real, ctypes.c_long]
    library.turn.restype = real
    return library


def pointer(array: np.ndarray) -> ctypes.Array:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def check(library: ctypes.CDLL, ready: Prepared) -> float:
    """Largest difference of the C right-hand side from ours, over the size of each rate."""
    rng = np.random.default_rng(0)
    k, worst = np.array(ready.constants), 0.0
    for _ in range(100):
        y = np.array(
            [
                0.0,
                0.0,
                rng.uniform(-3, 3),
                rng.uniform(0.3, 1.2),
                rng.uniform(-0.4, 0.4),
                rng.uniform(-0.1, 0.1),
            ]
        )
        delta, n, out = rng.uniform(-0.6, 0.6), rng.uniform(5, 12), np.zeros(6)
        library.one(pointer(y), delta, n, pointer(k), pointer(out))
        ours = np.array(ready.rates(y.tolist(), delta, n))
        worst = max(worst, float(np.max(np.abs(out - ours) / np.maximum(np.abs(ours), 1e-3))))
    return worst


def shipmmg_turn(model: pk.Model, duration: float, n: float) -> Callable[[], object] | None:
    """The same turn by shipmmg, or None if it is not installed."""
    try:
        from shipmmg.mmg_3dof import Mmg3DofBasicParams, Mmg3DofManeuveringParams, simulate_mmg_3dof
    except ImportError:
        return None
    ship, rho = model.ship, model.water.rho
    hull, screw, blade = (model.values(x) for x in ("hull_polynomial", "propeller", "rudder_mmg"))
    added = model.values("added_mass")
    unit = 0.5 * rho * ship.L**2 * ship.d
    basic = Mmg3DofBasicParams(
        L_pp=ship.L,
        B=ship.B,
        d=ship.d,
        x_G=ship.xG,
        D_p=screw["D"],
        m=ship.mass,
        I_zG=ship.Izz - ship.mass * ship.xG**2,
        A_R=blade["area"],
        η=blade["eta"],
        m_x=-added["Xudot"] * unit,
        m_y=-added["Yvdot"] * unit,
        J_z=-added["Nrdot"] * unit * ship.L**2,
        f_α=blade["lift_slope"],
        ϵ=blade["epsilon"],
        t_R=blade["tR"],
        x_R=blade["xR"] * ship.L,
        a_H=blade["aH"],
        x_H=blade["xH"] * ship.L,
        γ_R_minus=blade["gamma_negative"],
        γ_R_plus=blade["gamma_positive"],
        l_R=blade["lR"],
        κ=blade["kappa"],
        t_P=screw["t"],
        w_P0=screw["wp"],
        x_P=screw["xp"],
    )
    manoeuvring = Mmg3DofManeuveringParams(
        k_0=screw["kt0"],
        k_1=screw["kt1"],
        k_2=screw["kt2"],
        R_0_dash=-hull["Xuu"],
        **{f"{name[0]}_{name[1:]}_dash": value for name, value in hull.items() if name != "Xuu"},
    )
    t = np.linspace(0.0, duration, 2000)
    rate, order = math.radians(blade["rate_deg_s"]), math.radians(35.0)
    delta = np.minimum(rate * t, order)

    def run() -> object:
        return simulate_mmg_3dof(
            basic,
            manoeuvring,
            t,
            delta,
            np.full(len(t), n),
            u0=SPEED,
            ρ=rho,
            method="RK45",
            rtol=RTOL,
        )

    return run


def medians(
    ways: dict[str, Callable[[], object]], rounds: int, calls: int = 50
) -> dict[str, float]:
    """Median seconds of each way; the rounds alternate."""
    taken: dict[str, list[float]] = {name: [] for name in ways}
    for work in ways.values():
        work()
    for _ in range(rounds):
        for name, work in ways.items():
            inner = 1 if "shipmmg" in name else calls
            start = time.perf_counter()
            for _ in range(inner):
                work()
            taken[name].append((time.perf_counter() - start) / inner)
    return {name: statistics.median(times) for name, times in taken.items()}


def single(rounds: int) -> None:
    model = pk.load_model(SHIP)
    track = pk.simulate(model, "turning", rudder_deg=35, speed=SPEED, rtol=RTOL)
    duration, n = float(track.t[-1]), float(track.n[0])
    ways: dict[str, Callable[[], object]] = {
        "pk.simulate, rtol 1e-6": lambda: pk.simulate(
            model, "turning", rudder_deg=35, speed=SPEED, rtol=RTOL
        ),
        "pk.simulate, rtol 1e-8 (default)": lambda: pk.simulate(
            model, "turning", rudder_deg=35, speed=SPEED
        ),
        "interpreted, rtol 1e-6": lambda: pk.simulate(
            model, "turning", rudder_deg=35, speed=SPEED, rtol=RTOL, compiled=False
        ),
    }
    ready, plan = prepare(model, SPEED), MANOEUVRES["turning"].plan(SPEED / model.ship.L)
    gear = Gear(rudder_rate=math.radians(model.values("rudder_mmg")["rate_deg_s"]))
    ways["pmmkit, the integration alone, 1e-6"] = lambda: run_plan(
        ready, plan, gear, rtol=RTOL, fast=True
    )
    theirs = shipmmg_turn(model, duration, n)
    if theirs is None:
        print("shipmmg is not installed (pip install --group bench): left out")
    else:
        ways["shipmmg 0.0.11, rtol 1e-6"] = theirs
    turn = Turn(model, SPEED, n, duration, RTOL)
    hull, others = turn.hull[None, :], installed(turn)
    exact = pk.simulate(model, "turning", rudder_deg=35, speed=SPEED, rtol=1e-12)
    place = np.array([exact.x[-1], exact.y[-1]])
    for name, solve in others.items():
        ways[f"{name}, 1e-6"] = partial(solve, hull)
    found = medians(ways, rounds)
    base = found["pk.simulate, rtol 1e-6"]
    print(f"\nOne turn of the KVLCC2 (L = 7 m), {duration:.0f} s, median of {rounds}")
    for name, seconds in found.items():
        print(f"  {name:36} {1e3 * seconds:9.3f} ms   {seconds / base:7.2f} x")
    ends = {"pk.simulate": np.array([track.x[-1], track.y[-1]])}
    ends |= {name: solve(hull)[0, :2] for name, solve in others.items()}
    print("  Where the turn ends, from that of pk.simulate at 1e-12, in ship lengths:")
    for name, end in ends.items():
        print(f"  {name:36} {float(np.hypot(*(end - place))) / model.ship.L:9.1e}")
    fleets(turn, others, rounds)


def fleets(turn: Turn, others: Ways, rounds: int) -> None:
    """The same turn by many ships, whose derivatives are drawn."""
    many = turn.hull * np.random.default_rng(0).normal(1.0, 0.05, (SHIPS, turn.hull.size))
    settings = {"rudder_deg": 35, "speed": SPEED, "rtol": RTOL, "spread": 0.05, "n": SHIPS}
    fleet: dict[str, Callable[[], object]] = {
        "pk.monte_carlo, all metrics": lambda: pk.monte_carlo(
            turn.model, "turning", executor=1, **settings
        ),
        **{name: partial(solve, many) for name, solve in others.items()},
    }
    found = medians(fleet, min(rounds, 5), calls=1)
    print(f"\n{SHIPS:,} of them, 5 % on the derivatives, one thread, 1e-6")
    for name, seconds in found.items():
        ratio = seconds / found["pk.monte_carlo, all metrics"]
        print(f"  {name:36} {seconds:9.3f} s    {ratio:7.2f} x")


def right_hand_sides(rounds: int) -> None:
    model = pk.load_model(SHIP)
    ready = prepare(model, SPEED)
    functions, k = ready.functions(fast=True), np.array(ready.constants)
    start, out, total = np.array([0, 0, 0, 0.8, -0.1, 0.05]), np.zeros(6), np.zeros(1)
    functions.repeat(start.copy(), k, 10, out)
    with tempfile.TemporaryDirectory() as name:
        library = c_library(ready, Path(name))
        if library is None:
            print("there is no gcc: the C program is left out")
            return
        print(f"\nRight-hand side: C and pmmkit differ by at most {check(library, ready):.1e}")
        c, ours, turns = [], [], []
        for _ in range(rounds):
            begin = time.perf_counter()
            functions.repeat(start.copy(), k, SIZE, out)
            ours.append((time.perf_counter() - begin) / SIZE)
            c.append(library.repeat(pointer(start.copy()), pointer(k), SIZE, pointer(total)) / SIZE)
            y = np.array([0.0, 0.0, 0.0, SPEED, 0.0, 0.0])
            turns.append(library.turn(pointer(y), pointer(k), 0.61, 0.27, 10.0, 160.0, 2000))
    mine, theirs = statistics.median(ours), statistics.median(c)
    print(f"  C, gcc -O3 -march=native -ffast-math  {1e9 * theirs:7.1f} ns")
    print(f"  pmmkit, compiled, no fast-math        {1e9 * mine:7.1f} ns   {mine / theirs:.2f} x C")
    print(f"  C, 2000 RK4 steps                     {1e3 * statistics.median(turns):7.3f} ms")


_BATCH = """
import resource, sys, time
import pmmkit as pk
model = pk.load_model("{ship}")
settings = dict(rudder_deg=35, speed={speed}, rtol={rtol}, spread=.05)
pk.monte_carlo(model, "turning", n=4, executor=1, **settings)
idle = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
times = []
for _ in range({rounds}):
    start = time.perf_counter()
    pk.monte_carlo(model, "turning", n={n}, executor={jobs}, **settings)
    times.append(time.perf_counter() - start)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(sorted(times)[len(times) // 2], (peak - idle) / 1024)
"""


def batches(rounds: int, *, long: bool) -> None:
    print("\nMany ships, all metrics of the turn, through pk.monte_carlo")
    cases = [(10_000, jobs, rtol) for rtol in (1e-6, 1e-8) for jobs in (1, 2, 4)]
    cases += [(n, 4, 1e-6) for n in (1_000, 100_000)] + ([(1_000_000, 4, 1e-6)] if long else [])
    for n, jobs, rtol in cases:
        code = _BATCH.format(
            ship=SHIP, speed=SPEED, rtol=rtol, n=n, jobs=jobs, rounds=rounds if n <= 10_000 else 1
        )
        text = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout
        seconds, memory = map(float, text.split())
        print(
            f"  {n:9,} ships, {jobs} threads, rtol {rtol:.0e}  {seconds:8.3f} s  "
            f"{1e6 * seconds / n:7.2f} µs a ship  {memory:6.1f} MB above idle"
        )


def clock(command: list[str], **environment: str) -> float:
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, **environment})
    return time.perf_counter() - start


def starts(rounds: int) -> None:
    turn = f"import pmmkit as pk; pk.simulate({SHIP!r}, speed={SPEED})"
    with tempfile.TemporaryDirectory() as name:
        out = f"{name}/out"
        shell = [sys.executable, "-m", "pmmkit", "simulate", SHIP, "--speed", str(SPEED)]
        first = clock([sys.executable, "-c", turn], PMMKIT_CACHE=f"{name}/cache")
        cases = {
            "python alone": lambda: clock([sys.executable, "-c", "pass"]),
            "import pmmkit": lambda: clock([sys.executable, "-c", "import pmmkit"]),
            "second session to its first compiled turn": lambda: clock(
                [sys.executable, "-c", turn], PMMKIT_CACHE=f"{name}/cache"
            ),
            "pmmkit simulate, one turn, no figures": lambda: clock(
                [*shell, "--no-figures", "--out", out]
            ),
            "pmmkit simulate, one turn, two figures": lambda: clock([*shell, "--out", out]),
        }
        print("\nFrom the start of the process, median seconds")
        print(f"  {'first session, compiles the equations':44} {first:7.2f}")
        for title, work in cases.items():
            print(f"  {title:44} {statistics.median(work() for _ in range(rounds)):7.3f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--long", action="store_true", help="a million ships too")
    options = parser.parse_args()
    single(options.rounds)
    right_hand_sides(options.rounds)
    batches(options.rounds, long=options.long)
    starts(options.rounds)


if __name__ == "__main__":
    main()
