"""What a release takes: the recipe says what pyproject.toml says, the workflow is whole."""

from __future__ import annotations

import re
import tomllib
import zipfile
from pathlib import Path

import yaml

import pmmkit
from scripts.release.packages import strangers
from scripts.release.recipe import recipe, requirement

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_recipe_has_every_dependency_with_its_bounds():
    told = yaml.safe_load(recipe(PROJECT, sha256="0" * 64))
    run = dict(line.partition(" ")[::2] for line in told["requirements"]["run"])
    assert run.pop("python") == ">=${{ python_min }}"
    assert len(run) == len(PROJECT["project"]["dependencies"])
    assert run["pysindy"] == ">=2.1,<3"
    assert run["matplotlib-base"] == ">=3.9"
    assert told["context"] == {"version": pmmkit.__version__, "python_min": "3.11"}
    assert told["build"]["python"]["entry_points"] == ["pmmkit = pmmkit.cli:main"]
    assert [line.split()[0] for line in told["requirements"]["host"]] == [
        "python",
        "pip",
        "hatchling",
    ]


def test_a_requirement_in_the_words_of_conda():
    assert requirement("npTDMS>=1.9") == "nptdms >=1.9"
    assert requirement("rich") == "rich"


def test_the_workflow_tries_each_python_on_each_system():
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    for name in ("tests", "packages"):
        matrix = jobs[name]["strategy"]["matrix"]
        assert {x.partition("-")[0] for x in matrix["system"]} == {"ubuntu", "windows", "macos"}
        assert matrix["python"][0] == PROJECT["project"]["requires-python"].removeprefix(">=")
        assert "3.14" in matrix["python"]
    for command in re.findall(r"python -m (scripts[\w.]*)", text):
        place = ROOT / command.replace(".", "/")
        assert (place / "__main__.py").is_file() or place.with_suffix(".py").is_file()


def test_git_turns_no_line_ends():
    """On Windows it would, and tests there compare files byte for byte."""
    text = (ROOT / ".gitattributes").read_text(encoding="utf-8")
    assert "* -text" in text.splitlines()


def test_a_wheel_that_lacks_a_file_or_has_one_too_many_is_told(tmp_path):
    wheel = tmp_path / "pmmkit.whl"
    with zipfile.ZipFile(wheel, "w") as opened:
        opened.writestr("tests/test_it.py", "")
        opened.writestr("pmmkit-1.dist-info/METADATA", "")
    told = strangers(wheel)
    assert "pmmkit/presentation/vocabulary.toml is missing in pmmkit.whl" in told
    assert "pmmkit/datasets/s175/runs.h5 is missing in pmmkit.whl" in told
    assert told[-1] == "tests/test_it.py has no business in pmmkit.whl"
