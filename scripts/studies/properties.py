"""Every property of the tests with many times its examples, of another seed each time.

    python -m scripts.studies.properties [--times 50] [--seed N] [--workers 2] [--limit-seconds S]
                                         [--out FILE] [selection and options of pytest]

The tests themselves have the same examples for everyone (tests/conftest.py). Here each has TIMES as
many as its own settings say, drawn anew. A line of the table is a property: examples that ran to
their end (what `assume` refused is not counted), seconds, and

passed      all examples, or all that there are
stopped     it held as often as it says until --limit-seconds had passed
fell        with the falsifying example below
skipped     the test itself was skipped
error       what it needs could not be made

The seed at the end repeats the same examples: a limit ends their sequence and does not change it.
"""

from __future__ import annotations

import argparse
import json
import re
import secrets
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import wraps
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, is_hypothesis_test, settings
from hypothesis.errors import FlakyStrategyDefinition, StopTest, UnsatisfiedAssumption

ROOT = Path(__file__).parents[2]
SLOW = (HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example)
LIMITED = "the time is over"
FALSIFYING = re.compile(
    r"^E\s+(?:\| )?(?:Failing test case|Falsifying example|Falsifying explicit)", re.M
)


@dataclass(frozen=True, kw_only=True)
class Line:
    """What came of a property."""

    name: str
    outcome: str
    examples: int
    seconds: float
    example: str = ""


def with_properties() -> list[str]:
    """Files of tests that have a property."""
    files = sorted((ROOT / "tests").rglob("test_*.py"))
    return [str(path) for path in files if "@given" in path.read_text(encoding="utf-8")]


def pytest_addoption(parser: pytest.Parser) -> None:
    """What workers must know too."""
    parser.addoption("--times", type=int, default=1)
    parser.addoption("--limit-seconds", type=float, default=float("inf"))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Properties alone, each with its new settings."""
    kept = [item for item in items if is_hypothesis_test(getattr(item, "obj", None))]
    functions = {id(function): function for function in map(_function, kept)}
    for function in functions.values():
        own = function._hypothesis_internal_use_settings
        function._hypothesis_internal_use_settings = settings(
            own,
            max_examples=own.max_examples * config.getoption("--times"),
            derandomize=False,
            deadline=None,
            database=None,
            report_multiple_bugs=False,
            suppress_health_check={*own.suppress_health_check, *SLOW},
        )
    items[:] = kept


def _function(item: Any) -> Any:
    return getattr(item.obj, "__func__", item.obj)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Count the examples of one property, and end it when its time is over."""
    handle = _function(item).hypothesis
    inner = handle.inner_test
    ran: list[bool] = []
    end = time.monotonic() + item.config.getoption("--limit-seconds")
    handle.inner_test = _counted(inner, ran, end)
    try:
        yield
    except FlakyStrategyDefinition:
        # An example that draws as it goes ends before its first draw when the time is over.
        if time.monotonic() <= end or not all(ran):
            raise
        pytest.skip(LIMITED)
    finally:
        handle.inner_test = inner
        item.user_properties.append(("examples", len(ran)))


def _counted(inner: Callable[..., None], ran: list[bool], end: float) -> Callable[..., None]:
    """A test that notes whether each example held; none is left out once one fell, which would
    make another answer of it while hypothesis looks for a smaller one."""

    @wraps(inner)
    def run(*args: Any, **given: Any) -> None:
        if time.monotonic() > end and all(ran):
            pytest.skip(LIMITED)
        try:
            inner(*args, **given)
        except (UnsatisfiedAssumption, StopTest):
            raise
        except Exception:
            ran.append(False)
            raise
        ran.append(True)

    return run


def line(report: pytest.TestReport) -> Line | None:
    """What a report of pytest says of a property, when it is the one that decides."""
    if report.when == "teardown" or (report.when == "setup" and report.passed):
        return None
    examples: Any = dict(report.user_properties).get("examples", 0)
    found = Line(
        name=report.nodeid, outcome=report.outcome, examples=examples, seconds=report.duration
    )
    text = report.longreprtext
    if report.skipped:
        return replace(found, outcome="stopped" if LIMITED in text else "skipped")
    if report.failed:
        outcome = "fell" if report.when == "call" else "error"
        return replace(found, outcome=outcome, example=falsifying(text))
    return found


def falsifying(text: str) -> str:
    """The error and the falsifying example of a report, or its end where there is none."""
    found = FALSIFYING.search(text)
    rows = text[found.start() :].splitlines() if found else text.splitlines()[-12:]
    errors = [row for row in text.splitlines() if re.match(r"E\s+(\S*Error|assert)", row)]
    return "\n".join(row.removeprefix("E").strip() for row in [*errors[:1], *rows])


class Told:
    """What is told while the properties run, by the process that was started."""

    def __init__(self) -> None:
        self.lines: list[Line] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        found = line(report)
        if found is None:
            return
        self.lines.append(found)
        counted = f"{found.examples:8d} {found.seconds:8.1f} s"
        print(f"{counted}  {found.outcome:8s} {found.name}", flush=True)
        if found.example:
            print("\n".join(f"    {row}" for row in found.example.splitlines()), flush=True)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            print(report.longreprtext, flush=True)

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_teststatus(self, report: Any) -> tuple[str, str, str]:
        return report.outcome, "", ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=50, help="examples over those of the tests")
    parser.add_argument("--seed", type=int, help="of the examples; another each time by default")
    parser.add_argument("--workers", "--jobs", type=int, default=2, help="processes")
    parser.add_argument("--limit-seconds", type=float, default=float("inf"), help="of a property")
    parser.add_argument("--out", type=Path, help="JSON of the table")
    o, rest = parser.parse_known_args()
    seed = secrets.randbelow(2**32) if o.seed is None else o.seed
    selected = any((ROOT / part.split("::")[0]).exists() for part in rest)
    words = [
        *("-p", "scripts.studies.properties", "-p", "no:cacheprovider", "-qq", "--no-header"),
        *("--no-summary", "--tb=short", "-o", "console_output_style=classic"),
        *("--rootdir", str(ROOT), "-c", str(ROOT / "pyproject.toml")),
        *(f"--times={o.times}", f"--limit-seconds={o.limit_seconds}", f"--hypothesis-seed={seed}"),
        *(("-n", str(o.workers), "--dist", "worksteal") if o.workers > 1 else ()),
        *rest,
        *(() if selected else with_properties()),
    ]
    told = Told()
    began = time.perf_counter()
    code = pytest.main(words, plugins=[told])
    outcomes = [item.outcome for item in told.lines]
    names = sorted(set(outcomes), key=outcomes.index)
    print(
        f"{len(outcomes)} properties, {sum(item.examples for item in told.lines)} examples, "
        f"{time.perf_counter() - began:.0f} s: "
        + ", ".join(f"{outcomes.count(name)} {name}" for name in names)
        + f"; --times {o.times} --seed {seed}"
    )
    if o.out:
        o.out.write_text(json.dumps([asdict(item) for item in told.lines], indent=1))
    return int(code)


if __name__ == "__main__":
    sys.exit(main())
