"""Write docs/validation.md: published figures beside ours.

    python -m scripts.validation [--check] [--data FOLDER]

With --check nothing is written, and the exit status is 1 if the page is out of date. --data names
the folder of the measurements; what comes of them is computed anew and kept in measurements.toml.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pmmkit.files import write_text
from scripts.documentation.fences import DOCS
from scripts.validation import measurements
from scripts.validation.page import NAME, page


def main() -> int:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing, name a stale page")
    parser.add_argument("--data", type=Path, help="folder of the measurements")
    given = parser.parse_args()
    if given.data:
        measurements.compute(given.data)
    file, text = DOCS / NAME, page()
    if not given.check:
        write_text(file, text)
    elif not file.is_file() or file.read_text(encoding="utf-8") != text:
        print(f"docs/{NAME} is out of date: run python -m scripts.validation")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
