"""``[axes]`` and ``[cfd]`` of a draft: what forces that were computed need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pmmkit.campaigns import TEST_KINDS
from pmmkit.intake.drafts.columns import Todo, aligned, commented, toml
from pmmkit.intake.drafts.conventions import Proposal
from pmmkit.intake.drafts.draft import RunDraft
from pmmkit.presentation import printable


@dataclass(frozen=True, kw_only=True)
class Computed:
    """What ``[cfd]`` says, as far as it is known.

    `every`: what all runs have alike. `of_kind`: what all runs of a kind of test have alike
    besides.
    """

    every: Mapping[str, Any] = field(default_factory=dict)
    of_kind: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def own(self, run: RunDraft) -> dict[str, Any]:
        """What is left for the run itself to say."""
        said = {**self.every, **self.of_kind.get(run.test or "", {})}
        return {key: value for key, value in run.computation.items() if said.get(key) != value}


def computed_in(runs: Sequence[RunDraft]) -> Computed:
    """What computations say alike, taken together."""
    every = _alike(runs)
    of_kind = {}
    for test in dict.fromkeys(run.test for run in runs if run.test is not None):
        group = [run for run in runs if run.test == test]
        own = {key: value for key, value in _alike(group).items() if key not in every}
        if own and len(group) > 1:
            of_kind[test] = own
    return Computed(every=every, of_kind=of_kind)


def _alike(runs: Sequence[RunDraft]) -> dict[str, Any]:
    return {
        key: value
        for key, value in runs[0].computation.items()
        if all(run.computation.get(key) == value for run in runs)
    }


def axes_lines(proposal: Proposal | None, todo: Todo, *, computed: bool) -> list[str]:
    """``[axes]``: what physics says of them, else what a person must say of a mesh."""
    found = None if proposal is None else proposal.convention
    if proposal is not None and found is not None and found.reversed_axes:
        lines = [f'{axis} = "-{axis}"' for axis in found.reversed_axes]
        return ["", aligned("[axes]", "proposed, see [campaign]"), *lines]
    remaining = [] if proposal is None else list(proposal.remaining)
    if remaining:
        assert proposal is not None
        todo.add(
            "[axes], signs: the forces of all runs leave several ways, listed in the file; which "
            "is so? Or do the moments refer to a point far from midship, or do oscillations "
            "begin at another phase (phase_deg)?"
        )
        listed = [f"#   {number}. {item}" for number, item in enumerate(remaining, start=1)]
        seen = commented(f"TODO axes and signs: {proposal.seen}.")
        asked = "# One of these, or moments about a point far from midship, or another phase_deg:"
        return ["", *seen, asked, *listed]
    if found is not None or not computed:
        return []
    todo.add("[axes] which way the axes of the mesh point.")
    return [
        "",
        "# [axes]                         # TODO of the mesh: which way theirs point, seen in ours",
        '# y = "-y"                       # x forward and z up: y to port (x aft, z up: x = "-x")',
        '# z = "-z"',
    ]


def cfd_lines(
    runs: Sequence[RunDraft], found: Computed, proposal: Proposal | None, todo: Todo
) -> list[str]:
    """``[cfd]``: what is known of the computation, and what is asked."""
    known = {key for run in runs for key in run.computation}
    along = proposal is not None and proposal.along_tank is not None
    oscillates = any(run.test is not None and TEST_KINDS[run.test].oscillates for run in runs)
    turned = "forces_in" in known if oscillates else along
    asked = "" if turned else "whether forces are along the hull, "
    todo.add(f"[cfd] the point of the moments, {asked}the start-up, half or whole ship.")
    lines = [
        f"{'' if found.every else '# '}[cfd]".ljust(33) + "# TODO of forces that were computed",
        *(
            aligned(f"{key} = {toml(value)}", "")
            for key, value in found.every.items()
            if key != "rho_inf"
        ),
        "# moment_centre = 0.0            # TODO where moments refer at rest, forward of midship",
        "# ramp_s = ...                   # TODO start-up of the computation, cut off every run",
        "# symmetry_factor = 2.0          # TODO if half a ship was computed",
        *_density(found.every.get("rho_inf"), todo),
        "# U_SN = { X = ..., Y = ..., N = ... }  # TODO numerical uncertainty [N, N m], if known",
    ]
    if not turned:
        lines += [
            '# forces_in = "earth"            # TODO if they stay along the tank while she moves',
            "# moment_centre_moves = false    # TODO if that point stays behind while she moves",
        ]
    if proposal is not None and proposal.why_along:
        lines.append(f"# {printable(_steady(runs))}: {printable(proposal.why_along)}")
    return lines


def _steady(runs: Sequence[RunDraft]) -> str:
    """Kinds of test with a constant drift angle, in words."""
    tests = dict.fromkeys(run.test for run in runs if run.test is not None)
    return ", ".join(test for test in tests if TEST_KINDS[test].steady)


def _density(rho_inf: float | None, todo: Todo) -> list[str]:
    if rho_inf is None:
        return [
            "# rho_inf = ...                  # TODO density of the computation, if it is another"
        ]
    if rho_inf != 1.0:
        return [aligned(f"rho_inf = {toml(rho_inf)}", "rhoInf beside the results")]
    todo.add("[cfd] rho_inf = 1: are the forces per density, or multiplied by it already?")
    why = "rhoInf beside the results: forces per density; TODO else take the line away"
    return [aligned("rho_inf = 1.0", why)]
