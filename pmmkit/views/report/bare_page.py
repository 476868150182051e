"""A page without scripts, to be printed: nothing runs in it and nothing is loaded."""

from __future__ import annotations

from pmmkit.base import __version__
from pmmkit.presentation import content_hash, html_text


def bare_page(title: str, style: str, body: str, *, pictures: bool = False) -> str:
    """The HTML of a page."""
    images = "img-src data:; " if pictures else ""
    policy = (
        f"default-src 'none'; style-src {content_hash(style)}; {images}base-uri 'none'; "
        "form-action 'none'"
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="content-security-policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta name="generator" content="pmmkit {__version__}">\n'
        f"<title>{html_text(title)}</title>\n<style>{style}</style>\n</head>\n"
        f"<body>\n{body}</body>\n</html>\n"
    )
