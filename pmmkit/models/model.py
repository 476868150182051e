"""Model: a ship, its water, effects by name and their values, as data."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import (
    DataError,
    ExtrapolationError,
    MissingPartError,
    ModelError,
    Problem,
    Remedy,
    UnknownNameError,
    Way,
)
from pmmkit.conventions import Convention, Ship, Water, parse_derivative
from pmmkit.effects import CATALOGUE, HULL, INERTIA, AddedMass, Effect, written_effect
from pmmkit.models.step import Step, Value, added, faults_of
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, plus_minus

DERIVATIVE_PARTS: Final = (HULL, "rudder_abkowitz", INERTIA)
SAILING: Final = ("propulsion", "steering")
"""What a ship needs beside its hull."""
TAKE_PARTS: Final = Remedy(
    "Take parts from a library ship ({}) or write them into the model file.",
    (Way('to_model(table, parts="…")', "pmmkit model replace MODEL PART --from SHIP"),),
)
FORCED: Final = "NOT USABLE: made by force of derivatives that are not usable. {}"
FN_TOLERANCE: Final = 0.02
"""Share of a Froude number by which a speed may lie beside the range of the values, as those of
runs on one carriage setting do; they hold at its edge."""


def _frozen() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Part:
    """One effect of a model with its values.

    Parameters
    ----------
    effect : str
        Name in the catalogue.
    values : mapping of str to float or tuple of float
        Parameters and derivatives; a tuple holds a value per Froude number of the model.
    options : mapping of str to str
        Words that choose a form of the effect.
    source : str
        Where the values come from: ``measured: …``, ``library: …``, ``empirical: …``.
    references : tuple of str
        The same as keys of the bibliography, where it stands there.
    sources : mapping of str to str
        In words for single values, where it differs.
    std : mapping of str to float
        Standard uncertainties of single values, such as estimates, independent of each other and
        of the model's covariance; the same share of the value at all Froude numbers.
    text : str
        The words of a user that the effect was made from; empty for one of the catalogue.
    """

    effect: str
    values: Mapping[str, Value] = field(default_factory=_frozen)
    options: Mapping[str, str] = field(default_factory=_frozen)
    source: str = ""
    references: tuple[str, ...] = ()
    sources: Mapping[str, str] = field(default_factory=_frozen)
    std: Mapping[str, float] = field(default_factory=_frozen)
    text: str = ""

    @property
    def known(self) -> Effect:
        """What the catalogue, or the user's text, says of the effect."""
        return written_effect(self.effect, self.text) if self.text else CATALOGUE[self.effect]

    def source_of(self, name: str) -> str:
        """Where one value comes from."""
        return self.sources.get(name, self.source)

    def place(self, name: str) -> str:
        """One of its values by one name: ``Yv``, or ``rudder_mmg.aH`` where it is no derivative."""
        return place_name(self.effect, name)

    @property
    def estimated(self) -> list[str]:
        """Names of the values that are estimates from particulars."""
        return [name for name in self.values if self.source_of(name).startswith("empirical")]

    def assumed(self, name: str = "") -> bool:
        """Whether a value, or the part, is a usual one that stands for what nobody states."""
        return self.source_of(name).startswith("assumed")


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Model(Described):
    """A manoeuvring model, complete and checked.

    Parameters
    ----------
    name : str
        Short name.
    ship, water : Ship, Water
        The ship at the scale that the model stands for.
    parts : mapping of str to Part
        Effects by name.
    convention : Convention
        What the derivatives of the hull, the rudder polynomial and the added mass mean.
    Fn : tuple of float
        Froude numbers of values given as tuples, ascending.
    covariance : array, optional
        Covariance of `covariance_names` at all Froude numbers, (k n, k n) with the names running
        fastest; k is 1 where the model has no Froude numbers. NaN where it is not known. Of a
        normal law: where few degrees of freedom stand behind a table, its intervals are kept.
    covariance_names : tuple of str
        Derivatives in the covariance, and values of other parts as ``rudder_mmg.aH``.
    title, scale : str
        One line for people; at which scale the model is and at which propulsion point.
    notes : tuple of str
        What a reader must know.
    steps : tuple of Step
        What led to the model, the first step first.

    Raises
    ------
    ModelError
        With everything that is wrong.
    """

    name: str
    ship: Ship
    water: Water = field(default_factory=Water)
    parts: Mapping[str, Part]
    convention: Convention = field(default_factory=Convention)
    Fn: tuple[float, ...] = ()
    covariance: NDArray[np.float64] | None = None
    covariance_names: tuple[str, ...] = ()
    title: str = ""
    scale: str = ""
    notes: tuple[str, ...] = ()
    steps: tuple[Step, ...] = ()

    def __post_init__(self) -> None:
        found = problems(self)
        if found:
            raise ModelError(found, title=f"Model {self.name}")

    @property
    def history(self) -> tuple[str, ...]:
        """The steps that led to the model, a sentence each."""
        return tuple(str(step) for step in self.steps)

    @property
    def not_usable(self) -> str:
        """Why nothing that it computes can be used: derivatives that are not usable went into it
        by force. Empty where no step says so.

        Examples
        --------
        >>> from pmmkit.models.step import Step
        >>> from pmmkit.models.store import load_model
        >>> forced = Step(action="forced", ship="KCS", names=("Yv is positive.",))
        >>> load_model("kcs").stepped(forced).not_usable
        'NOT USABLE: made by force of derivatives that are not usable. Yv is positive.'
        """
        faults = [text for step in self.steps if step.action == "forced" for text in step.names]
        return FORCED.format(" ".join(dict.fromkeys(faults))) if faults else ""

    @property
    def added(self) -> tuple[int, ...]:
        """Places of the steps that added what is still in it: effects, and faults of the tests."""
        return added(self.steps)

    def faults_of(self, campaign: str) -> dict[str, Step]:
        """The faults that its steps tell of the tests of a title: of each the last step."""
        return faults_of(self.steps, campaign)

    def home_of(self, derivative: str) -> str:
        """The part in which a derivative stands, or would."""
        known = parse_derivative(derivative)
        if any(factor.endswith("dot") for factor in known.factors):
            return INERTIA
        steered = known.count("d") and "rudder_abkowitz" in self.parts
        return "rudder_abkowitz" if steered else HULL

    def stepped(self, *steps: Step) -> Model:
        """A copy with steps more; what a table said of its misfit stands among the notes as long as
        no effect is in the model that was fitted together with the derivatives."""
        whole = (*self.steps, *steps)
        misfit = tuple(text for step in whole for text in step.misfit)
        others = tuple(text for text in self.notes if text not in misfit)
        taken = [whole[place] for place in added(whole)]
        fitted = any(x.error_after is not None and not x.error_of for x in taken)
        stands = () if fitted else misfit
        return replace(self, notes=(*stands, *others), steps=whole)

    @property
    def std(self) -> Mapping[str, tuple[float, ...]]:
        """Standard uncertainties of the values in the covariance, one per Froude number."""
        if self.covariance is None:
            return MappingProxyType({})
        roots = np.sqrt(np.diagonal(self.covariance)).reshape(-1, len(self.covariance_names))
        each = zip(self.covariance_names, roots.T.tolist(), strict=True)
        return MappingProxyType({name: tuple(values) for name, values in each})

    def _headline(self) -> str:
        count = sum(len(part.values) for part in self.derivative_parts.values())
        return (
            f"{self.name}: {counted(count, 'derivative')}, {counted(len(self.parts), 'part')}, "
            f"L = {self.ship.L:g} m, {self._speeds()}"
        )

    def _speeds(self) -> str:
        if not self.Fn:
            return "one set of values for all speeds"
        low, high = (self.ship.speed(Fn, self.water.g) for Fn in (self.Fn[0], self.Fn[-1]))
        return f"Fn {self.Fn[0]:.3f} to {self.Fn[-1]:.3f} ({low:.2f} to {high:.2f} m/s)"

    def _sections(self) -> Sequence[Section]:
        about = [
            self.not_usable,
            self.title,
            self.ship.words,
            self.scale,
            f"Derivatives: {self.convention.meaning}",
        ]
        hull = self.derivative_parts
        others = [x for name, x in self.parts.items() if x.values and name not in hull]
        told = [
            Section(title="History", points=self.history),
            Section(title="Notes", points=self.notes),
        ]
        return [
            Section(paragraphs=[text for text in about if text]),
            Section(title="Parts", tables=[self._parts()]),
            Section(title="Derivatives", tables=[self._derivatives()]),
            Section(title="Other values", points=[self._values(part) for part in others]),
            *(section for section in told if section.points),
        ]

    def _parts(self) -> Grid:
        """Each part, how many values it has, and where they come from."""
        rows = []
        for name, part in self.parts.items():
            rows.append([name, str(len(part.values)), part.source or "no source is stated"])
            for source in dict.fromkeys(part.sources.values()):
                own = [value for value, said in part.sources.items() if said == source]
                rows.append([f"  {', '.join(own)}", str(len(own)), source])
        return Grid(head=["part", "values", "source"], groups=[Group(rows=rows)], texts=(2,))

    def _derivatives(self) -> Grid:
        """Values with half of their 95 % interval where it is known, and how they were found."""
        std = self.std
        rows = []
        for part in self.derivative_parts.values():
            for name, value in part.values.items():
                values = value if isinstance(value, tuple) else (value,) * max(len(self.Fn), 1)
                alone = part.std.get(name, math.nan)
                halves = [WIDE * x for x in std.get(name, (alone,) * len(values))]
                kind = part.source_of(name).partition(":")[0] or "unknown"
                cells = [
                    plus_minus(x, half) or None for x, half in zip(values, halves, strict=False)
                ]
                rows.append([name, *cells, kind])
        speeds = [f"Fn {Fn:.3f}" for Fn in self.Fn] or ["value"]
        head = ["", *speeds, "origin"]
        known = std or any(part.std for part in self.derivative_parts.values())
        caption = "Value ± half of the 95 % interval" if known else "No uncertainty is known"
        return Grid(head=head, groups=[Group(rows=rows)], caption=caption, texts=(len(head) - 1,))

    def _values(self, part: Part) -> str:
        """The values of a part that holds no derivatives, with their units."""
        known, std = part.known, self.std
        told = [part.text] if part.text else []
        for name, value in part.values.items():
            parameter = known.parameter(name)
            unit = parameter.unit if parameter and parameter.unit != "-" else ""
            alone = part.std.get(name, math.nan)
            half = WIDE * std.get(place_name(part.effect, name), (alone,))[0]
            ends = [
                plus_minus(x, half) if half > 0 else f"{x:.4g}"
                for x in (value if isinstance(value, tuple) else (value,))
            ]
            told.append(
                f"{name} = {' … '.join(dict.fromkeys((ends[0], ends[-1])))} {unit}".rstrip()
            )
        told += [f"{name}: {word}" for name, word in part.options.items()]
        return f"{part.effect}: {', '.join(told)}"

    @property
    def derivative_parts(self) -> dict[str, Part]:
        """The parts that hold derivatives, by name."""
        return {name: self.parts[name] for name in DERIVATIVE_PARTS if name in self.parts}

    @property
    def derivatives(self) -> tuple[str, ...]:
        """Derivatives of which it has a value."""
        return tuple(
            name
            for part in self.derivative_parts.values()
            for name in part.values
            if part.known.parameter(name) is None
        )

    def in_role(self, role: str) -> tuple[str, ...]:
        """Names of the parts that have a role.

        Examples
        --------
        >>> from pmmkit.models.store import load_model
        >>> load_model("kvlcc2").in_role("propulsion")
        ('propeller',)
        """
        return tuple(name for name, part in self.parts.items() if role in part.known.roles)

    @property
    def lacking(self) -> tuple[str, ...]:
        """What it has no part for and needs besides the hull, to be sailed.

        A model in the loss of speed Δu holds the propeller's share in its hull.

        Examples
        --------
        >>> from pmmkit.models.store import load_model
        >>> ship = load_model("kvlcc2")
        >>> hull = {"hull_polynomial": ship.parts["hull_polynomial"]}
        >>> ship.lacking, ship.with_(parts=hull).lacking
        ((), ('propulsion', 'steering'))
        """
        held = {"propulsion"} if self.convention.surge == "delta-u" else set()
        return tuple(x for x in SAILING if x not in held and not self.in_role(x))

    @property
    def knows_astern(self) -> bool:
        """Whether it says what its propulsion does astern."""
        return any(part.known.astern for part in self.parts.values())

    @property
    def has_bucket(self) -> bool:
        """Whether a bucket turns the thrust astern, as that of a waterjet does."""
        return any("bucket" in part.known.needs for part in self.parts.values())

    def acts_across(self, which: Callable[[int, int], object]) -> bool:
        """Whether the hull's side force and moment have such a term, by powers of v and r, that is
        not zero; other parts that hold some of them have any."""
        others = any(
            name != HULL
            and "Y" in part.known.outputs
            and not (part.known.roles or part.known.needs)
            for name, part in self.parts.items()
        )
        hull = self.parts.get(HULL)
        there = {} if hull is None else hull.values
        terms = [parse_derivative(name) for name, value in there.items() if np.any(value)]
        return others or any(
            which(x.count("v"), x.count("r")) for x in terms if x.channel in ("Y", "N")
        )

    @property
    def rolls(self) -> bool:
        """Whether the model has roll as a fourth degree of freedom."""
        return "roll" in self.parts

    @property
    def is_uncertain(self) -> bool:
        """Whether it says anything of the uncertainty of its values."""
        return self.covariance is not None or any(part.std for part in self.parts.values())

    def known_speeds(self, speed: float) -> tuple[float, ...]:
        """Speeds [m/s] between which the values lie on lines, ascending.

        Those of the Froude numbers, and the approach speed [m/s] where it is slower or faster than
        all of them: then the values of the approach hold at the edge, whether they were carried on
        there or are those next to it. Fewer than two where nothing follows the speed.
        """
        if len(self.Fn) < 2:
            return ()
        tested = tuple(self.ship.speed(Fn, self.water.g) for Fn in self.Fn)
        return tuple(sorted({*tested, min(speed, tested[0]), max(speed, tested[-1])}))

    @property
    def steering(self) -> Mapping[str, float]:
        """Rate [deg/s] and largest angle [deg] of what steers, where the model states them."""
        found: dict[str, float] = {}
        for name, part in self.parts.items():
            if part.known.parameter("rate_deg_s") is not None:
                values = self.values(name, self.Fn[0] if self.Fn else None)
                found |= {key: values[key] for key in ("rate_deg_s", "max_deg") if key in values}
        return found

    @property
    def heeled(self) -> tuple[str, ...]:
        """Derivatives of heel and roll rate in a model that does not roll.

        Such a model goes along with a measured heel, in records and captive tests; a manoeuvre
        needs a ship that rolls by itself.
        """
        if self.rolls:
            return ()
        return tuple(
            name
            for part in self.derivative_parts.values()
            for name in part.values
            if needs_roll(name) and name[0] != "K"
        )

    def part(self, effect: str, need: str = "the request") -> Part:
        """One part.

        Raises
        ------
        MissingPartError
            If the model has none of that name.
        """
        if effect not in self.parts:
            raise MissingPartError(
                Problem(
                    message=f"Model {self.name!r} has no part {effect!r}, which {need} needs. It "
                    f"has {', '.join(self.parts)}.",
                    remedy=TAKE_PARTS,
                )
            )
        return self.parts[effect]

    def values(
        self, effect: str, Fn: float | None = None, *, extrapolate: bool = False
    ) -> dict[str, Any]:
        """The values of one part at a Froude number, defaults filled in.

        Parameters
        ----------
        effect : str
            A part of the model.
        Fn : float, optional
            Froude number; needed where the model has values over several.
        extrapolate : bool
            Carry the line through the two nearest Froude numbers on beyond the range.

        Returns
        -------
        dict
            Values between two Froude numbers are interpolated linearly; tables stay as they are.

        Raises
        ------
        ExtrapolationError
            If `Fn` is outside the range and `extrapolate` is not set.
        """
        part = self.part(effect)
        known = part.known
        filled: dict[str, Any] = {
            item.name: item.default for item in known.parameters if item.default is not None
        }
        weights = self.weights(Fn, extrapolate=extrapolate) if self.Fn else ()
        tables = known.tables
        for name, value in part.values.items():
            filled[name] = (
                sum(weight * item for weight, item in zip(weights, value, strict=True))
                if isinstance(value, tuple) and name not in tables
                else value
            )
        return filled

    def values_at(self, speed: float, *, extrapolate: bool = False) -> dict[str, dict[str, Any]]:
        """Values of all parts at the Froude number of a speed [m/s], by effect and name."""
        if not (math.isfinite(speed) and speed > 0):
            raise DataError(f"The approach speed {speed} m/s must be positive.")
        Fn = self.ship.froude(speed, self.water.g)
        return {effect: self.values(effect, Fn, extrapolate=extrapolate) for effect in self.parts}

    def feels(self, what: str) -> bool:
        """Whether something around the ship, such as its ``depth``, changes the forces."""
        return any(what in part.known.needs for part in self.parts.values())

    @property
    def held(self) -> tuple[float, float]:
        """Ends of the Froude numbers at which its values hold, a tolerance beyond its own."""
        return self.Fn[0] * (1 - FN_TOLERANCE), self.Fn[-1] * (1 + FN_TOLERANCE)

    def weights(self, Fn: float | None, *, extrapolate: bool = False) -> tuple[float, ...]:
        """Share of each of the model's Froude numbers in the values at another one.

        Raises
        ------
        ExtrapolationError
            If `Fn` is outside the range and `extrapolate` is not set.
        """
        if Fn is None:
            raise ModelError(
                f"Model {self.name!r} has values at {len(self.Fn)} Froude numbers: say which."
            )
        low, high = self.held
        if not low <= Fn <= high and not extrapolate:
            raise ExtrapolationError(
                f"Fn {Fn:.4g} ({self.ship.speed(Fn, self.water.g):.4g} m/s) is outside the range "
                f"{self.Fn[0]:.4g} to {self.Fn[-1]:.4g} "
                f"({self.ship.speed(self.Fn[0], self.water.g):.4g} to "
                f"{self.ship.speed(self.Fn[-1], self.water.g):.4g} m/s) of model {self.name!r}. "
                f"Choose a speed inside it, or allow extrapolation."
            )
        if len(self.Fn) == 1:
            return (1.0,)
        if not extrapolate:
            Fn = min(max(Fn, self.Fn[0]), self.Fn[-1])
        right = next((i for i in range(1, len(self.Fn) - 1) if Fn <= self.Fn[i]), len(self.Fn) - 1)
        share = (Fn - self.Fn[right - 1]) / (self.Fn[right] - self.Fn[right - 1])
        weights = [0.0] * len(self.Fn)
        weights[right - 1], weights[right] = 1.0 - share, share
        return tuple(weights)

    def with_(self, **changes: Any) -> Model:
        """A copy with some entries changed."""
        return replace(self, **changes)

    def with_values(self, effect: str, **values: Value) -> Model:
        """A copy with some values of one part changed or added."""
        part = self.part(effect)
        changed = replace(part, values=MappingProxyType({**part.values, **values}))
        return replace(self, parts=MappingProxyType({**self.parts, effect: changed}))


def place_name(effect: str, name: str) -> str:
    """A value of a model by one name: ``Yv``, or ``rudder_mmg.aH`` where it is no derivative.

    Examples
    --------
    >>> place_name("hull_polynomial", "Yv"), place_name("rudder_mmg", "aH")
    ('Yv', 'rudder_mmg.aH')
    """
    return name if effect in DERIVATIVE_PARTS else f"{effect}.{name}"


def problems(model: Model) -> list[str]:
    """Everything that is wrong with a model, in words."""
    found = []
    if any(not math.isfinite(x) or x <= 0 for x in model.Fn) or any(
        a >= b for a, b in zip(model.Fn, model.Fn[1:], strict=False)
    ):
        found.append(f"Froude numbers must be positive and ascend: {list(model.Fn)}.")
    for name, part in model.parts.items():
        if part.effect != name:
            found.append(f"The part {name!r} holds the effect {part.effect!r}.")
            continue
        found += _part_problems(part, len(model.Fn))
    found += _roll_problems(model)
    found += _covariance_problems(model)
    if model.convention.moment_reference_x or model.convention.motion_reference_x:
        found.append(
            "The derivatives must refer to midship; convert the table to midship before it "
            "becomes a model."
        )
    return found


def _part_problems(part: Part, rows: int) -> list[str]:
    if not part.text and part.effect not in CATALOGUE:
        return [f"There is no effect {part.effect!r}; there are: {', '.join(CATALOGUE)}."]
    known = part.known
    found = known.problems(part.values, part.options)
    lost = [x for x in part.values if x not in (*AddedMass.places(), "lx")]
    if part.effect == INERTIA and lost:
        found.append(f"The equations of motion have no place for {', '.join(lost)}.")
    for name, value in part.values.items():
        place = f"{part.effect}.{name}"
        numbers = value if isinstance(value, tuple) else (value,)
        if name in known.tables:
            if len(numbers) < 2:
                found.append(f"{place} must be a list of two numbers or more.")
        elif isinstance(value, tuple) and len(value) != rows:
            found.append(f"{place} has {len(value)} values for {rows} Froude numbers.")
        if not all(math.isfinite(x) for x in numbers):
            found.append(f"{place} must be finite: {value}.")
            continue
        parameter = known.parameter(name)
        if parameter is None:
            if known.accepts(name) and parse_derivative(name).name != name:
                found.append(f"{place} is spelled {parse_derivative(name).name}.")
            elif known.accepts(name) and "T" in parse_derivative(name).factors:
                found.append(f"{place}: factors of the thrust are not simulated.")
        elif not all(parameter.low <= x <= parameter.high for x in numbers):
            found.append(
                f"{place} = {value} is outside {parameter.low:g} to {parameter.high:g} "
                f"[{parameter.unit}]."
            )
    stray = [name for name in part.sources if name not in part.values]
    if stray:
        found.append(f"{part.effect} states a source of {', '.join(stray)} but no value.")
    stray = [name for name in part.std if name not in part.values]
    if stray:
        found.append(f"{part.effect} states the uncertainty of {', '.join(stray)} but no value.")
    wrong = [name for name, x in part.std.items() if not (math.isfinite(x) and x >= 0)]
    if wrong:
        found.append(f"{part.effect}: uncertainties of {', '.join(wrong)} must be 0 or more.")
    return found


def _roll_problems(model: Model) -> list[str]:
    if not model.rolls:
        needed = sorted(
            name
            for part in model.derivative_parts.values()
            for name in part.values
            if needs_roll(name) and name[0] == "K"
        )
        return (
            [f"{', '.join(needed)} need roll, but the model has no part 'roll'."] if needed else []
        )
    absent = [name for name in ("GM", "Ixx") if getattr(model.ship, name) is None]
    return [f"The part 'roll' needs {' and '.join(absent)} of the ship."] if absent else []


def needs_roll(name: str) -> bool:
    """Whether a value is a derivative that belongs to roll.

    Examples
    --------
    >>> [needs_roll(name) for name in ("Kv", "Nvvphi", "Yp", "Ypdot", "Yv", "lx")]
    [True, True, True, True, False, False]
    """
    try:
        return name != "lx" and parse_derivative(name).rolls
    except UnknownNameError:
        return False


def _covariance_problems(model: Model) -> list[str]:
    if model.covariance is None:
        return (
            ["covariance_names are given without a covariance."] if model.covariance_names else []
        )
    size = max(len(model.Fn), 1) * len(model.covariance_names)
    if model.covariance.shape != (size, size):
        return [
            f"The covariance has the shape {model.covariance.shape}, expected {(size, size)}: "
            f"{len(model.covariance_names)} names at {max(len(model.Fn), 1)} Froude numbers."
        ]
    values = {place_name(effect, name) for effect, x in model.parts.items() for name in x.values}
    found = []
    stray = [name for name in model.covariance_names if name not in values]
    if stray:
        found.append(f"The covariance names {', '.join(stray)}, of which there is no value.")
    if not np.array_equal(model.covariance, model.covariance.T, equal_nan=True):
        found.append("The covariance is not symmetric.")
    if np.any(np.diagonal(model.covariance) < 0):
        found.append("The covariance has negative variances.")
    return found
