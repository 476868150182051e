"""What the catalogue says of an effect: all that anybody asks of it, in one place."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from inspect import signature
from itertools import pairwise
from types import MappingProxyType
from typing import Any, ClassVar, Final, Literal, get_args

import numpy as np

from pmmkit.base import UnknownNameError, did_you_mean
from pmmkit.conventions import cite, parse_derivative
from pmmkit.effects.primitives import over_arrays
from pmmkit.effects.seen import Acts, Forces, Move, Observed, Vessel
from pmmkit.effects.suspect import Suspect
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section

Kind = Literal["force", "mass", "state", "terms", "freed", "fault"]
Role = Literal[
    "hull", "inertia", "roll", "propulsion", "shaft", "steering", "wind", "waves", "depth"
]
"""What a part does for a ship: manoeuvres and tests ask for parts by their role."""
BY_SPEED: Final = " F"
"""Mark of a derivative that is multiplied by F = (Fn/Fn0)² - 1."""

_DIMENSIONS: Mapping[str, tuple[int, int, int]] = MappingProxyType(
    {
        "-": (0, 0, 0),
        "deg": (0, 0, 0),
        "m": (1, 0, 0),
        "m2": (2, 0, 0),
        "s": (0, 1, 0),
        "deg/s": (0, -1, 0),
        "1/s": (0, -1, 0),
        "m/s": (1, -1, 0),
        "N": (1, -2, 1),
        "N/min": (1, -3, 1),
        "N m": (2, -2, 1),
        "N m/min": (2, -3, 1),
        "W": (2, -3, 1),
        "kg m2": (2, 0, 1),
        "N m s": (2, -1, 1),
        "N m s2": (2, 0, 1),
    }
)
"""Powers of length, time and mass in each unit that a parameter may have."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One number that an effect takes.

    Parameters
    ----------
    name : str
        Name in model files.
    text : str
        What it is.
    unit : str
        Unit of the value, ``-`` for a plain number.
    default : float or None
        Value where a model gives none; None if it must be given.
    form : tuple of str, optional
        Option and the words with which the parameter is needed, e.g. ``("wake", "mmg")``.
    low, high : float
        Values outside are refused.
    table : bool
        Whether it holds a list of any length instead of one number.
    over : tuple of str
        Of a list: the lists, ascending, at whose values it stands; over two, a row over the second
        for each value of the first, one after the other.
    typical : float or None
        Usual size, signed where nature has a sign; None for what no diagnosis looks for.
    grid : tuple of float
        Values at which a diagnosis tries a parameter that does not act linearly; none for others.
    continuous : bool
        Whether values between those of the grid have a meaning.
    of_the_tests : bool
        Whether its grid is that of the speeds tested [m/s].
    expected : float
        Value about which a coefficient is expected, where that is not zero.
    step : float
        Of a coefficient of a fault: by how much it is moved to find what a unit of it does; 1 where
        it acts in proportion.
    uncertain : bool
        Whether no model knows it exactly, so that a fit to records may move it.
    """

    name: str
    text: str
    unit: str = "-"
    default: float | None = None
    form: tuple[str, ...] | None = None
    low: float = -1e12
    high: float = 1e12
    table: bool = False
    over: tuple[str, ...] = ()
    typical: float | None = None
    grid: tuple[float, ...] = ()
    continuous: bool = True
    of_the_tests: bool = False
    expected: float = 0.0
    step: float = 1.0
    uncertain: bool = False

    @property
    def scaling(self) -> float:
        """Power of the length scale by which the value grows under Froude's law.

        Examples
        --------
        >>> Parameter(name="D", text="diameter", unit="m").scaling
        1.0
        >>> Parameter(name="rate_deg_s", text="rate", unit="deg/s").scaling
        -0.5
        """
        length, time, mass = _DIMENSIONS[self.unit]
        return length + time / 2 + 3 * mass

    @property
    def unit_is_known(self) -> bool:
        """Whether the unit is one that a parameter may have."""
        return self.unit in _DIMENSIONS


def _none() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True, repr=False)
class Effect(Described):
    """One entry of the catalogue.

    Both diagnoses, the simulator, the filter, `with_effect`, scaling and the documentation take
    what they need from here, and nothing of an effect stands anywhere else.

    Parameters
    ----------
    name, family : str
        Name in models; the family its file stands for.
    kind : {"force", "mass", "state", "terms", "freed", "fault"}
        What it does: a force, a share of the mass matrix, states of its own; derivatives of the
        hull polynomial under one name; values of another effect that may be off; a fault of the
        measurement.
    summary : str
        One sentence.
    parameters : tuple of Parameter
        The numbers it takes, besides derivatives.
    options : mapping of str to tuple of str
        Words that choose between forms; the first is the default.
    derivatives : bool
        Whether it takes derivatives by their names.
    roles : tuple of str
        What it does for a ship as a part of a model.
    needs : tuple of str
        What the state must hold: ``phi``, ``delta``, ``n`` …
    sources : tuple of str
        Where the form comes from: keys of the bibliography.
    remark : str
        What is to be said of the sources.
    force : callable, optional
        A function of plain floats, written in the words of `effects.primitives`. It is given each
        of its arguments by name: motion, controls, particulars, conditions, signals of other
        effects, its own parameters, and options as the index of the chosen word.
    outputs : tuple of str
        What `force` returns, in order: X, Y, N, K, signals for other effects, or the rates of
        `states` as ``<state>_rate``.
    states : tuple of str
        States that the effect brings.
    astern : bool
        Whether it says what propulsion does astern.
    estimates : callable, optional
        From a vessel to values for parameters without a default, where it enters a model unasked.
    shares : mapping of str to (mapping of str to float)
        Of kind terms: by coefficient, the derivatives that it stands for, each with its share of
        it; coefficients that are absent stand for themselves.
    stands_in : tuple of str
        Derivatives whose change with the Froude number holds the effect too.
    grows_with : mapping of str to str
        Parameters that grow as the water gets shallow, each with the derivative whose factor it
        takes.
    frees : str
        Of kind freed: the part whose values it moves.
    moves : callable, optional
        From a vessel to how each coefficient moves its values, where that does not follow from
        the kind; of kind terms, for vessels that have a part of their own for it, and nothing for
        others; of a fault, what it does to a model that was made from faulty tests.
    acts : callable, optional
        Of kind fault: from captive records and the values of its parameters to what the gauges
        show. The columns of the diagnosis are its slope, the suspects of the checks its values.
    suspects : tuple of Suspect
        Of kind fault: as what the checks of captive tests ask for it.
    own_checks : tuple of str
        Of kind fault: checks of captive tests that look for it by themselves, and know it by signs
        that other faults would give too.
    each_run : bool
        Of kind fault: whether each run and channel draws a size of its own.
    check : str
        A run, or a check at the bench, that shows it.
    excites : tuple of str
        What tests must hold to show it at all, words of `EXCITES`.
    not_captive, not_free_running : str
        Why captive tests, or free-running records, are not asked for it; empty where they are.
    text : str
        The words in which a user wrote it down.
    in_words : str
        What figures and pages call it, where that is not its name with blanks.
    """

    KINDS: ClassVar[tuple[Kind, ...]] = get_args(Kind)
    EXCITES: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "several speeds": "runs at two speeds or more",
            "four speeds": "runs at four speeds or more",
            "repeats": "a run that was repeated later",
            "roll": "heel or roll",
            "rudder": "rudder angles",
            "large motion": "drift beyond 17° or a yaw rate r' beyond 0.8",
            "sinkage": "measured sinkage",
            "wind": "measured wind",
            "depth": "a stated depth of less than six draughts",
            "waves": "a stated sea, and a table of its drift in the model",
        }
    )
    """What tests must hold to show an effect, and what that means."""

    name: str
    family: str
    kind: Kind
    summary: str
    parameters: tuple[Parameter, ...] = ()
    options: Mapping[str, tuple[str, ...]] = field(default_factory=_none)
    derivatives: bool = False
    roles: tuple[Role, ...] = ()
    needs: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()
    remark: str = ""
    force: Callable[..., Any] | None = None
    outputs: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    astern: bool = False
    estimates: Callable[[Vessel], Mapping[str, float]] | None = None
    shares: Mapping[str, Mapping[str, float]] = field(default_factory=_none)
    stands_in: tuple[str, ...] = ()
    grows_with: Mapping[str, str] = field(default_factory=_none)
    frees: str = ""
    moves: Callable[[Vessel], Mapping[str, Move]] | None = None
    acts: Acts | None = None
    suspects: tuple[Suspect, ...] = ()
    own_checks: tuple[str, ...] = ()
    each_run: bool = False
    check: str = ""
    excites: tuple[str, ...] = ()
    not_captive: str = ""
    not_free_running: str = ""
    text: str = ""
    in_words: str = ""

    @property
    def title(self) -> str:
        """What figures and pages call it.

        Examples
        --------
        >>> Effect(name="fault_gauge_gain", family="gauges", kind="fault", summary="").title
        'Gauge gain'
        """
        plain = self.name.partition("_")[2] if self.faulty and "_" in self.name else self.name
        return self.in_words or plain[:1].upper() + plain[1:].replace("_", " ")

    def _headline(self) -> str:
        asked = [where for where, reason in self._places() if not reason]
        return (
            f"{self.name}: {self.kind} of {self.family.replace('_', ' ')}"
            f"{', asked in ' + ' and '.join(asked) if asked else ''}"
        )

    def _sections(self) -> list[Section]:
        source = f"Source: {self.source}." if self.source else ""
        told = [self.summary, source, self.asked, self.suspected]
        if self.check:
            told.append(f"To be sure: {self.check}.")
        tables = []
        if self.parameters:
            heads, rows = self.parameter_table()
            tables.append(Grid(head=heads, groups=[Group(rows=rows)], texts=(1,)))
        return [
            Section(
                paragraphs=[text for text in told if text],
                points=[
                    f"{name}: {', '.join(choices)} (default the first)"
                    for name, choices in self.options.items()
                ],
                tables=tables,
            )
        ]

    def _places(self) -> list[tuple[str, str]]:
        """Where a diagnosis may ask for it, each with the reason why it does not."""
        if not (self.coefficients or self.moves):
            return []
        return [("captive tests", self.not_captive), ("free running", self.not_free_running)]

    @property
    def asked_in_captive(self) -> bool:
        """Whether captive tests are asked for it."""
        return bool(self.coefficients) and not self.not_captive

    @property
    def asked_in_free_running(self) -> bool:
        """Whether free-running records are asked for it, if they hold what it needs."""
        return bool(self.coefficients or self.moves is not None) and not self.not_free_running

    @property
    def asked(self) -> str:
        """Where a diagnosis asks for it, or why not, in words; empty for parts of a model."""
        places = self._places()
        if not places:
            return ""
        asked = " and ".join(where for where, reason in places if not reason)
        why = [f"Not in {where}: {reason}." for where, reason in places if reason]
        return " ".join([f"Asked in {asked or 'no tests'}.", *why])

    @property
    def suspected(self) -> str:
        """As what the checks of captive tests ask for it, in words; empty where they do not."""
        names = ", ".join(dict.fromkeys(form.name for form in self.suspects))
        return f"The checks of captive tests suspect: {names}." if names else ""

    def parameter_table(self) -> tuple[list[str], list[list[str]]]:
        """The heads and rows that say what its parameters are, in cells of text."""
        heads = ["parameter", "meaning", "unit"]
        heads += ["default"] * self.enters + ["usual size"] * bool(self.coefficients)
        rows = []
        for item in self.parameters:
            cells = [item.name, item.text, item.unit]
            if self.enters:
                cells.append("required" if item.default is None else f"{item.default:g}")
            if self.coefficients:
                cells.append("" if item.typical is None else f"{item.typical:.3g}")
            rows.append(cells)
        return heads, rows

    @property
    def source(self) -> str:
        """The sources as a sentence names them."""
        return "; ".join(filter(None, (cite(*self.sources) if self.sources else "", self.remark)))

    @property
    def enters(self) -> bool:
        """Whether it can be a part of a model."""
        return self.kind in ("force", "mass", "state")

    @property
    def coefficients(self) -> tuple[Parameter, ...]:
        """What a diagnosis fits of it: the parameters with a usual size."""
        return tuple(item for item in self.parameters if item.typical is not None)

    @property
    def typical(self) -> Mapping[str, float]:
        """Usual sizes of the coefficients."""
        return MappingProxyType(
            {item.name: item.typical for item in self.parameters if item.typical is not None}
        )

    @property
    def nonlinear(self) -> Parameter | None:
        """The parameter that a diagnosis tries on a grid; None where there is none."""
        return next((item for item in self.parameters if item.grid or item.of_the_tests), None)

    @property
    def varies_with_speed(self) -> frozenset[str]:
        """Derivatives that change with the Froude number where it is in a model."""
        return frozenset(self.stands_in) | frozenset(
            name.removesuffix(BY_SPEED)
            for label in self.typical
            for name in self.derivatives_of(label)
            if name.endswith(BY_SPEED)
        )

    @property
    def faulty(self) -> bool:
        """Whether it is a fault of the measurement, which corrects data and enters no model."""
        return self.kind == "fault"

    def serves(self, role: str) -> bool:
        """Whether it has a role, and is no share of the hull beside it."""
        return role in self.roles and not any(x.endswith("dot") for x in self.outputs)

    @property
    def drives(self) -> bool:
        """Whether it is a propeller or another drive, and no share of the hull beside it."""
        return self.serves("propulsion")

    @property
    def steers(self) -> bool:
        """Whether it is a rudder or another gear that steers, and nothing of the hull."""
        return self.serves("steering")

    @property
    def force_over_arrays(self) -> Callable[..., Any]:
        """Its force, taking whole histories."""
        assert self.force is not None
        return over_arrays(self.force)

    @property
    def arguments(self) -> tuple[str, ...]:
        """What its force asks for, by name; nothing where it has none."""
        return _arguments(self.force) if self.force is not None else ()

    def shown(self, run: Observed, at: Mapping[str, float]) -> Forces:
        """What a fault shows of records; parameters that are not named are zero."""
        assert self.acts is not None
        none = dict.fromkeys((item.name for item in self.parameters), 0.0)
        return self.acts(run, none | dict(at))

    def slopes(
        self, run: Observed, at: Mapping[str, float], names: Sequence[str]
    ) -> dict[str, tuple[Array, ...]]:
        """What a unit of some parameters of a fault changes in the forces, by channel.

        ∂F/∂s ≈ [F(s = h) - F(s = 0)]/h with the `step` h of the parameter; with h = 1 this is exact
        where the fault acts in proportion. `at` are the other parameters; those that are not named
        are zero.
        """
        found = []
        for name in names:
            item = self.parameter(name)
            assert item is not None
            shown = self.shown(run, {**at, name: item.step})
            found.append({c: (x - run.forces[c]) / item.step for c, x in shown.items()})
        channels = dict.fromkeys(channel for own in found for channel in own)
        return {
            c: tuple(own[c] if c in own else np.zeros_like(run.forces[c]) for own in found)
            for c in channels
        }

    def derivatives_of(self, coefficient: str) -> Mapping[str, float]:
        """The derivatives that a coefficient stands for, each with its share of it."""
        return self.shares.get(coefficient, {coefficient: 1.0})

    def sizes(self, coefficients: Mapping[str, float]) -> dict[str, float]:
        """Values of the derivatives from those of the coefficients.

        Examples
        --------
        >>> keel = Effect(name="keel", family="own", kind="terms", summary="",
        ...               shares={"a": {"Yv|v|": 1.0, "Nv|v|": -0.4}},
        ...               parameters=(Parameter(name="a", text="", typical=-0.01),))
        >>> keel.sizes({"a": -0.02})
        {'Yv|v|': -0.02, 'Nv|v|': 0.008}
        """
        found: dict[str, float] = {}
        for label in self.typical:
            for name, share in self.derivatives_of(label).items():
                found[name] = found.get(name, 0.0) + share * coefficients.get(label, 0.0)
        return found

    def parameter(self, name: str) -> Parameter | None:
        """The parameter of a name; None where the effect has none of it."""
        return next((item for item in self.parameters if item.name == name), None)

    @property
    def tables(self) -> frozenset[str]:
        """Names of the parameters that hold lists."""
        return frozenset(item.name for item in self.parameters if item.table)

    def chosen(self, options: Mapping[str, str]) -> dict[str, str]:
        """The options with their defaults filled in."""
        return {name: options.get(name, words[0]) for name, words in self.options.items()}

    def accepts(self, name: str) -> bool:
        """Whether a value of this name may be given."""
        if self.parameter(name) is not None:
            return True
        if not self.derivatives:
            return False
        try:
            derivative = parse_derivative(name)
        except UnknownNameError:
            return False
        accelerations = sum(factor.endswith("dot") for factor in derivative.factors)
        alone = len(derivative.factors) == 1
        return (accelerations == 1 and alone) if self.kind == "mass" else accelerations == 0

    def required(self, options: Mapping[str, str]) -> tuple[str, ...]:
        """Names of the parameters that must be given with these options."""
        chosen = self.chosen(options)
        return tuple(
            item.name
            for item in self.parameters
            if item.default is None and (item.form is None or chosen[item.form[0]] in item.form[1:])
        )

    def problems(self, values: Mapping[str, object], options: Mapping[str, str]) -> list[str]:
        """What is wrong with values and options given for this effect, in words."""
        if self.kind == "fault":
            return [
                f"{self.name} is a fault of a measurement: it corrects data, it is no part of a "
                f"model."
            ]
        if self.kind == "terms":
            names = ", ".join(name.removesuffix(BY_SPEED) for name in self.sizes(self.typical))
            return [
                f"{self.name} stands for derivatives: give {names} to the polynomial of the hull, "
                f"which adding the effect does."
            ]
        if self.kind == "freed":
            return [
                f"{self.name} stands for values of {self.frees}: change them there, which "
                f"adding the effect does."
            ]
        found = []
        for name, word in options.items():
            words = self.options.get(name)
            if words is None:
                known = ", ".join(self.options) or "none"
                found.append(f"{self.name} has no option {name!r}; it has: {known}.")
            elif word not in words:
                found.append(f"{name} of {self.name} is {word!r}; possible: {', '.join(words)}.")
        if found:
            return found
        unknown = [name for name in values if not self.accepts(name)]
        if unknown:
            known = ", ".join(item.name for item in self.parameters)
            more = " and derivatives" if self.derivatives else ""
            guess = did_you_mean(unknown[0], [item.name for item in self.parameters]) or "."
            found.append(
                f"{self.name} takes no {', '.join(unknown)}{guess} It takes {known}{more}."
            )
        missing = [name for name in self.required(options) if name not in values]
        if missing:
            found.append(f"{self.name} lacks {', '.join(missing)}.")
        return [*found, *self._table_problems(values, options)]

    def _table_problems(
        self, values: Mapping[str, object], options: Mapping[str, str]
    ) -> list[str]:
        """Lists that do not ascend, or are not as long as those over which they stand."""
        chosen = self.chosen(options)
        lists = {
            item.name: value
            for item in self.parameters
            if (item.form is None or chosen[item.form[0]] in item.form[1:])
            and isinstance(value := values.get(item.name), tuple)
        }
        found = []
        for axis in dict.fromkeys(x for item in self.parameters for x in item.over if x in lists):
            if any(b <= a for a, b in pairwise(lists[axis])):
                found.append(f"{axis} of {self.name} must ascend.")
        for item in self.parameters:
            axes = [axis for axis in item.over if axis in lists]
            if not axes or item.name not in lists:
                continue
            size = math.prod(len(lists[axis]) for axis in axes)
            if len(lists[item.name]) != size:
                found.append(
                    f"{item.name} of {self.name} has {len(lists[item.name])} numbers; "
                    f"{' times '.join(axes)} ask for {size}."
                )
        return found


@cache
def _arguments(function: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(signature(function).parameters)
