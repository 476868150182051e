"""The recipe for conda-forge, from pyproject.toml and a built sdist."""

from __future__ import annotations

import hashlib
import re
import tomllib
from pathlib import Path
from typing import Any, Final

from pmmkit.base import __version__

CONDA_NAMES: Final = {"matplotlib": "matplotlib-base"}
"""Packages that conda-forge has under another name."""
RECIPE: Final = """\
schema_version: 1

context:
  version: "{version}"
  python_min: "{python}"

package:
  name: {name}
  version: ${{{{ version }}}}

source:
  path: {name}-${{{{ version }}}}.tar.gz  # conda-forge takes the url at which it was published
  sha256: {sha256}

build:
  number: 0
  noarch: python
  script: ${{{{ PYTHON }}}} -m pip install . -vv --no-deps --no-build-isolation
  python:
    entry_points:
{entry_points}

requirements:
  host:
    - python ${{{{ python_min }}}}.*
    - pip
{host}
  run:
    - python >=${{{{ python_min }}}}
{run}

tests:
  - python:
      imports:
        - {name}
      pip_check: true
      python_version:
        - ${{{{ python_min }}}}.*
        - "*"
  - script:
{trials}

about:
  summary: {description}
  license: {licence}
  license_file: {licence_file}

extra:
  recipe-maintainers: []  # names of accounts
"""


def requirement(text: str) -> str:
    """A requirement of pyproject.toml as conda writes it.

    Examples
    --------
    >>> requirement("pysindy>=2.1,<3"), requirement("npTDMS>=1.9"), requirement("rich")
    ('pysindy >=2.1,<3', 'nptdms >=1.9', 'rich')
    """
    name, bounds = re.fullmatch(r"([\w.-]+)(.*)", text).groups()
    known = CONDA_NAMES.get(name.lower(), name.lower())
    return f"{known} {bounds}".strip()


def recipe(project: dict[str, Any], sha256: str) -> str:
    """The recipe of a project, by the content of its pyproject.toml and the hash of its sdist."""
    told = project["project"]

    def items(lines: list[str], indent: int) -> str:
        return "\n".join(f"{' ' * indent}- {line}" for line in lines)

    return RECIPE.format(
        version=__version__,
        python=told["requires-python"].removeprefix(">="),
        name=told["name"],
        sha256=sha256,
        entry_points=items([f"{key} = {home}" for key, home in told["scripts"].items()], 6),
        host=items([requirement(item) for item in project["build-system"]["requires"]], 4),
        run=items([requirement(item) for item in told["dependencies"]], 4),
        trials=items([f"{key} --help" for key in told["scripts"]], 6),
        description=told["description"],
        licence=told["license"],
        licence_file=told["license-files"][0],
    )


def recipe_of(sdist: Path, pyproject: Path) -> str:
    """The recipe of a built sdist."""
    with pyproject.open("rb") as stream:
        project = tomllib.load(stream)
    return recipe(project, hashlib.sha256(sdist.read_bytes()).hexdigest())
