"""Write what docs/ takes from the program: effects.md, checks.md and the README's pictures.

    python scripts/make_docs.py [--check]

With --check nothing is written, and the exit status is 1 if a page is out of date.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pmmkit as pk
from pmmkit.checks import CHECKS
from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.effect import Effect, Parameter
from pmmkit.figures import style
from pmmkit.figures.derivatives import derivatives_over_froude
from pmmkit.figures.turns import trajectory
from pmmkit.files import datasets_folder, write_text

DOCS = Path(__file__).parents[1] / "docs"

EFFECTS_HEAD = """\
# Effects

The parts that a model can have, from the catalogue in `pmmkit/effects/`. A model file names an
effect as `[effects.NAME]` and gives its values and options. `scripts/make_docs.py` makes this page.
"""

CHECKS_HEAD = """\
# Checks

Data that contradict themselves, or the campaign file, are refused before anything is fitted; every
contradiction is listed at once, with its numbers and what would mend it. What is only suspicious
is a warning and stands in the report.

    pmmkit check my-campaign

```python
import pmmkit as pk

for finding in pk.examine(pk.open_campaign("datasets/s175")):
    print(finding)
```

| check | what it looks at |
|---|---|
"""

CHECKS_TAIL = """
A contradiction that you can explain goes into the campaign file as a `[[corrections]]` with its
reason, or as the right statement (`forces = "balance"`, `rudder_positive = "port"`,
`moment_reference_x = …`). [kvlcc2.md](kvlcc2.md) tells how that looks for a laboratory's data.
"""


def parameter_row(parameter: Parameter) -> str:
    default = "required" if parameter.default is None else f"{parameter.default:g}"
    return f"| `{parameter.name}` | {parameter.text} | {parameter.unit} | {default} |"


def effect_page(effect: Effect) -> str:
    lines = [f"## `{effect.name}`", "", effect.summary, ""]
    lines.append(f"Family {effect.family}, kind {effect.kind}. Source: {effect.source}.")
    if effect.options:
        lines.append("")
        lines += [
            f"- `{name}`: {', '.join(f'`{choice}`' for choice in choices)} (default the first)"
            for name, choices in effect.options.items()
        ]
    if effect.parameters:
        lines += ["", "| parameter | meaning | unit | default |", "|---|---|---|---|"]
        lines += [parameter_row(parameter) for parameter in effect.parameters]
    if effect.derivatives:
        lines += ["", "Takes derivatives by name."]
    return "\n".join(lines)


def pages() -> dict[str, str]:
    effects = "\n\n".join(effect_page(effect) for effect in catalogue().values())
    checks = "\n".join(f"| {check.name} | {check.description} |" for check in CHECKS)
    return {
        "effects.md": f"{EFFECTS_HEAD}\n{effects}\n",
        "checks.md": f"{CHECKS_HEAD}{checks}\n{CHECKS_TAIL}",
    }


def pictures() -> None:
    """The derivatives of datasets/s175 over the Froude number, and the turns they lead to."""
    table = pk.reduce(pk.open_campaign(datasets_folder() / "s175"))
    model = pk.to_model(table, parts="s175-3dof")
    speeds = (6.0, 9.0, 12.0)
    tracks = [pk.simulate(model, "turning", rudder_deg=35, speed=speed) for speed in speeds]
    shown = table.select(["Yv", "Yr", "Yvvv", "Yvrr", "Nv", "Nr", "Nrrr", "Nvvr"])
    style.save(derivatives_over_froude(shown), DOCS / "images" / "derivatives.png")
    names = [f"{speed:g} m/s, Fn {model.ship.froude(speed):.3f}" for speed in speeds]
    style.save(trajectory(tracks, names), DOCS / "images" / "turning.png")


def main() -> int:
    stale = [
        name
        for name, text in pages().items()
        if not (DOCS / name).is_file() or (DOCS / name).read_text(encoding="utf-8") != text
    ]
    if "--check" in sys.argv:
        for name in stale:
            print(f"docs/{name} is out of date: run python scripts/make_docs.py")
        return 1 if stale else 0
    for name, text in pages().items():
        write_text(DOCS / name, text)
    pictures()
    return 0


if __name__ == "__main__":
    sys.exit(main())
