"""Worked examples of docs/notebooks: executed, timed, with the picture that stands for each."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import nbformat
from myst_nb.core.read import read_myst_markdown_notebook
from nbclient import NotebookClient
from nbformat import NotebookNode

from pmmkit.files import atomic_path, datasets_folder, write_text
from scripts.documentation.site.sections import ROOT

FOLDER: Final = ROOT / "docs" / "notebooks"
PICTURE: Final = "picture"
"""Tag of the cell whose figure stands in the gallery."""
SLOW: Final = 300
"""Seconds after which a cell is given up."""


@dataclass(frozen=True, kw_only=True)
class Notebook:
    """An executed notebook.

    Parameters
    ----------
    name : str
        Name of its file without the ending.
    content : NotebookNode
        Its cells with what they gave, and how long it ran [s].
    """

    name: str
    content: NotebookNode

    @property
    def time(self) -> str:
        """How long it ran; no processor time where the system does not tell it of others."""
        told = self.content.metadata
        processor = f", {told['processor']:.1f} s of processor" if told["processor"] else ""
        return f"{told['seconds']:.1f} s{processor}"

    @property
    def title(self) -> str:
        """Its heading."""
        return self._opening.partition("\n")[0].lstrip("# ")

    @property
    def summary(self) -> str:
        """Its first paragraph."""
        return self._opening.split("\n\n")[1]

    @property
    def _opening(self) -> str:
        return str(self.content.cells[0].source)

    @property
    def picture(self) -> str:
        """The figure that stands for it, as SVG."""
        (data,) = (
            output.data["image/svg+xml"]
            for cell in self.content.cells
            if PICTURE in cell.metadata.get("tags", ())
            for output in cell.get("outputs", ())
            if "image/svg+xml" in output.get("data", {})
        )
        return str(data)

    @property
    def card(self) -> str:
        """Its card in the gallery."""
        told = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", self.summary)
        head = f":::{{grid-item-card}} {self.title}\n:img-top: pictures/{self.name}.svg\n"
        return f"{head}:link: docs/notebooks/{self.name}\n:link-type: doc\n\n{told}\n:::"


def notebooks() -> tuple[Path, ...]:
    """The notebooks as text, in the order of their names."""
    return tuple(sorted(FOLDER.glob("*.md")))


def read(path: Path) -> NotebookNode:
    """A notebook that was not executed, from its text."""
    return read_myst_markdown_notebook(path.read_text(encoding="utf-8"), path=path)


def executed(path: Path, kept: Path) -> Notebook:
    """A notebook with what its cells give, from the folder `kept` if nothing has changed."""
    file = kept / f"{path.stem}-{_state(path)}.ipynb"
    if file.is_file():
        content = nbformat.read(file, as_version=4)
        return Notebook(name=path.stem, content=content)
    content = read(path)
    started, before = time.monotonic(), os.times()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(datasets_folder(), Path(folder) / "datasets")
        NotebookClient(
            content,
            timeout=SLOW,
            resources={"metadata": {"path": folder}},
            record_timing=False,
            extra_arguments=["--log-level=ERROR"],
        ).execute()
    after = os.times()
    content.metadata["seconds"] = time.monotonic() - started
    content.metadata["processor"] = sum(after[2:4]) - sum(before[2:4])
    with atomic_path(file) as part:
        nbformat.write(content, part)
    return executed(path, kept)


def _state(path: Path) -> str:
    """What a notebook's results depend on: its text, the package and the datasets."""
    told = hashlib.sha256()
    package = sorted([*(ROOT / "pmmkit").rglob("*.py"), *(ROOT / "pmmkit").rglob("*.toml")])
    data = [file for file in sorted((ROOT / "datasets").rglob("*")) if file.is_file()]
    for file in (path, *package, *data):
        told.update(file.read_bytes())
    return told.hexdigest()[:16]


def cards(found: tuple[Notebook, ...]) -> str:
    """The gallery as cards with pictures."""
    if not found:
        return ""
    return "\n".join(["::::{grid} 1 2 3 3", ":gutter: 3", "", *(x.card for x in found), "::::"])


def place(notebook: Notebook, source: Path) -> None:
    """Put a notebook and its picture into the source of the site."""
    write_text(
        source / "docs" / "notebooks" / f"{notebook.name}.ipynb", nbformat.writes(notebook.content)
    )
    write_text(source / "pictures" / f"{notebook.name}.svg", notebook.picture)
