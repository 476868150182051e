"""What a person waits for on the workbench's page, in a Chromium, and how it grows with runs.

    python -m scripts.benchmarks.benchmark_workbench [--runs 63 300 1000] [--rounds 5]

63 runs are those of S175's dataset with the base ``cubic``; other numbers are a programme of the
virtual tank that lies with the tests, at more and more speeds. Times are those of the clock, from
the click to the next picture after what was asked for is there; medians of all rounds. Each round
of *Add* ends with an undo, so that all of them add the same effect.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from pmmkit.actions import action
from pmmkit.campaigns import save_campaign
from pmmkit.files import datasets_folder
from pmmkit.workbench import Desk, WorkbenchState, frozen_page
from pmmkit.workbench.worker import Job
from scripts.benchmarks.benchmark_diagnosis import campaign
from tests.support.chromium import chromium, found
from tests.support.served import served

DATASET_RUNS: Final = 63
CLICK: Final = """new Promise((done) => {
  const box = %s;
  const there = () => %s;
  const begun = performance.now();
  const end = () => requestAnimationFrame(() => setTimeout(() => done(performance.now() - begun)));
  const seen = new MutationObserver(() => { if (there()) { seen.disconnect(); end(); } });
  seen.observe(box, { childList: true, subtree: true, attributes: true, characterData: true });
  %s;
})"""
"""Milliseconds from a deed to the picture that shows what comes of it: where, what, the deed."""
RUN: Final = "document.querySelector('section[aria-label=\"Selected run\"]')"
PLOTTED: Final = f"{RUN}?.querySelector('canvas') !== null && {RUN} !== null"
FALL: Final = 'section[aria-label="How the error falls"]'
ITEM: Final = "document.querySelector('.candidates > li:nth-child(%d)')"


def waited(page: Any, where: str, there: str, deed: str) -> float:
    """Seconds of one deed."""
    return float(page.run(CLICK % (where, there, deed))) / 1000.0


def painted(page: Any, address: str) -> float:
    """Seconds to the first picture of the page, not of the browser's start."""
    page.open("about:blank")
    page.open(address + "#where")
    page.wait("document.querySelectorAll('.map td[tabindex]').length")
    entries = "performance.getEntriesByName('first-contentful-paint')"
    return float(page.wait(f"{entries}[0]?.startTime")) / 1000.0


def times_of(page: Any, address: str, rounds: int) -> dict[str, float]:
    """Medians of what is waited for [s]."""
    found: dict[str, list[float]] = {"first paint": [painted(page, address) for _ in range(rounds)]}
    page.wait(PLOTTED)
    cells = "[...document.querySelectorAll('.map td:not(.none)')].filter((own) => own.textContent)"
    count = int(page.run(f"{cells}.length"))
    found["run to plot"] = [
        waited(
            page,
            RUN,
            f"{RUN}.querySelector('canvas') && {RUN}.querySelector('canvas') !== before",
            f"const before = {RUN}.querySelector('canvas'); {cells}[{place}].click()",
        )
        for place in range(1, count - 1, max(count // (rounds + 1), 1))
    ]
    page.run("location.hash = 'missing'")
    page.wait("document.querySelectorAll('.candidates > li').length > 1")
    page.wait(PLOTTED)
    found["hover"] = []
    for number in range(rounds):
        item = ITEM % (number % 2 + 1)
        found["hover"].append(
            waited(
                page,
                RUN,
                f"{RUN}.textContent !== before",
                f"const before = {RUN}.textContent; "
                f"{item}.dispatchEvent(new MouseEvent('mouseenter'))",
            )
        )
    found["add to waterfall"] = []
    for _ in range(rounds):
        found["add to waterfall"].append(
            waited(
                page,
                "document.body",
                f"document.querySelectorAll('{FALL} rect').length > 1",
                "document.querySelector('.candidates button.primary').click()",
            )
        )
        page.wait("document.querySelector('.rail button') && !document.querySelector('.job')")
        page.run("[...document.querySelectorAll('.rail button')][0].click()")
        page.wait(f"!document.querySelector('{FALL}')")
        page.wait("document.querySelector('.candidates button.primary:not([disabled])') !== null")
        page.wait(PLOTTED)
    return {name: statistics.median(own) for name, own in found.items()}


def worked(desk: Desk, what: str, job: Job, begun: float) -> None:
    """Say how long some long work took that was just begun."""
    assert job.stand == "running"
    desk.wait(lambda _: None)
    print(f"    {what}: {time.perf_counter() - begun:.1f} s", flush=True)


def measured(runs: int, rounds: int, browser: str, place: Path) -> None:
    """All times of a campaign with so many runs."""
    tests = datasets_folder() / "s175"
    if runs != DATASET_RUNS:
        tests = place / "tests.h5"
        save_campaign(campaign(runs), tests)
    desk = Desk(place / "workbench", [place], action)
    print(f"{runs} runs", flush=True)
    begun = time.perf_counter()
    worked(desk, "opening", desk.open(WorkbenchState(campaign=str(tests), model="cubic")), begun)
    begun = time.perf_counter()
    worked(desk, "asking", desk.diagnose(desk.page()["revision"]), begun)
    with chromium(browser, place / "profile") as page, served(desk) as address:
        page.size(1440, 900)
        for what, seconds in times_of(page, address, rounds).items():
            print(f"    {what}: {seconds:.3f} s", flush=True)
    print(f"    page as a file: {len(frozen_page(desk).encode()) / 1e6:.2f} MB")
    desk.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, nargs="*", default=[63, 300, 1000])
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    browser = found()
    if browser is None:
        raise SystemExit("There is no Chromium on this machine.")
    for runs in asked.runs:
        with tempfile.TemporaryDirectory() as name:
            measured(runs, asked.rounds, browser, Path(name))


if __name__ == "__main__":
    main()
