"""Commands as they are typed, run in this process."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

from pmmkit.cli import main


def said(capsys: Any, *arguments: object) -> tuple[int, Any, str]:
    """Status, JSON object and words of a command run with --json."""
    status = main([*map(str, arguments), "--json"])
    output = capsys.readouterr()
    return status, json.loads(output.out), output.err


def rows_of(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file."""
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))
