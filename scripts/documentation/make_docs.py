"""Write what docs/ takes from the program: effects, checks, rooms and the README's pictures.

    python -m scripts.documentation.make_docs [--check]

With --check nothing is written, and the exit status is 1 if a page is out of date. Published
figures beside ours (docs/validation*.md) are made by python -m scripts.validation.
"""

from __future__ import annotations

import argparse
import sys
from functools import cache
from pathlib import Path

import pmmkit as pk
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.diagnosis.captive.standard import FROUDE, LENGTH
from pmmkit.effects import CATALOGUE, Effect
from pmmkit.files import datasets_folder, write_text
from pmmkit.intake.checks import CHECKS
from pmmkit.models import load_model
from pmmkit.plotting import trajectory
from pmmkit.views.figures.derivatives import derivatives_over_froude
from scripts.documentation import actions, campaign_file, figures, manoeuvres, rooms
from scripts.documentation.fences import page
from scripts.documentation.signatures import Signature, signatures

DOCS = Path(__file__).parents[2] / "docs"

EFFECTS_HEAD = """\
# Effects

The catalogue in `pmmkit/effects/`: parts that a model can have, effects that a diagnosis looks for,
and faults of a measurement that it weighs against them. A model file names a part as
`[effects.NAME]` and gives its values and options; `pk.with_effect` puts in what a diagnosis names.
[own_effects.md](own_effects.md) tells how to add your own. This page is generated from the
catalogue by `scripts/documentation/make_docs.py`.

"Seen in" is generated from the definition: an effect of usual size in standard tests of the S175 at
Fn 0.145, 0.217 and 0.29, in percent of the rms force of the channel. C0 is the mean, C1, C2 … are
harmonics in phase with the velocity, S1, S2 … with the displacement; below 1 % nothing is said.
"Mimicked by" names effects that reproduce 60 % or more of what a cubic hull leaves of it there.
Coefficients are those of the prime system with the speed of the instant, Coriolis terms inside.
"""
SECTIONS = {
    "Parts of a model": lambda effect: effect.enters and not effect.coefficients,
    "Effects that a diagnosis looks for": lambda effect: (
        not effect.faulty and bool(effect.coefficients or effect.moves)
    ),
    "Faults of a measurement": lambda effect: effect.faulty,
}
KINDS = {
    "freed": "values of another part that may be off",
    "terms": "derivatives of the hull polynomial (of the rudder's where there is one)",
    "fault": "fault of a measurement, never part of a model",
}

CHECKS_HEAD = """\
# Checks

This page is generated from the checks and their texts by `scripts/documentation/make_docs.py`.

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
`moment_reference_x = …`). [cases.md](cases.md) tells how that looks for a laboratory's data.

## Overruling a check

Any refusal or warning can be accepted, with the reason, for the runs that it names (for
`runs = ["*"]` also where it names none). It becomes a remark, and the reason stands in the report:

```toml
[[corrections]]
runs = ["SW_1.5_*"]
action = "accept"
check = "agreement"
reason = "bilge keels were mounted for these runs only"
```

## What a record tells by itself

`late channels` tells a channel that is late or early by one to three whole samples from some time
on, as where a logger lost or repeated a value. A change of size or of form, a phase that creeps,
and parts of a sample are none. It takes three cycles of 16 samples or more; one sample is mostly
hidden in white noise of 10 % of the amplitude at 300 samples a cycle, of 5 % at 1000, and in slower
noise sooner ([evidence](evidence.md#is-a-channel-told-that-loses-a-value)). What is late throughout
has the phase of damping and added mass: no record tells it alone, but `agreement` with other runs
may.

## How runs are held against one another

The check `agreement` fits a polynomial of third order (with moduli) to the harmonics of all runs of
a speed, with the derivatives that hulls of these particulars usually have as its prior. Runs that
the others do not predict within the scatter that a good laboratory has (gain 0.7 %, zero 0.6 % of
the channel's size, as much for what no such polynomial holds) are left out one by one; then each is
asked what slip or fault would bring it to agree. If more than two are at odds, or the derivatives
or the scatter are unlike a hull's, the same is asked of all runs together. Where all of them are of
one kind of test, speed, side or part of the day that reads otherwise than the rest (by a gain, an
offset or a slope in the drift), the group is told in their place; and also where no run is at odds
([theory](theory/evidence.md#runs-that-disagree)). What is asked:

- units (kgf, lbf, lbf ft), signs, half of the hull, Y and N exchanged, forces or velocities along
  and across the tank, the record of another run, half a cycle, amplitudes stated peak to peak,
  drift to the other side: slips, refused where the evidence is overwhelming (20 to the base e);
- gains, lags in seconds, phases and filters, of all forces or of one, clocks that start when they
  like, amplitude, drift, the points of motion and of moments, the mass of the model, an amplifier
  that bends: faults, named from 9 to the base e on.

All of them are entries of the [catalogue of effects](effects.md), each with one action on a
record: what a laboratory with this fault would have written down. The checks try its values, the
diagnosis its slope; an entry of your own is found without being told
([own_effects.md](own_effects.md)).

Causes that the runs cannot tell from the best are named beside it. A gain, unit or length that is
off in all runs alike, and Izz, show in no comparison of runs: the notes of every table say so, and
what would check them.

`python -m scripts.studies.spoiled` puts 50 ways to spoil a campaign into the virtual tank, in one
run and in all, and counts what is refused, named, or reduced in silence, and the alarms of clean
campaigns.
"""


def effect_page(effect: Effect, signature: Signature | None = None) -> str:
    lines = [f"### `{effect.name}`", "", effect.summary, ""]
    kind = KINDS.get(effect.kind, effect.kind)
    source = f" Source: {effect.source}." if effect.source else ""
    lines.append(f"Family {effect.family}, kind {kind}.{source}")
    if effect.options:
        lines.append("")
        lines += [
            f"- `{name}`: {', '.join(f'`{choice}`' for choice in choices)} (default the first)"
            for name, choices in effect.options.items()
        ]
    if effect.parameters:
        heads, rows = effect.parameter_table()
        lines += ["", f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
        lines += [f"| `{name}` | {' | '.join(cells)} |" for name, *cells in rows]
    if effect.derivatives:
        lines += ["", "Takes derivatives by name."]
    lines += ["", effect.asked] if effect.asked else []
    lines += ["", effect.suspected] if effect.suspected else []
    if effect.check:
        lines += ["", f"To be sure: {effect.check}."]
    return "\n".join([*lines, *(signature_lines(signature) if signature else ())])


def signature_lines(signature: Signature) -> list[str]:
    lines = []
    if signature.absorbed:
        lines += ["", "No residual shows it: the derivatives of the hull take it over."]
    elif signature.mimics:
        mimics = ", ".join(f"`{name}`" for name in signature.mimics)
        lines += ["", f"Mimicked by: {mimics}."]
    if signature.acts:
        lines += ["", "| seen in | X | Y | N |", "|---|---|---|---|"]
    for test, channels in signature.acts.items():
        cells = [
            " ".join(f"{label} {100 * x:+.0f}" for label, x in channels.get(name, {}).items())
            for name in ("X", "Y", "N")
        ]
        lines.append(f"| {test.replace('_', ' ')} | {' | '.join(cells)} |")
    return lines


@cache
def known_signatures() -> dict[str, Signature]:
    speed = load_model("s175-3dof").ship.speed(FROUDE[-1]) * (LENGTH / 175.0) ** 0.5
    every = [item for item in captive_candidates((speed,)) if not item.each_run]
    return {item.name: item for item in signatures(every)}


WITHOUT_ENTRY = {
    "munk_moment": "It stands in Nv, Yr and Xvr, from which no run of a rigid hull tells it. "
    "Compare Nv with strip theory.",
    "appendage_lift": "Lift goes with u v and u r, as Yv, Yr, Nv and Nr do. Runs with and "
    "without the appendages tell it.",
    "bank_suction": "Tests in the middle of a tank have no bank, and records do not say how far "
    "one is.",
    "blockage": "The reduction corrects it from the tank's width and depth; in one tank no "
    "residual is left of it.",
    "tank_waves": "Waves of earlier runs have another phase in each run: whole cycles average "
    "them out, what is left is noise between the harmonics. Wait longer.",
    "engine_limit": "Records hold the revolutions, so the engine is not asked. In a model it is "
    "the part `shaft`.",
    "rudder_rate": "Records hold the rudder, so its gear is not asked. In a model it is "
    "`rate_deg_s` of the rudder.",
    "fault_units": "Refused before anything is fitted: see [checks.md](checks.md).",
}
"""Effects of the literature that no residual can show here, and why."""


def without_entry() -> str:
    rows = "\n".join(f"| {name} | {why} |" for name, why in WITHOUT_ENTRY.items())
    return f"## Effects without an entry\n\n| effect | why |\n|---|---|\n{rows}"


def effects_page() -> str:
    found = known_signatures()
    sections = [
        f"## {title}\n\n"
        + "\n\n".join(effect_page(x, found.get(x.name)) for x in CATALOGUE.values() if chosen(x))
        for title, chosen in SECTIONS.items()
    ]
    return f"{EFFECTS_HEAD}\n" + "\n\n".join([*sections, without_entry()]) + "\n"


TABLES = actions.TABLES | campaign_file.TABLES | manoeuvres.TABLES | figures.TABLES


def pages() -> dict[str, str]:
    checks = "\n".join(f"| {check.name} | {check.description} |" for check in CHECKS.values())
    return {
        "effects.md": effects_page(),
        "checks.md": f"{CHECKS_HEAD}{checks}\n{CHECKS_TAIL}",
        "architecture.md": rooms.page(),
        **{name: page(name, made) for name, made in TABLES.items()},
    }


def pictures() -> None:
    """The derivatives of datasets/s175 over the Froude number, turns, and one in motion."""
    table = pk.reduce(pk.open_campaign(datasets_folder() / "s175"))
    model = pk.to_model(table, parts="s175-3dof")
    speeds = (6.0, 9.0, 12.0)
    tracks = [pk.simulate(model, "turning", rudder_deg=35, speed=speed) for speed in speeds]
    shown = table.select(["Yv", "Yr", "Yvvv", "Yvrr", "Nv", "Nr", "Nrrr", "Nvvr"])
    derivatives_over_froude(shown).save(DOCS / "images" / "derivatives.png")
    names = [f"{speed:g} m/s, Fn {model.ship.froude(speed):.3f}" for speed in speeds]
    trajectory(tracks, names).save(DOCS / "images" / "turning.png")
    turn = pk.simulate("s175", "turning", rudder_deg=35, speed=6.0, forces=True)
    turn.animate(DOCS / "images" / "turn.gif", frames=50)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing, name stale pages")
    only_checked = parser.parse_args().check
    stale = [
        name
        for name, text in pages().items()
        if not (DOCS / name).is_file() or (DOCS / name).read_text(encoding="utf-8") != text
    ]
    if only_checked:
        for name in stale:
            print(f"docs/{name} is out of date: run python -m scripts.documentation.make_docs")
        return 1 if stale else 0
    for name, text in pages().items():
        write_text(DOCS / name, text)
    pictures()
    return 0


if __name__ == "__main__":
    sys.exit(main())
