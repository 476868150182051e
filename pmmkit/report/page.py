"""A page out of sections: one HTML file, style and figures inside, nothing loaded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files

from pmmkit.presentation import Section
from pmmkit.version import __version__


def page(
    title: str, subtitle: str, tiles: Sequence[Mapping[str, str]], sections: Sequence[Section]
) -> str:
    """The text of a page.

    Parameters
    ----------
    title, subtitle : str
        Above everything.
    tiles : sequence of mapping
        Each a ``value`` and a ``label``.
    sections : sequence of Section
        In their order.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = files("pmmkit.report")
    environment = Environment(
        loader=FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("template.html.j2").render(
        title=title,
        subtitle=subtitle,
        tiles=tiles,
        sections=sections,
        version=__version__,
        css=(folder / "style.css").read_text(encoding="utf-8"),
    )
