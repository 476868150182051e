"""Answers that are kept, and why they were."""

from __future__ import annotations

import datetime as dt
import json
import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scripts.golden.judged import Judged

FOLDER = Path(__file__).parent / "kept"
REASONS = "reasons.toml"


def answer_of(name: str, folder: Path = FOLDER) -> Any:
    """The answer that is kept of a job; None where there is none."""
    path = folder / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def accepted(found: Judged, because: str, folder: Path = FOLDER) -> None:
    """Keep the new answer of a job where something moved, with the reason."""
    if found.answer is None or not (found.moved or found.new):
        return
    folder.mkdir(exist_ok=True)
    text = json.dumps(found.answer, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    _written(folder / f"{found.name}.json", text.replace('},"', '},\n"') + "\n")
    far = max((item.change for item in found.moved if math.isfinite(item.change)), default=0.0)
    entry = (
        f"[[accepted]]\njob = {json.dumps(found.name)}\nday = {dt.date.today().isoformat()}\n"
        f"because = {json.dumps(because, ensure_ascii=False)}\nmoved = {len(found.moved)}\n"
        f"furthest = {far:.3g}\n"
    )
    path = folder.parent / REASONS
    before = path.read_text(encoding="utf-8") + "\n" if path.exists() else ""
    tomllib.loads(before + entry)
    _written(path, before + entry)


def _written(path: Path, text: str) -> None:
    """A file that is never half written."""
    new = path.with_name(f"{path.name}.new")
    new.write_text(text, encoding="utf-8", newline="\n")
    new.replace(path)
