"""What Python takes by a keyword is what the command takes by the option of that name."""

from __future__ import annotations

import inspect

import pytest

import pmmkit as pk
from pmmkit.actions import action

WORDS = {
    "reduce": ("reduce", "reduce_campaign", "model_of"),
    "compare": ("compare", "compare_submission"),
    "diagnose": ("begin", "diagnose"),
    "add": ("begin", "fit"),
    "identify": ("identify", "compare_methods"),
    "simulate": ("simulate",),
    "sweep": ("sweep", "froude_sweep"),
    "uncertainty": ("monte_carlo", "sensitivities"),
    "stability": ("stability", "spiral_curve"),
    "imo": ("imo_verdicts",),
    "plan": ("plan", "next_runs"),
    "budget": ("reduce_campaign", "imo_budget", "manoeuvre_budget", "grid_study"),
    "scale": ("scaled", "full_scale"),
    "seakeeping": ("sea", "response", "rao"),
    "estimate": ("estimated_model",),
    "trial": ("evaluate_trials",),
    "card": ("ship_from_card",),
    "export": ("export",),
}
"""Public words that do the work of a command."""
NOTHING = (None, ())
"""What is absent, as one thing or as a list of things."""


@pytest.mark.parametrize(("name", "word"), [(name, x) for name, own in WORDS.items() for x in own])
def test_a_keyword_is_absent_as_its_option_is(name, word):
    settings = {item.name: item.default for item in action(name).fields}
    taken = inspect.signature(getattr(pk, word)).parameters
    shared = [item for item in taken.values() if item.name in settings]
    assert shared
    for item in shared:
        if item.default is inspect.Parameter.empty:
            continue
        here, there = settings[item.name], item.default
        assert here == there or (here in NOTHING and there in NOTHING), item.name
