"""Model: a ship, its water, effects by name and their values, as data."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import (
    DataError,
    ExtrapolationError,
    MissingPartError,
    ModelError,
    Problem,
    Remedy,
    Way,
)
from pmmkit.conventions import Convention, Ship, Water, parse_derivative
from pmmkit.effects import CATALOGUE, HULL, INERTIA
from pmmkit.models.part import DERIVATIVE_PARTS, Part, needs_roll, place_name
from pmmkit.models.step import Before, Step, Value, added, faults_of
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, plus_minus

SAILING: Final = ("propulsion", "steering")
"""What a ship needs beside its hull."""
HULL_TERMS: Final = ("Yv", "Yr", "Nv", "Nr")
"""What no estimate stands for: without them nothing of the hull was measured."""
NEEDED: Final = ("Xuu", "Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot")
"""Without these a ship cannot be simulated at all."""
FORCED: Final = "NOT USABLE: made by force of derivatives that are not usable. {}"
ASTERN: Final = (
    "What the propeller does astern is estimated: curves of Wageningen B4-70 of the pitch at which "
    "its thrust vanishes, joined to its open water ahead; no wake or side force astern."
)
FN_TOLERANCE: Final = 0.02
"""Share of a Froude number by which a speed may lie beside the range of the values, as those of
runs on one carriage setting do; they hold at its edge."""


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

    TAKE_PARTS: ClassVar = Remedy(
        "Take parts from a library ship ({}) or write them into the model file.",
        (Way('to_model(table, parts="…")', "pmmkit model replace MODEL PART --from SHIP"),),
    )
    """What helps where a part is missing."""

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

    @staticmethod
    def needed(*, estimated: bool = False) -> tuple[str, ...]:
        """Derivatives without which there is no model, whether or not estimates stand for others.

        Examples
        --------
        >>> Model.needed(estimated=True)
        ('Yv', 'Yr', 'Nv', 'Nr')
        """
        return HULL_TERMS if estimated else NEEDED  # added mass hardly hangs on the speed

    @property
    def missing_parts(self) -> list[str]:
        """Parts without which it cannot be simulated; alternatives in one, by *or*.

        Examples
        --------
        >>> from pmmkit.models.store import load_model
        >>> load_model("kvlcc2").missing_parts
        []
        """
        missing = [name for name in (HULL, INERTIA) if name not in self.parts]
        missing += ["roll"] if self.heeled else []
        every = CATALOGUE.values()
        return missing + [
            " or ".join(effect.name for effect in every if role in effect.roles)
            for role in self.lacking
        ]

    @property
    def knows_astern(self) -> bool:
        """Whether it says what its propulsion does astern."""
        return any(part.known.astern for part in self.parts.values())

    def as_it_stops(self) -> Model | None:
        """A model that knows what its propulsion does astern: itself, or by an estimate
        (`with_estimated_astern`); None where nothing is known."""
        if self.knows_astern:
            return self
        return self.with_estimated_astern() if self._astern_can_be_estimated else None

    @property
    def _astern_can_be_estimated(self) -> bool:
        """Whether it has a propeller with KT as a polynomial, which says nothing of astern."""
        part = self.parts.get("propeller")
        return part is not None and "kt0" in part.values and not self.knows_astern

    def with_estimated_astern(self) -> Model:
        """A copy whose propeller turns astern by the curves of a series.

        Its propeller has curves in all four quadrants: ahead, from bollard pull to the J at which
        the thrust vanishes, those that it had; beyond, those of Wageningen B4-70 as
        `effects.four_quadrant.estimate` joins them. An estimate, not a measurement.

        Raises
        ------
        ModelError
            If it knows what its propulsion does astern, or has no propeller with a polynomial KT.

        Examples
        --------
        >>> from pmmkit.models.store import load_model
        >>> made = load_model("kvlcc2").with_estimated_astern()
        >>> made.knows_astern, made.values("four_quadrant_propeller")["kt0"]
        (True, 0.2931)
        """
        if not self._astern_can_be_estimated:
            raise ModelError(
                f"Model {self.name!r} "
                + (
                    "says already what its propulsion does astern."
                    if self.knows_astern
                    else "has no propeller whose KT is a polynomial of J, from which curves astern "
                    "could be estimated: state a part four_quadrant_propeller."
                )
            )
        own, known = self.parts["propeller"], CATALOGUE["four_quadrant_propeller"]
        shared = {item.name for item in known.parameters}
        turning = replace(
            own,
            effect=known.name,
            values=MappingProxyType({name: x for name, x in own.values.items() if name in shared}),
            options=MappingProxyType({x: y for x, y in own.options.items() if x in known.options}),
        )
        parts = {
            known.name if name == own.effect else name: turning if name == own.effect else part
            for name, part in self.parts.items()
        }
        made = self.with_(parts=MappingProxyType(parts))
        return made.stepped(Step(action="noted", note=ASTERN))

    @cached_property
    def has_bucket(self) -> bool:
        """Whether a bucket turns the thrust astern, as that of a waterjet does."""
        return any("bucket" in part.known.needs for part in self.parts.values())

    def acts_across(self, which: Callable[[int, int], object]) -> bool:
        """Whether the hull's side force and moment have such a term, by powers of v and r, that is
        not zero; other parts that hold some of them have any."""
        return self._holds_across or any(which(v, r) for v, r in self._powers_across)

    @cached_property
    def _holds_across(self) -> bool:
        """Whether parts beside the derivatives hold a side force of the hull."""
        return any(
            name != HULL
            and "Y" in part.known.outputs
            and not (part.known.roles or part.known.needs)
            for name, part in self.parts.items()
        )

    @cached_property
    def _powers_across(self) -> tuple[tuple[int, int], ...]:
        """Powers of v and r in the terms of Y and N that are not zero."""
        hull = self.parts.get(HULL)
        there = {} if hull is None else hull.values
        terms = [parse_derivative(name) for name, value in there.items() if np.any(value)]
        return tuple((x.count("v"), x.count("r")) for x in terms if x.channel in ("Y", "N"))

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

    @cached_property
    def steering(self) -> Mapping[str, float]:
        """Rate [deg/s] and largest angle [deg] of what steers, where the model states them."""
        found: dict[str, float] = {}
        for name, part in self.parts.items():
            if part.known.parameter("rate_deg_s") is not None:
                values = self.values(name, self.Fn[0] if self.Fn else None)
                found |= {key: values[key] for key in ("rate_deg_s", "max_deg") if key in values}
        return MappingProxyType(found)

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
                    remedy=self.TAKE_PARTS,
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

    def before(self, new: Model, places: Collection[str] | None = None) -> Before:
        """What of it a step to a new model changed, as it was: parts and values of some places
        (``hull_polynomial.Yvvr``), and what a part was told to use them; all by default.

        Examples
        --------
        >>> from pmmkit.models.edit import with_effect
        >>> from pmmkit.models.store import load_model
        >>> ship = load_model("s175-3dof")
        >>> ship.before(with_effect(ship, "memory")).absent
        ('memory',)
        """
        absent: list[str] = []
        values: dict[str, Value] = {}
        sources: dict[str, str] = {}
        options: dict[str, str] = {}
        touched = None if places is None else {place.partition(".")[0] for place in places}
        for effect, part in new.parts.items():
            if effect not in self.parts and (places is None or effect in places):
                absent.append(effect)
                continue
            was = self.parts.get(effect, Part(effect=effect))
            there = effect in self.parts and (touched is None or effect in touched)
            for name, word in part.options.items() if there else ():
                if name not in was.options:
                    absent.append(f"{effect}.{name}")
                elif was.options[name] != word:
                    options[f"{effect}.{name}"] = was.options[name]
            for name, value in part.values.items():
                place = f"{effect}.{name}"
                if places is not None and place not in places:
                    continue
                if name not in was.values:
                    absent.append(place)
                elif was.values[name] != value:
                    values[place] = was.values[name]
                    if name in was.sources:
                        sources[place] = was.sources[name]
        return Before(
            absent=tuple(absent),
            values=MappingProxyType(values),
            sources=MappingProxyType(sources),
            options=MappingProxyType(options),
            pooled=bool(new.Fn) and not self.Fn,
        )

    def restored(self, before: Before) -> Model:
        """A copy with what a step changed as it was before.

        Examples
        --------
        >>> from pmmkit.models.edit import with_effect
        >>> from pmmkit.models.store import load_model, model_text
        >>> ship = load_model("s175-3dof")
        >>> slow = with_effect(ship, "froude_linear", coefficients="typical", Fn=(0.1, 0.2, 0.3))
        >>> back = slow.restored(slow.steps[-1].before).with_(steps=ship.steps)
        >>> model_text(back) == model_text(ship)
        True
        """
        made = self.without_values(before.absent)
        parts = dict(made.parts)
        for place, value in before.values.items():
            effect, _, name = place.partition(".")
            if effect not in parts:
                continue
            part = parts[effect]
            sources = dict(part.sources)
            if place in before.sources:
                sources[name] = before.sources[place]
            else:
                sources.pop(name, None)
            parts[effect] = replace(
                part,
                values=MappingProxyType({**part.values, name: value}),
                sources=MappingProxyType(sources),
            )
        for place, word in before.options.items():
            effect, _, name = place.partition(".")
            if effect in parts:
                words = MappingProxyType({**parts[effect].options, name: word})
                parts[effect] = replace(parts[effect], options=words)
        made = replace(made, parts=MappingProxyType(parts))
        return made._pooled() if before.pooled else made

    def without_values(self, places: Iterable[str]) -> Model:
        """A copy without some parts, or values and options of parts, nor sources and covariance."""
        gone = frozenset(places)
        parts = {
            effect: replace(
                part,
                values=_left(part.values, effect, gone),
                sources=_left(part.sources, effect, gone),
                std=_left(part.std, effect, gone),
                options=_left(part.options, effect, gone),
            )
            for effect, part in self.parts.items()
            if effect not in gone
        }
        there = {place_name(effect, name) for effect, x in parts.items() for name in x.values}
        C, names = self.covariance_of([name for name in self.covariance_names if name in there])
        return replace(self, parts=MappingProxyType(parts), covariance=C, covariance_names=names)

    def covariance_of(
        self, names: Collection[str]
    ) -> tuple[NDArray[np.float64] | None, tuple[str, ...]]:
        """The covariance of some derivatives at all its Froude numbers, and their names.

        Examples
        --------
        >>> from pmmkit.models.store import load_model
        >>> known = {"covariance": np.diag([1.0, 4.0]), "covariance_names": ("Yv", "Nv")}
        >>> load_model("kvlcc2").with_(**known).covariance_of(["Nv"])
        (array([[4.]]), ('Nv',))
        """
        kept = [i for i, name in enumerate(self.covariance_names) if name in names]
        if self.covariance is None or not kept:
            return None, ()
        count, rows = len(self.covariance_names), max(len(self.Fn), 1)
        at = [row * count + i for row in range(rows) for i in kept]
        return self.covariance[np.ix_(at, at)], tuple(self.covariance_names[i] for i in kept)

    def _pooled(self) -> Model:
        """One value for all speeds, as before an effect of the speed; if no other has any."""
        over_speed = {
            f"{effect}.{name}": value
            for effect, part in self.parts.items()
            for name, value in part.values.items()
            if isinstance(value, tuple) and name not in part.known.tables
        }
        if any(len(set(value)) > 1 for value in over_speed.values()):
            return self
        parts = {
            effect: replace(
                part,
                values=MappingProxyType(
                    {
                        name: over_speed.get(f"{effect}.{name}", (value,))[0]
                        for name, value in part.values.items()
                    }
                ),
            )
            for effect, part in self.parts.items()
        }
        m = len(self.covariance_names)
        C = None if self.covariance is None else self.covariance[:m, :m]
        return replace(self, Fn=(), parts=MappingProxyType(parts), covariance=C)


def _left(content: Mapping[str, Any], effect: str, gone: frozenset[str]) -> Mapping[str, Any]:
    return MappingProxyType({k: x for k, x in content.items() if f"{effect}.{k}" not in gone})


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
        found += part.problems(len(model.Fn))
    found += _roll_problems(model)
    found += _covariance_problems(model)
    if model.convention.moment_reference_x or model.convention.motion_reference_x:
        found.append(
            "The derivatives must refer to midship; convert the table to midship before it "
            "becomes a model."
        )
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
