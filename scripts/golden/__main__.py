"""What the package answered, and what has moved since.

    python -m scripts.golden check [JOB …]                        what moved, by how much
    python -m scripts.golden accept JOB [JOB …] --because "why"   keep the new answers
    python -m scripts.golden list                                 jobs, sizes of their answers

JOB may have stars, as 'hidden_*'. `check` ends with status 1 where anything moved. Why answers were
accepted stands in `reasons.toml`.
"""

from __future__ import annotations

import argparse
import os
import sys

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = "1"  # sums in the same order on every machine; before numpy is imported

from pathlib import Path  # noqa: E402

from scripts.golden.judged import Judged, judged, refused_names  # noqa: E402
from scripts.golden.kept import FOLDER, accepted  # noqa: E402

SHOWN = 12
"""Differences of a job that are printed; the others are counted."""


def jobs() -> dict[str, object]:
    """All jobs by name, those that take longest first."""
    from scripts.golden import commands, diagnoses, ships

    return {job.name: job for job in (*diagnoses.JOBS, *ships.JOBS, *commands.JOBS)}


def printed(found: Judged) -> None:
    """What moved in a job, in a few lines."""
    if found.skipped:
        print(f"{found.name}: skipped, {found.skipped}")
    elif found.new:
        print(f"{found.name}: new, nothing was kept of it")
    elif found.moved:
        print(f"{found.name}: {len(found.moved)} moved")
        for item in found.moved[:SHOWN]:
            print(f"  {item}")
        if len(found.moved) > SHOWN:
            print(f"  and {len(found.moved) - SHOWN} more")
    sys.stdout.flush()


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("check", "accept", "list"))
    parser.add_argument("names", nargs="*", metavar="JOB")
    parser.add_argument("--because", help="why the answers moved, for accept")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    o = parser.parse_args()
    every = jobs()
    wrong = refused_names(o.names, every)
    if wrong:
        print(wrong, file=sys.stderr)
        return 2
    if o.what == "accept" and not (o.because and o.names):
        print('accept takes the names of jobs and --because "the reason".', file=sys.stderr)
        return 2
    if o.what == "list":
        for name in every:
            path: Path = FOLDER / f"{name}.json"
            print(f"{name:20} {path.stat().st_size / 1000 if path.exists() else 0:8.0f} kB")
        return 0
    found = []
    for item in judged(every, o.names, o.workers):
        found.append(item)
        print(f"{len(found):3} {item.name} {item.seconds:.0f} s", file=sys.stderr, flush=True)
        if o.what == "check" or item.answer is None:
            printed(item)
        else:
            accepted(item, o.because)
    if o.what == "check":
        moved = [item.name for item in found if item.moved or item.new]
        print(f"{len(found)} jobs, {'moved: ' + ', '.join(moved) if moved else 'nothing moved'}.")
        return 1 if moved else 0
    return 1 if any(item.answer is None and not item.skipped for item in found) else 0


if __name__ == "__main__":
    sys.exit(main())
