"""Build the documentation site in build/site/html; warnings are errors.

    python -m scripts.documentation.site [--without-notebooks]

The source is gathered in build/site/source: the README, docs/, and pages that the program makes.
Notebooks are executed where they, the package or the datasets have changed.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as sphinx

from scripts.documentation.site.notebooks import Notebook, cards, executed, notebooks, place
from scripts.documentation.site.pages import pages, put
from scripts.documentation.site.sections import ROOT

BUILD = ROOT / "build" / "site"
SOURCE, HTML = BUILD / "source", BUILD / "html"


def gallery(paths: tuple[Path, ...]) -> tuple[Notebook, ...]:
    """Execute notebooks, and say how long each took."""
    found = []
    for path in paths:
        notebook = executed(path, BUILD / "notebooks")
        print(f"{path.relative_to(ROOT)}: {notebook.time}", flush=True)
        found.append(notebook)
    return tuple(found)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--without-notebooks", action="store_true", help="leave the gallery empty")
    found = gallery(() if parser.parse_args().without_notebooks else notebooks())
    shutil.rmtree(SOURCE, ignore_errors=True)
    put(pages([item.name for item in found], cards(found)), SOURCE)
    for notebook in found:
        place(notebook, SOURCE)
    options = ["--fail-on-warning", "--keep-going", "--quiet", "--conf-dir", str(ROOT / "docs")]
    status = sphinx([*options, "--doctree-dir", str(BUILD / "doctrees"), str(SOURCE), str(HTML)])
    if not status:
        print(HTML / "index.html")
    return status


if __name__ == "__main__":
    sys.exit(main())
