"""Effects of the user as they take part."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pmmkit.conventions import bare, parse_derivative
from pmmkit.diagnosis.captive.base import Base
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.effects.own import OwnEffect
from pmmkit.numerics import Array
from pmmkit.observations.views import View


def candidate_of(effect: OwnEffect) -> Candidate:
    """What takes part in a contest, on equal terms with the catalogue."""
    labels = tuple(effect.shares)
    factors = {
        bare(x) for own in effect.shares.values() for n in own for x in parse_derivative(n).factors
    }

    def columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
        del value
        found: dict[str, Array] = {}
        for place, label in enumerate(labels):
            for name, share in effect.shares[label].items():
                if name[0] in view.force:
                    part = view.project(base.columns([name], view.motion, view.speed))
                    block = found.setdefault(name[0], np.zeros((view.rows, len(labels))))
                    block[:, place] += share * part[:, 0]
        return found

    needs = (("roll", {"p", "phi"}), ("rudder", {"d"}))
    return Candidate(
        name=effect.name,
        family=effect.family,
        kind="physics",
        summary=effect.summary,
        coefficients=labels,
        typical=tuple(effect.typical[label] for label in labels),
        columns=columns,
        check=effect.check,
        excites=tuple(word for word, asked in needs if asked & factors),
    )
