"""DerivativeTable: derivatives by Froude number with their covariance."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import TableError, UnknownNameError, did_you_mean
from pmmkit.conventions import CHANNELS, Convention, Ship, Water, parse_derivative
from pmmkit.numerics import Array, coverage_factor
from pmmkit.presentation import Described, Grid, Group, Section, counted, listed, plus_minus

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pmmkit.plotting import Figure


# What every file of a derivative table holds besides its rows, as plain data.


KIND: Final = "pmmkit derivative table"
SCHEMA: Final = 1
NESTED: Final = ("convention", "ship", "water", "notes", "provenance")
"""Attributes that hold more than a text or a number."""


Use = Literal["usable", "usable with doubts", "not usable"]


@dataclass(frozen=True, kw_only=True)
class TableVerdict:
    """Whether a derivative table can be used.

    Parameters
    ----------
    faults : tuple of str
        What makes it not usable, the gravest first.
    doubts : tuple of str
        What stands against it besides.
    conditions : tuple of str
        What must be right for it, since its runs cannot tell: what most hangs on first.

    Examples
    --------
    >>> print(TableVerdict(conditions=("the gauges' scale (X, Y, N)", "the inertia (Izz, xG)")))
    Usable, if the gauges' scale (X, Y, N) and the inertia (Izz, xG) are right.
    >>> print(TableVerdict(doubts=("Y: misfit.",)))
    Usable with the 1 doubt above.
    >>> print(TableVerdict(faults=("Yv is positive, which no hull has.",)))
    Not usable: Yv is positive, which no hull has.
    """

    faults: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    conditions: tuple[str, ...] = ()
    MOST: ClassVar[int] = 5
    """Conditions that the line names."""

    @property
    def use(self) -> Use:
        """The verdict in one word."""
        if self.faults:
            return "not usable"
        return "usable with doubts" if self.doubts else "usable"

    @property
    def reasons(self) -> tuple[str, ...]:
        """All that stands against it, the gravest first."""
        return (*self.faults, *self.doubts)

    @property
    def proviso(self) -> str:
        """What it hangs on, as the end of a sentence; empty where nobody said it, and of what is
        not usable."""
        if self.faults or not self.conditions:
            return ""
        named, more = list(self.conditions[: self.MOST]), len(self.conditions) - self.MOST
        named += [f"{counted(more, 'thing')} more in the notes"] if more > 0 else []
        return f", if {listed(named)} {'are' if len(named) > 1 else 'is'} right"

    def __str__(self) -> str:
        if self.use == "usable":
            return f"Usable{self.proviso}."
        if self.use == "usable with doubts":
            return f"Usable with the {counted(len(self.doubts), 'doubt')} above{self.proviso}."
        more = len(self.reasons) - 1
        rest = f" ({more} more above)" if more else ""
        return f"Not usable: {self.faults[0]}{rest}"

    def told(self) -> dict[str, Any]:
        """As plain data for who reads it: use, reasons, conditions, and the line."""
        return {
            "use": self.use,
            "reasons": list(self.reasons),
            "conditions": list(self.conditions),
            "line": str(self),
        }

    def to_dict(self) -> dict[str, Any]:
        """As plain data, as a table keeps it."""
        return {
            "use": self.use,
            "faults": list(self.faults),
            "doubts": list(self.doubts),
            "conditions": list(self.conditions),
        }


def kept_verdict(provenance: Mapping[str, Any]) -> TableVerdict | None:
    """The verdict that a table's provenance holds; None where nobody judged it.

    Examples
    --------
    >>> kept_verdict({"verdict": {"use": "usable", "faults": [], "doubts": []}}).use
    'usable'
    """
    kept = provenance.get("verdict")
    if not isinstance(kept, Mapping):
        return None
    faults, doubts, conditions = (
        tuple(map(str, kept.get(name, ()))) for name in ("faults", "doubts", "conditions")
    )
    return TableVerdict(faults=faults, doubts=doubts, conditions=conditions)


def plain(value: Any) -> Any:
    """A value as JSON can hold it; what JSON does not know becomes text."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else repr(value)
    if value is None or isinstance(value, bool | int | str):
        return value
    return str(value)


def digest(words: Mapping[str, Any], arrays: Sequence[Array], counts: NDArray[np.int64]) -> str:
    """SHA-256 over words, arrays and counts; the same on every machine."""
    text = json.dumps(words, sort_keys=True, separators=(",", ":"))
    total = hashlib.sha256(text.encode())
    for array in arrays:
        tidy = np.where(np.isnan(array), np.nan, array + 0.0)
        total.update(np.ascontiguousarray(tidy, dtype="<f8").tobytes())
    total.update(np.ascontiguousarray(counts, dtype="<i8").tobytes())
    return total.hexdigest()


def flat(attributes: Mapping[str, Any]) -> dict[str, str | int]:
    """Attributes for files that know only texts and numbers: nested entries as JSON."""
    return {key: json.dumps(value) if key in NESTED else value for key, value in attributes.items()}


CONFIDENCE = 0.95
SMALL: Final = 0.03
"""Values of this size and below are told times 10³."""
FORCES: Final[Mapping[str, str]] = {
    "X": "Surge force X",
    "Y": "Sway force Y",
    "N": "Yaw moment N",
    "K": "Roll moment K",
}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class DerivativeTable(Described):
    """Derivatives over the Froude number, with covariance, convention and origin.

    A value that the runs do not determine is NaN, never zero.

    Parameters
    ----------
    names : tuple of str
        Derivatives, canonical names.
    Fn : array (k,)
        Froude numbers, ascending; one NaN for a table pooled over all speeds.
    value : array (k, n)
        Values.
    covariance : array (k, n, k, n)
        Covariance of all values, across Froude numbers too (shared errors tie them together).
        NaN where a value or its uncertainty is not known.
    dof : array (k, n)
        Degrees of freedom of each standard uncertainty; inf where it is known.
    method : array of str (k, n)
        How each value was found.
    runs : array of int (k, n)
        How many runs it rests on.
    convention : Convention
        What the numbers mean.
    ship, water : Ship, Water
        The lengths behind the non-dimensional values.
    notes : tuple of str
        What a reader must know: derivatives that move together, are at a boundary, not excited.
    provenance : mapping
        Where it comes from.
    """

    names: tuple[str, ...]
    Fn: Array
    value: Array
    covariance: Array
    dof: Array
    method: NDArray[np.str_]
    runs: NDArray[np.int64]
    convention: Convention
    ship: Ship
    water: Water
    notes: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        k, n = len(self.Fn), len(self.names)
        shapes = {
            "value": (k, n),
            "covariance": (k, n, k, n),
            "dof": (k, n),
            "method": (k, n),
            "runs": (k, n),
        }
        wrong = [
            f"{name} has the shape {getattr(self, name).shape}, expected {shape}."
            for name, shape in shapes.items()
            if getattr(self, name).shape != shape
        ]
        if len(set(self.names)) != n:
            wrong.append("Some derivatives stand twice.")
        if k == 0 or n == 0:
            wrong.append("It holds no values.")
        elif not self.pooled and not (
            np.isfinite(self.Fn).all() and self.Fn[0] >= 0 and np.all(np.diff(self.Fn) > 0)
        ):
            wrong.append(f"Froude numbers must be given, none negative, ascending: {self.Fn}.")
        if wrong:
            raise TableError(wrong, title="Not a derivative table")

    @property
    def pooled(self) -> bool:
        """Whether one set of values stands for all speeds."""
        return len(self.Fn) == 1 and bool(np.isnan(self.Fn[0]))

    @property
    def verdict(self) -> TableVerdict | None:
        """What its reduction found against it; None for a table that nobody judged."""
        return kept_verdict(self.provenance)

    def judged(self, verdict: TableVerdict) -> DerivativeTable:
        """The table, which keeps what was found against it."""
        return self.with_(provenance={**self.provenance, "verdict": verdict.to_dict()})

    @property
    def std(self) -> Array:
        """Standard uncertainties, array (k, n)."""
        k, n = self.value.shape
        flat = self.covariance.reshape(k * n, k * n)
        return np.sqrt(np.diagonal(flat)).reshape(k, n)

    @property
    def widening(self) -> Array:
        """Standard deviation of the normal law with the same 95 % interval, over `std` (k, n).

        The intervals of the table are Student's: what is drawn with its standard uncertainties
        alone would spread too little where few degrees of freedom stand behind them (JCGM
        101:2008, 6.4.9).
        """
        wide: Array = coverage_factor(self.dof) / coverage_factor(np.inf)
        return wide

    def interval(self, confidence: float = CONFIDENCE) -> tuple[Array, Array]:
        """Lower and upper ends of the confidence intervals, arrays (k, n)."""
        half = coverage_factor(self.dof, confidence) * self.std
        return self.value - half, self.value + half

    def index(self, name: str) -> int:
        """Column of a derivative, factors in any order."""
        wanted = parse_derivative(name).name
        if wanted not in self.names:
            guess = did_you_mean(wanted, self.names) or "."
            raise UnknownNameError(
                f"The table has no {name}{guess} It has {', '.join(self.names)}."
            )
        return self.names.index(wanted)

    def __contains__(self, name: str) -> bool:
        return parse_derivative(name).name in self.names

    def __getitem__(self, name: str) -> Array:
        """Values of one derivative over Fn, array (k,)."""
        return self.value[:, self.index(name)]

    def at(self, Fn: float | None = None) -> dict[str, float]:
        """The values at one Froude number of the table as a dict (the only set where pooled)."""
        row = 0
        if Fn is not None and not self.pooled:
            near = np.flatnonzero(np.isclose(self.Fn, Fn, rtol=1e-3, atol=0))
            if len(near) == 0:
                rows = ", ".join(f"{x:.4g}" for x in self.Fn)
                raise TableError(f"Fn {Fn:g} is no row of the table ({rows}); interpolate instead.")
            row = int(near[0])
        elif len(self.Fn) > 1:
            raise TableError(f"Say which Fn: {', '.join(f'{x:.4g}' for x in self.Fn)}.")
        return dict(zip(self.names, self.value[row].tolist(), strict=True))

    def with_(self, **changes: Any) -> DerivativeTable:
        """A copy with some entries changed."""
        return replace(self, **changes)

    def select(self, names: Sequence[str]) -> DerivativeTable:
        """The table with some of its derivatives, in the order asked for."""
        columns = [self.index(name) for name in names]
        return self.with_(
            names=tuple(self.names[column] for column in columns),
            value=self.value[:, columns],
            covariance=self.covariance[:, columns][:, :, :, columns],
            dof=self.dof[:, columns],
            method=self.method[:, columns],
            runs=self.runs[:, columns],
        )

    @property
    def fingerprint(self) -> str:
        """SHA-256 over everything the table holds, the same whatever file it is kept in."""
        words = {"names": self.names, "method": self.method.tolist(), **self._meaning()}
        return digest(words, (self.Fn, self.value, self.covariance, self.dof), self.runs)

    def attributes(self) -> dict[str, Any]:
        """Kind, schema, fingerprint, convention, ship, water, notes, provenance, as plain data."""
        return {"kind": KIND, "schema": SCHEMA, "fingerprint": self.fingerprint, **self._meaning()}

    def _meaning(self) -> dict[str, Any]:
        """What the numbers mean and where they come from, as plain data."""
        return {
            "convention": plain(asdict(self.convention)),
            "ship": plain(asdict(self.ship)),
            "water": plain(asdict(self.water)),
            "notes": list(self.notes),
            "provenance": plain(self.provenance),
        }

    def to_pandas(self) -> pd.DataFrame:
        """A row per Froude number and derivative: Fn, derivative, value, std, ci_low, ci_high,
        method, runs. Fn is NaN for a pooled table."""
        import pandas as pd

        k, n = self.value.shape
        low, high = self.interval()
        return pd.DataFrame(
            {
                "Fn": np.repeat(self.Fn, n),
                "derivative": np.tile(np.array(self.names, dtype=object), k),
                "value": self.value.ravel(),
                "std": self.std.ravel(),
                "ci_low": low.ravel(),
                "ci_high": high.ravel(),
                "method": self.method.ravel().astype(object),
                "runs": self.runs.ravel(),
            }
        )

    def to_xarray(self) -> xr.Dataset:
        """A Dataset as in the NetCDF file: value, covariance, dof, method and runs over Fn and
        derivative (Fn_2 and derivative_2 for the second pair of the covariance)."""
        import xarray as xr

        over = ("Fn", "derivative")
        names = np.array(self.names, dtype=object)
        return xr.Dataset(
            {
                "value": (over, self.value),
                "covariance": ((*over, "Fn_2", "derivative_2"), self.covariance),
                "dof": (over, self.dof),
                "method": (over, self.method.astype(object)),
                "runs": (over, self.runs),
            },
            coords={"Fn": self.Fn, "derivative": names, "Fn_2": self.Fn, "derivative_2": names},
            attrs=flat(self.attributes()),
        )

    @property
    def speeds(self) -> list[str]:
        """Names of the rows: Froude numbers, or all speeds."""
        return ["all speeds"] if self.pooled else [f"Fn {value:.3f}" for value in self.Fn]

    @property
    def factor(self) -> float:
        """What people are told the values times: 1000 where most are small."""
        known = np.abs(self.value[np.isfinite(self.value)])
        return 1e3 if len(known) and np.median(known) < SMALL else 1.0

    @property
    def scaling(self) -> str:
        """The factor in words; empty where it is 1."""
        return "All values times 10³. " if self.factor == 1e3 else ""

    def grid(
        self,
        *,
        label: Callable[[str], str] = str,
        beside: tuple[str, Mapping[str, str]] | None = None,
    ) -> Grid:
        """Every derivative with its 95 % interval, a column per Froude number.

        Parameters
        ----------
        label : callable
            How the name of a derivative is written.
        beside : (str, mapping of str to str), optional
            Values of a source for one more column, with its name.
        """
        low, high = self.interval()
        half = self.factor * (high - low) / 2
        value = self.factor * self.value
        groups = []
        for channel in CHANNELS:
            names = [name for name in self.names if name[0] == channel]
            rows = [
                [
                    label(name),
                    *(
                        plus_minus(x, y) or None
                        for x, y in zip(
                            value[:, column].tolist(), half[:, column].tolist(), strict=True
                        )
                    ),
                    *([beside[1].get(name)] if beside else []),
                ]
                for name in names
                for column in (self.index(name),)
            ]
            if rows:
                groups.append(Group(title=FORCES[channel], rows=rows))
        return Grid(
            head=["", *self.speeds, *([beside[0]] if beside else [])],
            groups=groups,
            caption=f"{self.scaling}Value ± half of the 95 % interval; – not determined by these "
            f"runs; system {self.convention.meaning}.",
        )

    def plot(
        self,
        names: Sequence[str] | None = None,
        *,
        beside: tuple[str, Mapping[str, Array]] | None = None,
    ) -> Figure:
        """Derivatives over the Froude number with their 95 % intervals, a small panel each.

        Parameters
        ----------
        names : sequence of str, optional
            Which; by default those that have values at two Froude numbers or more.
        beside : (str, mapping of str to array (k,)), optional
            Values of a source in the convention of the table, with its name.

        Raises
        ------
        TableError
            If there is nothing to draw over the Froude number.
        """
        from pmmkit.models.tables.figures import over_froude

        if self.pooled:
            raise TableError("A table pooled over all speeds has nothing to draw over Fn.")
        known = np.isfinite(self.value).sum(axis=0)
        drawn = list(names or [x for x, k in zip(self.names, known, strict=True) if k > 1])
        if not drawn:
            raise TableError("No derivative has values at two Froude numbers: nothing to draw.")
        some = self.select(drawn)
        return over_froude(
            some.names,
            self.Fn,
            some.value,
            some.interval(),
            convention=self.convention,
            factor=self.factor,
            beside=beside,
        )

    def _headline(self) -> str:
        ends = f"{self.Fn[0]:.3f} to {self.Fn[-1]:.3f}"
        over = f"at {counted(len(self.Fn), 'Froude number')}, {ends}"
        if self.pooled:
            over = "over all speeds"
        return f"{counted(len(self.names), 'derivative')} of {self.ship.name} {over}"

    def _sections(self) -> Sequence[Section]:
        ways = ", ".join(dict.fromkeys(self.method[np.isfinite(self.value)].tolist()))
        runs = int(self.runs.max())
        rest = f"; up to {counted(runs, 'run')} behind a value" if runs else ""
        notes = [Section(title="Notes", points=self.notes)] if self.notes else []
        return [
            Section(paragraphs=[f"L = {self.ship.L:g} m; how found: {ways}{rest}"]),
            Section(tables=[self.grid()]),
            *notes,
        ]


def from_values(
    values: Mapping[str, float | Sequence[float]],
    *,
    ship: Ship,
    water: Water,
    Fn: Sequence[float] | None = None,
    std: Mapping[str, float | Sequence[float]] | None = None,
    convention: Convention | None = None,
    method: str = "given",
    notes: Sequence[str] = (),
    provenance: Mapping[str, Any] | None = None,
) -> DerivativeTable:
    """A table from plain numbers.

    Parameters
    ----------
    values : mapping of str to float or sequence
        Values by name; a sequence gives one per Froude number.
    ship, water : Ship, Water
        Reference lengths.
    Fn : sequence of float, optional
        Froude numbers; a pooled table without it.
    std : mapping, optional
        Standard uncertainties, taken as independent; unknown (NaN) where absent.
    convention : Convention, optional
        Meaning of the numbers.
    method : str
        Entry of the column `method`.
    notes, provenance
        As in `DerivativeTable`.

    Raises
    ------
    TableError
        If a sequence is not one number per Froude number, or `std` names what `values` does not.
    UnknownNameError
        If a name is not that of a derivative.

    Examples
    --------
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> values = {"Yv": [-.01, -.012], "Nv": -.004}
    >>> table = from_values(values, ship=ship, water=Water(), Fn=[.1, .2])
    >>> table["Nv"]
    array([-0.004, -0.004])
    """
    grid = np.array([np.nan]) if Fn is None else np.asarray(Fn, float)
    names = tuple(parse_derivative(name).name for name in values)
    k, n = len(grid), len(names)
    given = {parse_derivative(name).name: item for name, item in (std or {}).items()}
    wrong = [
        f"{name}: {np.size(item)} numbers for {k} Froude numbers."
        for name, item in (*values.items(), *given.items())
        if np.shape(item) not in ((), (1,), (k,))
    ]
    wrong += [f"{name} has a std but no value." for name in given if name not in names]
    if not names:
        wrong.append("No values are given.")
    if wrong:
        raise TableError(wrong, title="Not a derivative table")
    value = np.stack(
        [np.broadcast_to(np.asarray(item, float), (k,)) for item in values.values()], 1
    )
    deviation = np.stack(
        [np.broadcast_to(np.asarray(given.get(name, np.nan), float), (k,)) for name in names],
        axis=1,
    )
    covariance = np.zeros((k * n, k * n))
    np.fill_diagonal(covariance, deviation.ravel() ** 2)
    return DerivativeTable(
        names=names,
        Fn=grid,
        value=value,
        covariance=covariance.reshape(k, n, k, n),
        dof=np.full((k, n), np.inf),
        method=np.full((k, n), method),
        runs=np.zeros((k, n), dtype=np.int64),
        convention=convention or Convention(),
        ship=ship,
        water=water,
        notes=tuple(notes),
        provenance=MappingProxyType(dict(provenance or {})),
    )
