"""A page without scripts, to be printed: nothing runs in it and nothing is loaded."""

from __future__ import annotations

import html
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.base import __version__
from pmmkit.presentation import printable
from pmmkit.views.pages.page_file import content_hash

if TYPE_CHECKING:
    from jinja2 import Environment


def bare_page(
    template: str, *, title: str, style: str, pictures: bool = False, **content: Any
) -> str:
    """The HTML of a page."""
    page: str = (
        _templates()
        .get_template(template)
        .render(
            title=title,
            style=style,
            style_hash=content_hash(style),
            images="img-src data:; " if pictures else "",
            version=__version__,
            **content,
        )
    )
    return page


@cache
def _templates() -> Environment:
    """Templates that escape all text that is printable, and refuse names that are not given."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    return Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: (
            value if isinstance(value, Markup) else Markup(html.escape(printable(str(value))))
        ),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
