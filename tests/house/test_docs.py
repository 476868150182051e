"""The examples of the documentation run, and its generated pages are up to date."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from pmmkit.effects.catalogue import catalogue, forget_effect
from scripts.documentation import make_docs

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LINKED = [*PAGES, ROOT / "CONTRIBUTING.md"]  # whose code makes a package: test_recipes.py


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.S | re.M)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [page for page in PAGES if blocks(page, "python")], ids=lambda page: page.name
)
def test_python_examples_run_and_say_what_the_page_shows(page, tmp_path, monkeypatch, capsys):
    """The examples of one page run one after another, in a folder with a copy of datasets.

    Each line of what a page shows as text is among what its examples print.
    """
    shutil.copytree(ROOT / "datasets", tmp_path / "datasets")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    known = set(catalogue())
    try:
        for number, code in enumerate(blocks(page, "python"), start=1):
            exec(compile(code, f"{page.name}, example {number}", "exec"), names)
    finally:
        for name in set(catalogue()) - known:
            forget_effect(name)
    printed = set(capsys.readouterr().out.splitlines())
    shown = [line for text in blocks(page, "text") for line in text.splitlines()]
    assert [line for line in shown if line not in printed] == []


@pytest.mark.parametrize("page", LINKED, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"


@pytest.mark.slow
def test_generated_pages_are_up_to_date():
    for name, text in make_docs.pages().items():
        assert (ROOT / "docs" / name).read_text(encoding="utf-8") == text, "run make_docs.py"


def test_readme_example_is_ten_lines():
    (example,) = blocks(ROOT / "README.md", "python")
    assert len([line for line in example.splitlines() if line.strip()]) <= 10
