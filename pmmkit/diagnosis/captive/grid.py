"""The grid points of an effect that explain most."""

from __future__ import annotations

from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.captive.evidence import evidence_of
from pmmkit.diagnosis.captive.system import CandidateColumns, System


def best_blocks(system: System, name: str, count: int = 1) -> list[CandidateColumns]:
    """The grid points of an effect that explain most by themselves, the best first."""
    own = [block for block in system.blocks if block.candidate.name == name]
    if not own:
        raise no_such_effect(name, (block.candidate.name for block in system.blocks))
    return sorted(own, key=lambda b: -evidence_of(system, b))[:count]
