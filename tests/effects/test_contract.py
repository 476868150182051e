"""Every effect holds what an effect promises, and what does not is noticed."""

from __future__ import annotations

from contextlib import ExitStack, contextmanager
from dataclasses import replace
from types import MappingProxyType, SimpleNamespace
from unittest import mock

import pytest

from pmmkit import Effect, Parameter, catalogue, effect, own_effect, register_effect
from pmmkit.effects import CATALOGUE, Move, Suspect
from pmmkit.effects.entries import GROUP
from pmmkit.effects.primitives import fabs, maximum
from pmmkit.equations import Prepared
from pmmkit.models import Part, load_model
from pmmkit.testing import effects as contract
from pmmkit.testing.effects import check_effect


def holding(ship, *, without=(), **parts):
    """A library ship with parts that none of the library has."""
    model = load_model(ship)
    own = {
        name: Part(effect=name, values=MappingProxyType(values)) for name, values in parts.items()
    }
    kept = {name: part for name, part in model.parts.items() if name not in without}
    return model.with_(parts=MappingProxyType({**kept, **own}))


SQUAT = {"sinkage_per_Fn2": 0.3, "trim_deg_per_Fn2": -2.0}
SCREW = {"D": 6.533, "t": 0.175, "wp": 0.184, "xp": -0.526, "kt0": 0.527, "kt1": -0.455}
DIESEL = {"inertia": 1e5, "torque_max": 8e5, "time_constant": 2.0}
JET = {"number": 3.0, "nozzle": 0.9, "D": 1.9, "phi0": 0.62, "w": 0.05, "rate_deg_s": 10.0}
MODELS = {
    "squat": lambda: holding("s175", squat=SQUAT),
    "sinkage_trim": lambda: holding("s175", squat=SQUAT),
    "four_quadrant_propeller": lambda: holding(
        "s175", without=["propeller"], four_quadrant_propeller=SCREW
    ),
    "shaft": lambda: holding("s175", shaft=DIESEL),
    "waterjet": lambda: holding("s175", without=["propeller", "rudder_mmg"], waterjet=JET),
}


@pytest.mark.parametrize("name", list(catalogue()))
def test_every_effect_of_the_catalogue(name):
    check_effect(CATALOGUE[name], MODELS[name]() if name in MODELS else None)


# Effects of a user


def keel(v, U, L, rho, size, edge):
    """Drag of a keel beyond some drift."""
    past = maximum(fabs(v / U) - edge, 0.0)
    return (0.5 * rho * L * L * U * v * past * size,)


KEEL = Effect(
    name="keel_of_a_test",
    family="own",
    kind="force",
    summary="Drag of a keel beyond some drift.",
    parameters=(
        Parameter(name="size", text="over ½ρL²", typical=-0.01),
        Parameter(name="edge", text="where it begins, v/U", grid=(0.02, 0.05, 0.1)),
    ),
    force=keel,
    outputs=("Y",),
    check="static drift in steps of 1°",
)


@contextmanager
def registered(entry):
    register_effect(entry)
    try:
        yield entry
    finally:
        CATALOGUE.forget(entry.name)


def test_an_effect_by_the_decorator():
    try:
        made = effect(
            name="keel_of_a_test",
            family="own",
            outputs=("Y",),
            parameters=KEEL.parameters,
            check=KEEL.check,
        )(keel)
        check_effect(made)
    finally:
        CATALOGUE.forget("keel_of_a_test")


def test_an_effect_by_text():
    check_effect(
        own_effect(
            "late_skeg_of_a_test",
            "Y: a*lag(beyond(v, edge), 0.4); N: b*Fn*lag(beyond(v, edge), 0.4); a ~ -0.01;"
            "b ~ -0.005; edge ~ [0.02, 0.05]",
            summary="A skeg that is late.",
        )
    )


def test_an_effect_of_an_installed_package():
    offered = [SimpleNamespace(name="keels", value="keels:KEEL", load=lambda: (KEEL,))]
    CATALOGUE.reload()
    try:
        with mock.patch(
            "importlib.metadata.entry_points", lambda group: offered if group == GROUP else []
        ):
            assert CATALOGUE[KEEL.name] is KEEL
            check_effect(KEEL)
    finally:
        CATALOGUE.reload()


@pytest.mark.slow
def test_an_effect_of_a_package_is_not_the_one_that_was_forgotten():
    """Equations that were made of a registered effect of the same name are not taken for it."""
    wrong = late(lambda v, U, L, s: (v + s) * U / L)
    with registered(wrong), pytest.raises(AssertionError, match="does not settle"):
        check_effect(wrong)
    test_an_effect_of_an_installed_package()


# Effects that are wrong


def force_of(function, **more):
    return replace(KEEL, force=function, **more)


def sized(**more):
    return replace(KEEL, parameters=(replace(KEEL.parameters[0], **more), KEEL.parameters[1]))


def gridded(*grid, **more):
    return replace(
        KEEL, parameters=(KEEL.parameters[0], replace(KEEL.parameters[1], grid=grid, **more))
    )


def own(name, typical=0.1):
    return Parameter(name=name, text="", typical=typical)


def gridded_at(name):
    return Parameter(name=name, text="", grid=(0.1, 0.2))


def late(rate):
    def force(v, U, L, rho, s, size):
        return 0.5 * rho * L * L * U * s * size, rate(v, U, L, s)

    return replace(
        KEEL, kind="state", states=("s",), outputs=("Y", "s_rate"), force=force,
        parameters=KEEL.parameters[:1],
    )  # fmt: skip


def of_kind(kind, **more):
    bare = {"force": None, "outputs": (), "parameters": (own("Yvv"),), "not_captive": "a reason"}
    return replace(KEEL, kind=kind, **(bare | more))


def nothing(run, at):
    return {"Y": run.forces["Y"] + at["Yvv"] * run.project(0.0 * run.t)}


def infinite(run, at):
    return {"Y": run.forces["Y"] + at["Yvv"] * float("nan")}


def squared(run, at):
    return {"Y": (1.0 + at["Yvv"] ** 2) * run.forces["Y"]}


def always(run, at):
    return {"Y": 1.1 * run.forces["Y"]}


def short(run, at):
    return {"Y": run.forces["Y"][:0]}


def a_fault(acts, **more):
    return of_kind("fault", acts=acts, not_captive="", not_free_running="a reason", **more)


def as_suspect(**more):
    return Suspect(name="keel", says=lambda _: "it is so", remedy="Mend it.", **more)


def aside(vessel):
    return {"a": Move(values={"propeller.wp": 0.0, "propeller.colour": 1.0}, typical=0.1)}


def crossed(v, a, b):
    """Linear in each alone, yet not the sum."""
    return (v * (a + b + (a * b) / (fabs(a) + fabs(b) + 1e-300)),)


WRONG = {
    "name": (replace(KEEL, name="Keel"), "of small letters"),
    "family": (replace(KEEL, family="My own"), "of small letters"),
    "summary": (replace(KEEL, summary="Drag. Of a keel."), "is no sentence"),
    "no summary": (replace(KEEL, summary=""), "no summary"),
    "sources": (replace(KEEL, sources=("hearsay_2020",)), "hearsay_2020 are not in the"),
    "check": (replace(KEEL, check=""), "no check is named"),
    "excites": (replace(KEEL, excites=("sun",)), "sun are no words"),
    "unit": (sized(unit="knots"), "'knots' of size is not known"),
    "usual size": (sized(low=0.0), "outside its limits"),
    "usual size of nothing": (sized(typical=0.0), "is zero"),
    "grid": (gridded(0.1, 0.05), "does not ascend"),
    "limits of a grid": (gridded(0.05, 0.1, high=0.07), "beyond its limits"),
    "default": (sized(default=5.0, high=1.0), "default of size is outside"),
    "form": (sized(form=("shape", "round")), "that there is not"),
    "argument's name": (sized(name="my size"), "no name of an argument"),
    "twice": (replace(KEEL, parameters=KEEL.parameters[:1] * 2), "size comes twice"),
    "two grids": (
        replace(KEEL, parameters=(own("size"), gridded_at("a"), gridded_at("b"))),
        "more than one parameter",
    ),
    "kind": (replace(KEEL, kind="wish"), "no kind 'wish'"),
    "no force": (replace(KEEL, force=None, outputs=()), "neither a force nor a role"),
    "no outputs": (replace(KEEL, outputs=()), "a force needs outputs"),
    "state": (replace(KEEL, kind="state"), "of kind state and has states none"),
    "rates": (replace(KEEL, states=("s",)), "rates are of others"),
    "mass": (replace(KEEL, kind="mass"), "no share of the mass matrix"),
    "role": (replace(KEEL, outputs=("thrust",)), "has not the role propulsion"),
    "terms": (of_kind("terms", parameters=(own("Yqq"),)), "Yqq"),
    "no terms": (of_kind("terms", parameters=()), "stands for no derivatives"),
    "terms with a force": (of_kind("terms", force=keel, outputs=("Y",)), "and has a force"),
    "freed": (of_kind("freed", frees="keel"), "no part of a model"),
    "freed value": (of_kind("freed", frees="propeller"), "propeller has no Yvv"),
    "fault": (of_kind("fault", not_captive="", not_free_running="a reason"), "does not act on"),
    "fault at sea": (of_kind("fault", acts=nothing), "free-running records cannot be asked"),
    "acts": (replace(KEEL, acts=nothing), "acts on records and is no fault"),
    "fault without a size": (
        of_kind("fault", acts=nothing, parameters=(), not_captive=""),
        "it has no size",
    ),
    "suspect": (
        a_fault(nothing, suspects=(as_suspect(at=lambda value: {"colour": value}),)),
        "suspected by colour",
    ),
    "suspect of unknown size": (
        a_fault(nothing, suspects=(as_suspect(unknown="weight"),)),
        "suspected by weight",
    ),
    "proportion": (a_fault(squared), "not in proportion to Yvv"),
    "at zero": (a_fault(always), "where Yvv is zero"),
    "argument": (force_of(lambda v, size, colour: (v * size,)), "nobody gives the force colour"),
    "asked": (
        of_kind("freed", frees="hull_polynomial", parameters=(), moves=aside, not_captive=""),
        "captive tests cannot be asked",
    ),
    "reason for nothing": (
        replace(KEEL, parameters=(), not_captive="a reason"),
        "has nothing to ask for",
    ),
    "outputs' number": (force_of(lambda v, size, rho, L: (v * size, rho, L)), "and gives 3"),
    "not finite": (
        force_of(lambda v, size: (v * size * (1e308 * 10.0 * v),), parameters=KEEL.parameters[:1]),
        "not finite at all motions",
    ),
    "arrays": (
        force_of(lambda v, size: (size * min(abs(v), 1.0) if isinstance(v, float) else size * v,)),
        "of arrays is not that of single numbers",
    ),
    "square": (force_of(lambda v, size: (v * size * size,)), "not linear in size"),
    "modulus": (force_of(lambda v, size: (v * fabs(size),)), "not linear in size"),
    "offset": (force_of(lambda v, size: (v * (1.0 + size),)), "at zero there is a force"),
    "product": (
        replace(KEEL, parameters=(own("a"), own("b")), force=crossed),
        "not the sum",
    ),
    "nonlinear rate": (
        late(lambda v, U, L, s: (v - s * s) * U / L),
        "not linear in it",
    ),
    "growing state": (late(lambda v, U, L, s: (v + s) * U / L), "s does not settle"),
    "Froude": (force_of(lambda v, size, rho, L: (rho * L * v * fabs(v) * size,)), "Froude's law"),
    "no ship": (
        sized(typical=None),
        "no ship of the library takes it",
    ),
    "idle": (a_fault(nothing), "acts in no standard test"),
    "infinite": (a_fault(infinite), "are not finite"),
    "shape": (a_fault(short), "has the shape"),
    "moves": (
        of_kind("freed", frees="propeller", parameters=(), moves=aside),
        "moves propeller.colour",
    ),
    "moves nothing": (
        of_kind("freed", frees="propeller", parameters=(), moves=lambda vessel: {}),
        "has a place in no ship",
    ),
}  # fmt: skip
"""An effect that breaks one rule, and what is said of it."""
SIMULATED = ("nonlinear rate", "growing state")
"""Rules that are seen in a simulation alone."""


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    "rule",
    [pytest.param(rule, marks=pytest.mark.slow) if rule in SIMULATED else rule for rule in WRONG],
)
def test_what_does_not_hold_is_noticed(rule):
    wrong, said = WRONG[rule]
    with ExitStack() as stack:
        if wrong.name.isidentifier():
            stack.enter_context(registered(wrong))
        with pytest.raises(AssertionError) as caught:
            check_effect(wrong)
    assert said in str(caught.value)


def test_compiled_equations_that_are_others_are_noticed():
    wrong = mock.patch.object(Prepared, "rates", lambda self, y, *controls: [1.0] * len(y))
    with wrong, pytest.raises(AssertionError, match="not those that are interpreted"):
        check_effect(CATALOGUE["memory"])


def test_an_effect_that_does_not_come_out_again_is_noticed():
    wrong = mock.patch.object(contract, "without_effect", lambda model, name: model)
    with wrong, pytest.raises(AssertionError, match="taken out again"):
        check_effect(CATALOGUE["memory"])


def test_all_faults_are_told_at_once():
    with pytest.raises(AssertionError, match=r"is no sentence(.|\n)*does not ascend"):
        check_effect(replace(gridded(0.2, 0.1), summary="A keel"))
