"""All pages of the site but the worked examples, by their place in its source."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from pmmkit.files import write_text
from scripts.documentation.site import reference
from scripts.documentation.site.sections import ROOT, index, sections, toctree

FILES: Final = ("*.md", "docs/*.md", "docs/theory/*.md", "datasets/*/README.md")
"""Pages of the repository."""
MADE: Final = {
    "reference": (
        "- [Python](python.rst): every public word.",
        "- [Options](options.md): every command with all its options.",
        "- [Words of laboratories](words.md) in other languages.",
        "- [Bibliography](bibliography.md).",
    )
}
"""Pages that the program makes, by the section that lists them."""


def repository_pages() -> dict[str, str]:
    """Pages of the repository but the README, by path."""
    return {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
        for pattern in FILES
        for path in sorted(ROOT.glob(pattern))
        if path != ROOT / "README.md"
    }


def data_lines(pages: Mapping[str, str]) -> list[str]:
    """The datasets, for the section on real data."""
    return [
        f"- [{text.splitlines()[0].lstrip('# ')}]({path})"
        for path, text in pages.items()
        if path.startswith("datasets/")
    ]


def pages(notebooks: Sequence[str], cards: str) -> dict[str, str]:
    """All pages by path; the worked examples by name alone, and their cards."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    written = repository_pages()
    listing = written["docs/index.md"]
    added = MADE | {"real-data": data_lines(written)}
    found = {
        name: section.with_pages(added.get(name, ())) for name, section in sections(listing).items()
    }
    first, *rest = (f"{name}.md" for name in found)
    examples = toctree(f"docs/notebooks/{name}.ipynb" for name in notebooks)
    return {
        "index.md": index(readme, ["docs/index.md", first, "gallery.md", *rest], cards),
        "gallery.md": f"# Gallery\n\n{cards}\n\n{examples}",
        **{f"{name}.md": section.page for name, section in found.items()},
        **written,
        **reference.python_pages(),
        **reference.command_pages(),
        "bibliography.md": reference.sources_page(),
        "words.md": reference.words_page(),
    }


def put(found: Mapping[str, str], folder: Path) -> None:
    """Write pages and pictures to the source of the site."""
    for path, text in found.items():
        write_text(folder / path, text)
    shutil.copytree(ROOT / "docs" / "images", folder / "docs" / "images", dirs_exist_ok=True)
