"""How time and memory grow with the number of runs and of ships, one processor.

    python -m scripts.benchmarks.benchmark_growth [--runs 48 100 300 1000 2000] [--mb 0.3] \
        [--diagnosis 48 100 300] [--ships 10000 100000 1000000]

Each line is a process of its own: the time of its processor without imports and compilation, and
the most memory it held, imports included (80 to 200 MB). Runs are CSV files made by `make_large`,
reduced from their folder by this process alone; a diagnosis has its histories in memory
(`benchmark_diagnosis`); ships are KVLCC2 with 5 % on every derivative, turning with 35° of rudder.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

MB: Final = 1e6 if sys.platform == "darwin" else 1e3
"""What the system counts memory in, over a megabyte."""


def reduction(count: int, folder: str) -> dict[str, float]:
    """Seconds of reading all runs, and of all that comes after."""
    import pmmkit as pk

    read = [0.0]

    def tell(done: int, total: int, what: str) -> None:
        if done == total and what.startswith("reading"):
            read[0] = time.process_time()

    warm_up = pk.open_campaign(folder)
    pk.reduce_campaign(warm_up.with_(runs=warm_up.runs[:12]), structure="cubic", executor=1)
    start = time.process_time()
    campaign = pk.open_campaign(folder)
    pk.reduce_campaign(
        campaign.with_(runs=campaign.runs[:count]), structure="cubic", executor=1, progress=tell
    )
    end = time.process_time()
    return {"reading": read[0] - start, "rest": end - read[0]}


def diagnosis(count: int, _: str) -> dict[str, float]:
    """Seconds of a captive diagnosis."""
    from pmmkit.diagnosis.captive.diagnose import diagnose_captive
    from scripts.benchmarks.benchmark_diagnosis import campaign
    from scripts.studies.hidden_effects import tank

    base = tank().BASE
    diagnose_captive(campaign(13), base)
    made = campaign(count)
    start = time.process_time()
    diagnose_captive(made, base)
    return {"all": time.process_time() - start}


def ships(count: int, _: str) -> dict[str, float]:
    """Seconds of turning circles of many ships."""
    import pmmkit as pk

    turn = {"speed": 7.97, "rudder_deg": 35, "spread": 0.05, "executor": 1}
    pk.monte_carlo("kvlcc2", n=100, **turn)
    start = time.process_time()
    pk.monte_carlo("kvlcc2", n=count, **turn)
    return {"all": time.process_time() - start}


WORK: Final[Mapping[str, Callable[[int, str], dict[str, float]]]] = {
    "runs": reduction,
    "diagnosis": diagnosis,
    "ships": ships,
}


def line(what: str, count: int, folder: str) -> str:
    """What a process of its own says of one number of things."""
    command = [sys.executable, "-m", "scripts.benchmarks.benchmark_growth"]
    told = subprocess.run(
        [*command, "--one", what, str(count), "--folder", folder],
        check=True,
        capture_output=True,
        text=True,
    )
    found = json.loads(told.stdout.splitlines()[-1])
    memory, seconds = found.pop("memory"), sum(found.values())
    parts = ", ".join(f"{name} {value:.2f}" for name, value in found.items())
    each = f"{1e3 * seconds / count:.3g}"
    return f"{what:10s}{count:9d}{seconds:10.2f}{each:>10s}{memory:10.0f}   {parts}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, nargs="*", default=[48, 100, 300, 1000, 2000])
    parser.add_argument("--mb", type=float, default=0.25, help="size of a usual run")
    parser.add_argument("--diagnosis", type=int, nargs="*", default=[48, 100, 300])
    parser.add_argument("--ships", type=int, nargs="*", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--folder", default="", help="folder for the campaign, kept")
    o = parser.parse_args()
    if o.one:
        found = WORK[o.one[0]](int(o.one[1]), o.folder)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MB
        print(json.dumps({**found, "memory": memory}))
        return
    print(f"{'':10s}{'count':>9s}{'s':>10s}{'ms each':>10s}{'MB':>10s}")
    with TemporaryDirectory() as place:
        folder = o.folder or place
        if o.runs and not (Path(folder) / "campaign.toml").is_file():
            from scripts.datasets.make_large import make

            make(Path(folder), runs=max(o.runs), mb=o.mb)
        for what in WORK:
            for count in getattr(o, what):
                print(line(what, count, folder), flush=True)


if __name__ == "__main__":
    main()
