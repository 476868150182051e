"""The examples of the documentation run, and its generated pages are up to date."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from pmmkit import catalogue
from pmmkit.actions import action, names
from pmmkit.campaigns.file import schema
from pmmkit.effects import CATALOGUE
from scripts.documentation import campaign_file, make_docs

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "theory").glob("*.md")),
]
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
            CATALOGUE.forget(name)
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


def test_every_key_of_the_campaign_file_says_what_it_means_and_stands_in_its_page():
    """A key that is added to the schema without a description, or in no table, is found here."""
    described = {model for models in campaign_file.KEYS.values() for model in models}
    for name, model in schema.TABLES.items():
        if model is None or not model.model_fields:
            continue
        assert model in described, f"[{name}] stands in no table of docs/formats.md"
        for key, item in model.model_fields.items():
            assert item.description, f"[{name}] {key} does not say what it means"
    told = "".join(make() for make in campaign_file.TABLES["formats.md"].values())
    for model in described:
        for key in model.model_fields:
            assert f"| `{key}` |" in told


def test_help_of_make_docs_makes_nothing(monkeypatch, capsys):
    def refuse():
        raise AssertionError("pages were made")

    monkeypatch.setattr(make_docs, "pages", refuse)
    monkeypatch.setattr("sys.argv", ["make_docs", "--help"])
    with pytest.raises(SystemExit):
        make_docs.main()
    assert "--check" in capsys.readouterr().out


def test_readme_example_is_ten_lines():
    (example,) = blocks(ROOT / "README.md", "python")
    assert len([line for line in example.splitlines() if line.strip()]) <= 10


OF_ALL = {"--help", "--version", "--json", "--quiet", "-q", "--install-completion"}
TYPED = re.compile(r"pmmkit ([a-z][a-z-]*)((?: (?![|;&#])[^\s`]+)*)")


def typed_options(text):
    """Commands and options of the command lines in a text, lines that go on joined."""
    for command, rest in TYPED.findall(text.replace("\\\n", " ").replace("  ", " ")):
        yield from ((command, word) for word in re.findall(r"(?<=\s)--?[a-z][a-z0-9-]*", rest))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_options_of_commands_exist(page):
    known = {
        name: {
            way
            for field in action(name).fields
            for word in field.options
            for way in word.split("/")
        }
        for name in names()
    }
    typed = set(typed_options(page.read_text("utf-8")))
    assert [x for x in sorted(typed) if x[0] in known and x[1] not in known[x[0]] | OF_ALL] == []


def test_an_option_that_is_typed_is_found():
    text = (
        "`pmmkit simulate --rudder-law lag` and\n    pmmkit add m x -o m2.toml --fit a | pmmkit b"
    )
    assert set(typed_options(text)) == {
        ("simulate", "--rudder-law"),
        ("add", "-o"),
        ("add", "--fit"),
    }
