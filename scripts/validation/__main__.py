"""Write docs/validation*.md: our predictions beside measurements, and what stands behind them.

    python -m scripts.validation [--check] [--data FOLDER]

With --check nothing is written, and the exit status is 1 if a page is out of date. --data names
the folder of the measurements; what comes of them is computed anew and kept in measurements.toml.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pmmkit.files import write_text
from scripts.documentation.fences import DOCS
from scripts.validation import measurements
from scripts.validation.page import pages


def main() -> int:
    """Write the pages, or check them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing, name stale pages")
    parser.add_argument("--data", type=Path, help="folder of the measurements")
    given = parser.parse_args()
    if given.data:
        measurements.compute(given.data)
    stale = 0
    for name, text in pages().items():
        file = DOCS / name
        if not given.check:
            write_text(file, text)
        elif not file.is_file() or file.read_text(encoding="utf-8") != text:
            print(f"docs/{name} is out of date: run python -m scripts.validation")
            stale = 1
    return stale


if __name__ == "__main__":
    sys.exit(main())
