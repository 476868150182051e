"""The name of an entry stands where the entry is, and nowhere else but for a reason.

A registry (kinds of test …) says everything about its entries; code asks their properties. String
constants outside docstrings that equal a name are held to the files listed here: a new one must be
taken away, or its file listed with the reason. A file that needs its permission no longer loses it.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping
from functools import cache
from pathlib import Path

import pytest

from pmmkit import catalogue
from pmmkit.campaigns import TEST_KINDS

ROOT = Path(__file__).parents[2]

OF_ROLES = "the role of a part, which is called propulsion too"
OF_MANOEUVRES = "a manoeuvre of the simulator, which has the same name"
REGISTRIES: Mapping[str, tuple[Collection[str], Mapping[str, str]]] = {
    "captive kinds of test": (
        [name for name, kind in TEST_KINDS.own.items() if kind.captive],
        {
            "effects/definition.py": OF_ROLES,
            "effects/four_quadrant.py": OF_ROLES,
            "effects/propeller.py": OF_ROLES,
            "effects/tanker.py": OF_ROLES,
            "effects/waterjet.py": OF_ROLES,
            "testing/effects.py": OF_ROLES,
        },
    ),
    "free-running kinds of test": (
        [name for name, kind in TEST_KINDS.own.items() if kind.free_running],
        {
            **{
                f"actions/jobs/{name}.py": OF_MANOEUVRES
                for name in ("add", "estimate", "simulate", "sweep", "uncertainty")
            },
            "effects/waterjet.py": "a parameter of that name",
            "conventions/metrics.py": "manoeuvres by which the IMO judges",
            "cards/card.py": "manoeuvres of the poster of A.601(15)",
            "cards/fit.py": OF_MANOEUVRES,
            "plotting/time_series.py": "ways to draw a manoeuvre",
            "simulation/bands.py": OF_MANOEUVRES,
            "simulation/ensemble.py": OF_MANOEUVRES,
            "imo/judged.py": OF_MANOEUVRES,
            "simulation/kinds/pull_out.py": OF_MANOEUVRES,
            "simulation/kinds/speed.py": OF_MANOEUVRES,
            "simulation/kinds/spiral.py": OF_MANOEUVRES,
            "simulation/kinds/turning.py": OF_MANOEUVRES,
            "simulation/kinds/weave.py": OF_MANOEUVRES,
            "simulation/kinds/zigzag.py": OF_MANOEUVRES,
            "simulation/sweeps.py": OF_MANOEUVRES,
            "simulation/sensitivity.py": OF_MANOEUVRES,
            "simulation/single.py": OF_MANOEUVRES,
            "views/report/tables.py": "a run whose settings ask for nothing",
            "diagnosis/planning/planned_records.py": "which of them are offered",
            "diagnosis/free_running/disagreement.py": "what a window of a record is like",
            "workbench/desk.py": OF_MANOEUVRES,
            "views/pages/turning.py": OF_MANOEUVRES,
        },
    ),
}
OTHER_WORDS = "not the part: a word of files, options or columns that is spelled like it"
BY_NAME = "the part itself, for its own numbers"
EVERY = catalogue().values()


def files_in(folder: str) -> frozenset[str]:
    """The modules of a folder of the package."""
    paths = (ROOT / "pmmkit" / folder).rglob("*.py")
    return frozenset(path.relative_to(ROOT / "pmmkit").as_posix() for path in paths)


OF_EFFECTS = ("effects and faults that a diagnosis asks for", "parts of models")
REGISTRIES = {
    **REGISTRIES,
    "effects and faults that a diagnosis asks for": (
        [x.name for x in EVERY if x.coefficients or x.moves],
        {
            "diagnosis/free_running/hypotheses.py": "what records hold: a wind",
            "identification/chosen.py": OTHER_WORDS,
            "identification/methods.py": OTHER_WORDS,
            "seakeeping/explanation.py": "a number of the loading of that name",
            "simulation/kinds/manoeuvre.py": OTHER_WORDS,
            "imo/conditions.py": "conditions of the standard",
            "identification/trials/table.py": "what a trial corrects",
            "validation/prediction.py": OTHER_WORDS,
        },
    ),
    "parts of models": (
        [x.name for x in EVERY if x.enters and not x.coefficients],
        {
            "campaigns/file/particulars.py": OTHER_WORDS,
            "cards/card.py": OTHER_WORDS,
            "cards/fit.py": BY_NAME,
            "campaigns/file/schema.py": OTHER_WORDS,
            "campaigns/file/search.py": OTHER_WORDS,
            "campaigns/file/single_tables.py": OTHER_WORDS,
            "campaigns/run_settings.py": OTHER_WORDS,
            "diagnosis/captive/base.py": "what runs hold: roll",
            "diagnosis/free_running/hypotheses.py": "what records hold: roll",
            "equations/code_generation.py": "a variable of that name",
            "equations/layouts.py": "a constant and an input of that name",
            "exports/campaign_csv.py": OTHER_WORDS,
            "exports/matlab/model.py": "each part is written in MATLAB by hand",
            "exports/shipmmg.py": "the parts that shipmmg knows",
            "identification/binding.py": "the role of that name",
            "identification/sparse/request.py": OTHER_WORDS,
            "models/scale.py": BY_NAME,
            "reduction/parts.py": BY_NAME,
            "seakeeping/transfer.py": "a motion of that name",
            "seakeeping/transfer_files.py": "a variable of capytaine of that name",
            "simulation/single.py": BY_NAME,
            "testing/effects.py": "what records hold: roll",
            "validation/prediction.py": OTHER_WORDS,
        },
    ),
}
"""Names of a registry, and the files of the package in which they may stand, with the reason."""
BY_REGISTRY: Mapping[str, Collection[str]] = {
    "captive kinds of test": (
        "diagnosis/captive/standard.py",
        "intake/checks/motion.py",
        "intake/checks/scales.py",
        "intake/checks/signs.py",
        "intake/checks/stated.py",
        "intake/checks/untold.py",
        "intake/drafts/draft.py",
        "intake/drafts/motion.py",
        "models/model.py",
        "models/revise.py",
    ),
    "free-running kinds of test": (
        "identification/trials/drawing.py",
        "identification/trials/evaluate.py",
        "identification/trials/loading.py",
        "identification/trials/table.py",
        "intake/drafts/motion.py",
        "intake/drafts/names.py",
        "views/figures/comparison.py",
        "views/report/imo_form/filled.py",
    ),
    "effects and faults that a diagnosis asks for": (
        "diagnosis/captive/system.py",
        "diagnosis/planning/planned_records.py",
        "seakeeping/second_order/in_manoeuvre.py",
        "equations/prepared.py",
    ),
    "parts of models": (
        "actions/jobs/add.py",
        "api.py",
        "diagnosis/captive/refit.py",
        "identification/roll.py",
        "models/build.py",
        "models/estimates.py",
        "models/model.py",
        "models/part.py",
        "models/particulars.py",
        "models/revise.py",
        "models/stated_parts.py",
        "equations/prepared.py",
        "equations/structure.py",
        "simulation/machinery.py",
        "simulation/straight.py",
    ),
}
"""Files that ask a registry for an entry by its name, or compare with it: the doors of rooms give
no constant for each entry. A name that is not there is an error when it is asked. This list only
shrinks: what is asked is better a property of the entry."""
REGISTRIES = {
    name: (names, {**allowed, **dict.fromkeys(BY_REGISTRY[name], "asked by its name")})
    for name, (names, allowed) in REGISTRIES.items()
}


@cache
def strings_in(source: str) -> tuple[tuple[int, str], ...]:
    """Lines of some code, and the strings that stand there, docstrings left out."""
    nodes = [*ast.walk(ast.parse(source))]
    texts = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    return tuple(
        sorted(
            (node.lineno, node.value)
            for node in nodes
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in texts
        )
    )


def named_in(source: str, names: Collection[str]) -> list[tuple[int, str]]:
    """Lines of some code, and the names that stand there as strings."""
    wanted = set(names)
    return [item for item in strings_in(source) if item[1] in wanted]


def astray(
    folder: Path, names: Collection[str], allowed: Collection[str], homes: Collection[str] = ()
) -> list[str]:
    """Names outside the files in which they may stand, and files that may hold one and do not."""
    found, used = [], set()
    for path in sorted(folder.rglob("*.py")):
        place = path.relative_to(folder).as_posix()
        hits = named_in(path.read_text(encoding="utf-8"), names)
        if place in allowed:
            used |= {place} if hits else set()
        elif place not in homes:
            found += [f"{place}:{line} names {name!r}" for line, name in hits]
    return found + [f"{place} need not be listed" for place in sorted(set(allowed) - used)]


@pytest.mark.slow
@pytest.mark.parametrize("registry", REGISTRIES)
def test_names_stand_where_they_may(registry: str) -> None:
    names, allowed = REGISTRIES[registry]
    homes = files_in("effects" if registry in OF_EFFECTS else "campaigns/test_kinds")
    assert astray(ROOT / "pmmkit", names, allowed, homes) == []


def test_parts_of_models_stand_in_few_files() -> None:
    """Who needs the numbers of a part names it; who asks what it does asks for its role."""
    names, allowed = REGISTRIES["parts of models"]
    files = {
        name: [
            place
            for place, reason in allowed.items()
            if reason == BY_NAME
            and named_in((ROOT / "pmmkit" / place).read_text(encoding="utf-8"), [name])
        ]
        for name in names
    }
    assert {name: places for name, places in files.items() if len(places) > 5} == {}


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
