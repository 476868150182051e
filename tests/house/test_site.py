"""The documentation site: each page has its place, links lead to pages, and settings load."""

from __future__ import annotations

import ast
import posixpath
import re
import runpy
from pathlib import Path

import pytest

import pmmkit
from scripts.documentation.site.pages import pages
from scripts.documentation.site.reference import plain, source
from scripts.documentation.site.sections import index, sections

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.md"))
README = (ROOT / "README.md").read_text(encoding="utf-8")
LISTING = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def gathered():
    """All pages of the site but the worked examples, by path."""
    return pages([file.stem for file in NOTEBOOKS], cards="")


def listed(path: str, text: str) -> set[str]:
    """Pages that a page's tables of contents name."""
    blocks = re.findall(r"^```\{toctree\}\n(.*?)^```", text, re.S | re.M)
    blocks += re.findall(r"^\.\. toctree::\n(.*?)(?=^\S|\Z)", text, re.S | re.M)
    named = {
        re.sub(r".*<(.*)>$", r"\1", line.strip())
        for block in blocks
        for line in block.splitlines()
        if line.strip() and not line.strip().startswith(":")
    }
    return {posixpath.join(posixpath.dirname(path), name) for name in named}


def without_ending(path: str) -> str:
    return re.sub(r"\.(md|rst|ipynb)$", "", path)


def slug(heading: str) -> str:
    """The anchor of a heading."""
    words = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def test_every_page_is_in_one_table_of_contents(gathered):
    """A page of docs/ that docs/index.md does not list under a section is found here."""
    named = [without_ending(x) for path, text in gathered.items() for x in listed(path, text)]
    there = {without_ending(path) for path in gathered} - {"index"}
    there |= {f"docs/notebooks/{file.stem}" for file in NOTEBOOKS}
    assert sorted(named) == sorted(there)


def test_links_lead_to_pages_and_their_headings(gathered):
    code = re.compile(r"^```.*?^```|`[^`\n]*`", re.S | re.M)
    texts = gathered | {
        f"docs/notebooks/{file.name}": file.read_text(encoding="utf-8") for file in NOTEBOOKS
    }
    for path, text in texts.items():
        for target in re.findall(r"(?<!!)\[[^\]]*\]\((?!https?:)([^)]+)\)", code.sub("``", text)):
            file, _, anchor = target.partition("#")
            page = posixpath.normpath(posixpath.join(posixpath.dirname(path), file))
            page = page if file else path
            assert page in gathered, f"{path} links to {target}"
            headings = re.findall(
                r"^#+ (.*)$", re.sub(r"^```.*?^```", "", gathered[page], flags=re.S | re.M), re.M
            )
            assert not anchor or anchor in map(slug, headings), f"{path} links to {target}"


def test_every_word_and_command_has_its_page(gathered):
    words = {name for name in pmmkit.__all__ if callable(getattr(pmmkit, name))}
    assert {f"python/{name}.rst" for name in words} <= set(gathered)
    assert "`--rudder-deg <float>`" in gathered["commands/simulate.md"]
    assert r"pmmkit simulate \[OPTIONS\]" not in gathered["commands/simulate.md"]
    assert "querkraft" in gathered["words.md"]
    assert "`yasukawa_yoshimura_2015`" in gathered["bibliography.md"]


def test_the_first_page_has_pictures_above_the_licence():
    first = index(README, ["how-to.md"], "CARDS")
    assert "### How to" not in first
    assert first.index("CARDS") < first.index("Licence: BSD 3-Clause")
    assert {"tutorials", "how-to", "reference"} <= set(sections(LISTING))


def test_marks_of_the_console_are_no_marks_of_a_page():
    assert plain("a_b <x> [y] 2*3") == r"a\_b \<x\> \[y\] 2\*3"


def test_a_source_without_authors_begins_with_its_title():
    told = {
        source(item).partition(".")[0]
        for item in pmmkit.conventions.sources.bibliography().values()
    }
    assert all(re.match(r"\w", text) for text in told)


def test_the_settings_load_and_take_the_version_of_the_package():
    settings = runpy.run_path(str(ROOT / "docs" / "conf.py"))
    assert settings["release"] == pmmkit.__version__
    assert (
        ROOT / "docs" / settings["html_static_path"][0] / settings["html_css_files"][0]
    ).is_file()


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_worked_example_has_a_title_a_summary_one_picture_and_python(file):
    text = file.read_text(encoding="utf-8")
    _, _, content = text.removeprefix("---").partition("\n---\n")
    assert re.match(r"\s*# \S.*\n\n\w", content)
    cells = re.findall(r"^```\{code-cell\} python\n(.*?)^```$", text, re.S | re.M)
    assert sum(":tags: [picture]" in cell for cell in cells) == 1
    for cell in cells:
        ast.parse(re.sub(r"^:tags:.*$", "", cell, flags=re.M))
