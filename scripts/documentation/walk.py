"""A walk of pictures through the workbench, in a Chromium, as docs/walk.md shows it.

    python -m scripts.documentation.walk [FOLDER]

The demonstration is chosen on the first page, and everything after that is clicked as a person
does it; the pictures are written as ``walk_1.png`` and so on, to docs/images if no folder is named.
"""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from pmmkit.actions import action
from pmmkit.files import datasets_folder
from pmmkit.workbench import Desk
from tests.support.chromium import chromium, found
from tests.support.served import served

SIZE: Final = (1280, 820)
COLOURS: Final = 64
"""Of a picture: flat colours and letters need no more, and it has a third of the bytes."""
SETTLED: Final = "!document.querySelector('.job') && document.querySelector('main h2') !== null"
ADD: Final = ".candidates button.primary:not([disabled])"


def click(page: Any, selector: str) -> None:
    """Wait for a button and press it."""
    page.wait(f"document.querySelector('{selector}') !== null")
    page.run(f"document.querySelector('{selector}').click()")


def place(page: Any, name: str, there: str) -> None:
    """Go to a place and wait until it is drawn."""
    page.run(f"location.hash = '{name}'; scrollTo(0, 0)")
    page.wait(there)


def pictures(page: Any, address: str) -> Iterator[bytes]:
    """What is seen at each station of the walk."""
    page.open(address)
    page.wait("document.querySelector('.begin-wide button.primary') !== null")
    yield page.picture()
    click(page, ".begin-wide button.primary")
    page.wait("document.querySelectorAll('.map td').length > 9")
    place(page, "data", "document.querySelectorAll('.grid-runs > *').length > 3")
    yield page.picture()
    place(page, "derivatives", "document.querySelector('main button') !== null")
    click(page, "main button")
    page.wait("document.querySelectorAll('main table tbody tr').length > 5 && " + SETTLED)
    yield page.picture()
    plotted = "document.querySelector('section[aria-label=\"Selected run\"] canvas') !== null"
    place(page, "where", plotted)
    yield page.picture()
    place(page, "missing", "document.querySelector('main button.primary') !== null")
    click(page, "main button.primary")
    page.wait(f"document.querySelector('{ADD}') !== null && " + SETTLED)
    page.point("document.querySelector('.candidates > li')")
    page.wait(plotted)
    page.run("scrollTo(0, 0)")
    yield page.picture()
    for number in range(3):
        click(page, ADD)
        page.wait(f"document.querySelectorAll('footer.rail li').length > {number + 1} && {SETTLED}")
    page.wait("document.querySelector('main .pair .plot svg') !== null")
    page.run("scrollTo(0, 0)")
    yield page.picture()
    place(page, "where", plotted)
    yield page.picture()
    place(page, "ship", "document.querySelector('main .model-area') !== null")
    yield page.picture()


def written(picture: bytes, file: Path) -> None:
    """A picture in few colours."""
    from PIL import Image

    with Image.open(io.BytesIO(picture)) as image:
        few = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        few.save(file, optimize=True)


def main() -> None:
    into = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "docs/images"
    browser = found()
    if browser is None:
        raise SystemExit("There is no Chromium on this machine.")
    with tempfile.TemporaryDirectory() as name:
        desk = Desk(Path(name) / "workbench", [datasets_folder()], action)
        with chromium(browser, Path(name) / "profile") as page, served(desk) as address:
            page.size(*SIZE)
            for number, picture in enumerate(pictures(page, address), 1):
                written(picture, into / f"walk_{number}.png")
                print(f"walk_{number}.png", flush=True)
        desk.close()


if __name__ == "__main__":
    main()
