"""The form by which manoeuvring data are reported: its entries, its results, what is missing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

from pmmkit.conventions import METRICS, Criterion, Metric, cite
from pmmkit.imo import Condition, Verdict
from pmmkit.presentation import Described, Grid, Group, Section, counted, fixed, number
from pmmkit.simulation import MANOEUVRES
from pmmkit.views.pages.page_file import bare_page

if TYPE_CHECKING:
    import pandas as pd

ABSENT: Final = "not supplied"
"""What stands where nobody said."""
SIDES: Final[tuple[str, ...]] = ("port", "starboard")
ORDINALS: Final = ("first", "second", "third")
NOTES: Final = cite("msc_circ1053")
TITLE: Final = "Manoeuvring data of a ship"
STRUCTURE: Final = (
    f"Structured after the form of {NOTES}, appendix 6. It is not a form of an administration "
    "and no proof of compliance: the current texts are to be read by a person."
)
Basis = Literal["predicted", "measured", "corrected"]
STYLE: Final = Path(__file__).with_name("form.css")
BASES: Final[dict[Basis, str]] = {
    "predicted": "predicted by simulation",
    "measured": "measured in a trial",
    "corrected": "measured in a trial and corrected to full load (R = T F/B)",
}

SHADES: Final = {
    ABSENT: "absent",
    "met": "met",
    "NOT met": "failed",
    "not judged": "open",
    "not shown": "open",
    Verdict.UNSETTLED: "open",
}
"""Class of a cell that says a verdict, or that nobody said it."""


@dataclass(frozen=True, kw_only=True)
class FormField:
    """A field of the form.

    `name, title`: as a key, and as it is printed. `value`: none where nobody said. `note`: what
    belongs to it.
    """

    name: str
    title: str
    value: float | str | None = None
    unit: str = ""
    note: str = ""

    @property
    def shown(self) -> str:
        """The value as it is printed.

        Examples
        --------
        >>> FormField(name="depth", title="Depth", value=83.25, unit="m").shown
        '83.25 m'
        >>> FormField(name="engine_type", title="Engine").shown
        'not supplied'
        """
        if self.value is None:
            return ABSENT
        shown = self.value if isinstance(self.value, str) else number(self.value)
        return " ".join(part for part in (shown, self.unit, self.note) if part)


@dataclass(frozen=True, kw_only=True)
class CriterionLine:
    """A criterion with the verdict to each side.

    `metric, criterion`: what is asked of what. `limit`: largest value that meets it.
    `verdicts`: by side; by the empty side where there is none. What nobody sailed is not there.
    `runs`: run or manoeuvre behind each. `tried`: whether the results are those of another
    loading than the form is for, and were not carried to it.
    """

    metric: Metric
    criterion: Criterion
    limit: float
    unit: str
    verdicts: dict[str, Verdict]
    runs: dict[str, str]
    tried: bool = False

    @property
    def words(self) -> str:
        """The criterion as the form names it."""
        asked = self.criterion
        angles = [f"{x:g}°" for name, x in asked.settings.items() if name.endswith("_deg")]
        counted = f"{ORDINALS[asked.number - 1]} " if "{}" in self.metric.name else ""
        sailed = " ".join([MANOEUVRES[asked.manoeuvre].title, "/".join(angles)]).strip()
        told = f"{sailed}: {counted}{self.metric.title}"
        return f"{told}, as tried" if self.tried else told

    @property
    def sides(self) -> tuple[str, ...]:
        """The sides to which it is asked."""
        return SIDES if "rudder_deg" in self.criterion.settings else ("",)

    @property
    def passed(self) -> bool | None:
        """Whether it is met to all sides; None where one is missing and none fails.

        What was not carried to full load is not met by what it was as tried.
        """
        found = [x.passed for x in self.verdicts.values()]
        if False in found:
            return False
        if self.tried:
            return None
        return True if len(found) == len(self.sides) and None not in found else None

    @property
    def settled(self) -> bool:
        """Whether what the numbers stand on is ground for a verdict."""
        return all(x.settled for x in self.verdicts.values())

    @property
    def margin(self) -> float:
        """The least of the margins [L or deg]."""
        known = [x.margin for x in self.verdicts.values() if math.isfinite(x.margin)]
        return min(known, default=math.nan)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ImoForm(Described):
    """Manoeuvring data of one ship, structured after appendix 6 of MSC/Circ.1053.

    `basis`: where the results come from. `groups`: the fields under their headings.
    `conditions`: those of the standard beside what was. `lines`: the criteria with their
    results. `assumptions, remarks`: what is assumed of the engine; what a reader must know.
    `corrections`: from the loading of the trial to full load. `scale`: at which scale the
    results are. `loaded`: whether the results are carried to full load from a trial in another
    loading. `PAGE`: name of the file to print; those for machines are called the same.
    """

    PAGE: ClassVar[str] = "imo_form.html"

    name: str
    basis: Basis
    groups: tuple[tuple[str, tuple[FormField, ...]], ...]
    conditions: tuple[Condition, ...]
    lines: tuple[CriterionLine, ...]
    assumptions: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    corrections: Grid | None = None
    scale: str = ""
    loaded: bool = False

    @property
    def entries(self) -> tuple[FormField, ...]:
        """All fields."""
        return tuple(item for _, group in self.groups for item in group)

    @property
    def not_supplied(self) -> tuple[str, ...]:
        """Titles of fields, conditions and results that nobody supplied."""
        return (
            *(item.title for item in self.entries if item.value is None),
            *(f"condition: {item.title}" for item in self.conditions if item.met is None),
            *(
                f"{line.words}{f', {side}' if side else ''}"
                for line in self.lines
                for side in line.sides
                if side not in line.verdicts or not math.isfinite(line.verdicts[side].value)
            ),
        )

    @property
    def verdict(self) -> str:
        """All criteria together, in words."""
        failed = [item.words for item in self.lines if item.passed is False]
        unsettled = sum(not item.settled for item in self.lines)
        why = dict.fromkeys(
            text for line in self.lines for x in line.verdicts.values() for text in x.unsettled
        )
        unjudged = sum(item.passed is None and item.settled for item in self.lines)
        besides = [
            item.title
            for item in self.conditions
            if item.met is False and not (self.loaded and item.name == "draught")
        ]
        unknown = sum(item.met is None for item in self.conditions)
        parts = [
            f"{sum(item.passed is True for item in self.lines)} of {len(self.lines)} criteria met",
            f"NOT met: {', '.join(failed)}" if failed else "",
            f"{unsettled} {Verdict.UNSETTLED} ({' '.join(why)})" if unsettled else "",
            f"{unjudged} not judged" if unjudged else "",
            f"conditions NOT met: {', '.join(besides)}" if besides else "",
            f"{counted(unknown, 'condition')} not shown" if unknown else "",
        ]
        return "; ".join(part for part in parts if part)

    def rows(self) -> Iterator[dict[str, Any]]:
        """A row a field, condition and result, for programs."""
        for heading, group in self.groups:
            for item in group:
                yield _row(heading, item.name, item.value, unit=item.unit)
        for condition in self.conditions:
            value = condition.shown if condition.value is None else condition.value
            yield _row(
                "conditions",
                condition.name,
                value or None,
                limit=condition.standard,
                passed=condition.met,
                words=condition.shown,
            )
        for line in self.lines:
            for side in line.sides:
                found = line.verdicts.get(side)
                known = found is not None and math.isfinite(found.value)
                yield _row(
                    "results",
                    line.criterion.name,
                    found.value if found is not None and known else None,
                    side=side,
                    unit=line.unit,
                    limit=line.limit,
                    margin=found.margin if found is not None and known else None,
                    passed=None if found is None else found.passed,
                    words=line.runs.get(side, ""),
                )

    def to_pandas(self) -> pd.DataFrame:
        """The rows as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "name": self.name,
            "structure": STRUCTURE,
            "basis": self.basis,
            "scale": self.scale,
            "fields": {item.name: item.value for item in self.entries},
            "conditions": [asdict(item) for item in self.conditions],
            "results": [
                {
                    "run": line.runs.get(side, ""),
                    "paragraph": line.criterion.paragraph,
                    **verdict.to_dict(),
                }
                for line in self.lines
                for side, verdict in line.verdicts.items()
            ],
            "verdict": self.verdict,
            "assumptions": list(self.assumptions),
            "remarks": list(self.remarks),
            "not_supplied": list(self.not_supplied),
        }

    def html(self) -> str:
        """The form as a page to print: one sheet of A4 without scripts, which needs nothing."""
        from markupsafe import Markup

        return bare_page(
            "imo_form/form.html",
            title=f"{TITLE}: {self.name}",
            style=STYLE.read_text("utf-8"),
            form=self,
            heading=TITLE,
            structure=STRUCTURE,
            basis=BASES[self.basis],
            conditions=conditions_grid(self.conditions),
            results=results_grids(self.lines),
            shades=SHADES,
            table=lambda grid: Markup(grid.html(shades=SHADES)),
        )

    def files(self) -> Iterator[tuple[str, Any]]:
        """The form with the names of its files: to print, and for machines."""
        name = Path(self.PAGE).stem
        yield self.PAGE, self.html()
        yield f"{name}.csv", self.to_pandas()
        yield f"{name}.json", self.to_dict()

    def _headline(self) -> str:
        return f"{self.name}, {BASES[self.basis]}: {self.verdict}"

    def _sections(self) -> Sequence[Section]:
        fields = [
            Group(title=heading, rows=[[item.title, item.shown] for item in group])
            for heading, group in self.groups
        ]
        return [
            Section(paragraphs=[STRUCTURE, *([f"Scale: {self.scale}"] if self.scale else [])]),
            Section(tables=[Grid(head=["", ""], groups=fields, texts=(1,))]),
            Section(title="Conditions", tables=[conditions_grid(self.conditions)]),
            Section(
                title=f"Results, {BASES[self.basis]}",
                tables=results_grids(self.lines),
                points=list(self.assumptions),
            ),
            *(
                [Section(title="Correction to full load", tables=[self.corrections])]
                if self.corrections
                else []
            ),
            *([Section(title="Remarks", points=list(self.remarks))] if self.remarks else []),
            Section(title="Not supplied", paragraphs=["; ".join(self.not_supplied) or "nothing"]),
        ]


def _row(part: str, name: str, value: Any, **more: Any) -> dict[str, Any]:
    whole = {
        "part": part,
        "name": name,
        "side": "",
        "value": value,
        "unit": "",
        "limit": None,
        "margin": None,
        "passed": None,
        "words": "",
    }
    return whole | more


def conditions_grid(conditions: Sequence[Condition]) -> Grid:
    """Conditions of the standard beside what was, as a table."""
    met = {True: "met", False: "NOT met", None: "not shown"}
    rows = [[item.title, item.shown or ABSENT, item.standard, met[item.met]] for item in conditions]
    head = ["condition", "was", "the standard asks for", ""]
    return Grid(head=head, groups=[Group(rows=rows)], texts=(1, 2, 3))


def results_grids(lines: Sequence[CriterionLine]) -> list[Grid]:
    """Criteria with their results as tables: those to port and starboard, and those to no side."""
    return [
        _results(group, sides)
        for sides in (SIDES, ("",))
        if (group := [line for line in lines if line.sides == sides])
    ]


def _results(lines: Sequence[CriterionLine], sides: tuple[str, ...]) -> Grid:
    rows = [
        [
            line.words,
            line.criterion.paragraph,
            *(cell for side in sides for cell in _told(line, side)),
            Verdict.in_unit(number(line.limit), line.unit),
            Verdict.what_follows(line.passed, settled=line.settled),
        ]
        for line in lines
    ]
    columns = [name for side in sides for name in (side or "value", "margin")]
    head = ["criterion", "paragraph", *columns, "limit", ""]
    return Grid(head=head, groups=[Group(rows=rows)], texts=(1, len(head) - 1))


def _told(line: CriterionLine, side: str) -> tuple[str, str]:
    """Value and margin to a side."""
    found = line.verdicts.get(side)
    if found is None or not math.isfinite(found.value):
        return ABSENT, ""
    return (
        Verdict.in_unit(fixed(found.value, 2), line.unit),
        Verdict.in_unit(fixed(found.margin, 2, signed=True), line.unit),
    )


def lines_of(
    verdicts: Sequence[tuple[str, Verdict]], *, L: float, speed: float
) -> tuple[CriterionLine, ...]:
    """Verdicts by criterion and side; of several to one side that with the least margin.

    L, speed [m].
    """
    found = []
    for metric, criterion in METRICS.criteria:
        own = [(run, x) for run, x in verdicts if x.criterion == criterion.name]
        sides: dict[str, Verdict] = {}
        runs: dict[str, str] = {}
        for run, verdict in sorted(own, key=lambda pair: _least(pair[1])):
            if verdict.side not in sides:
                sides[verdict.side], runs[verdict.side] = verdict, run
        limits = [x.limit for x in sides.values()] or [criterion.limit_for(L, speed)]
        found.append(
            CriterionLine(
                metric=metric,
                criterion=criterion,
                limit=min(limits),
                unit="L" if metric.length else metric.unit,
                verdicts=sides,
                runs=runs,
            )
        )
    return tuple(found)


def _least(verdict: Verdict) -> float:
    return verdict.margin if math.isfinite(verdict.margin) else math.inf
