"""The name of an entry stands where the entry is, and nowhere else but for a reason.

A registry (kinds of test …) says everything about its entries; code asks their properties. String
constants outside docstrings that equal a name are held to the files listed here: a new one must be
taken away, or its file listed with the reason. A file that needs its permission no longer loses it.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping
from pathlib import Path

import pytest

from pmmkit.campaigns.test_kinds.registry import BUILT_IN

ROOT = Path(__file__).parents[2]

OF_MANOEUVRES = "a manoeuvre of the simulator, which has the same name"
REGISTRIES: Mapping[str, tuple[Collection[str], Mapping[str, str]]] = {
    "captive kinds of test": (
        [name for name, kind in BUILT_IN.items() if kind.captive],
        {
            "campaigns/test_kinds/steady.py": "their place",
            "campaigns/test_kinds/oscillating.py": "their place",
        },
    ),
    "free-running kinds of test": (
        [name for name, kind in BUILT_IN.items() if kind.free_running],
        {
            "campaigns/test_kinds/free_running.py": "their place",
            "cli/commands/add.py": OF_MANOEUVRES,
            "cli/commands/estimate.py": OF_MANOEUVRES,
            "cli/commands/simulate.py": OF_MANOEUVRES,
            "cli/commands/sweep.py": OF_MANOEUVRES,
            "cli/commands/uncertainty.py": OF_MANOEUVRES,
            "effects/waterjet.py": "a parameter of that name",
            "figures/__init__.py": "functions of these names",
            "metrics.py": "manoeuvres by which the IMO judges",
            "plotting/manoeuvres.py": "ways to draw a manoeuvre",
            "simulation/ensemble.py": OF_MANOEUVRES,
            "simulation/imo.py": OF_MANOEUVRES,
            "simulation/manoeuvres/pull_out.py": OF_MANOEUVRES,
            "simulation/manoeuvres/speed.py": OF_MANOEUVRES,
            "simulation/manoeuvres/spiral.py": OF_MANOEUVRES,
            "simulation/manoeuvres/turning.py": OF_MANOEUVRES,
            "simulation/manoeuvres/zigzag.py": OF_MANOEUVRES,
            "simulation/results.py": OF_MANOEUVRES,
            "simulation/sensitivity.py": OF_MANOEUVRES,
            "simulation/simulate.py": OF_MANOEUVRES,
            "simulation/sweeps.py": OF_MANOEUVRES,
        },
    ),
}
"""Names of a registry, and the files of the package in which they may stand, with the reason."""


def named_in(source: str, names: Collection[str]) -> list[tuple[int, str]]:
    """Lines of some code, and the names that stand there as strings, docstrings left out."""
    tree = ast.parse(source)
    texts = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    wanted = set(names)
    return sorted(
        (node.lineno, node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and node.value in wanted
        and id(node) not in texts
    )


def astray(folder: Path, names: Collection[str], allowed: Collection[str]) -> list[str]:
    """Names outside the files in which they may stand, and files that may hold one and do not."""
    found, used = [], set()
    for path in sorted(folder.rglob("*.py")):
        place = path.relative_to(folder).as_posix()
        hits = named_in(path.read_text(encoding="utf-8"), names)
        if place in allowed:
            used |= {place} if hits else set()
        else:
            found += [f"{place}:{line} names {name!r}" for line, name in hits]
    return found + [f"{place} need not be listed" for place in sorted(set(allowed) - used)]


@pytest.mark.parametrize("registry", REGISTRIES)
def test_names_stand_where_they_may(registry: str) -> None:
    names, allowed = REGISTRIES[registry]
    assert astray(ROOT / "pmmkit", names, allowed) == []


def test_a_stray_name_is_noticed(tmp_path: Path) -> None:
    code = (
        '"""pure_sway"""\n\ndef f(run):\n    """pure_sway"""\n    return run.test == "pure_sway"\n'
    )
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "stray.py").write_text(code, encoding="utf-8")
    (tmp_path / "home.py").write_text('NAME = "pure_sway"\n', encoding="utf-8")
    assert astray(tmp_path, ["pure_sway"], ["home.py"]) == ["room/stray.py:5 names 'pure_sway'"]
    assert astray(tmp_path, ["pure_sway"], ["home.py", "room/stray.py"]) == []
    assert astray(tmp_path, ["pure_yaw"], ["home.py"]) == ["home.py need not be listed"]
