"""Effects whose forces are terms that no base has."""

from __future__ import annotations

from pmmkit.diagnosis.captive.candidate import Candidate, of_terms


def polynomial(name, family, summary, sizes):
    """An effect whose forces are derivatives, each with its usual size."""
    terms = tuple({label: 1.0} for label in sizes)
    return Candidate(
        name=name,
        family=family,
        kind="physics",
        summary=summary,
        coefficients=tuple(sizes),
        typical=tuple(sizes.values()),
        columns=of_terms(terms),
        terms=terms,
    )
