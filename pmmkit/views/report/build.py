"""Results as pages, each one HTML file that needs nothing else, and the files of a reduction."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial, singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.diagnosis import Diagnosis
from pmmkit.files import MODEL, write_results, write_text
from pmmkit.imo import metrics_of
from pmmkit.intake import CheckFinding
from pmmkit.models import Model, ReferenceTable, compare, save_model, write_table
from pmmkit.presentation import Described, Grid, Group, Picture, Section, counted, number, percent
from pmmkit.reduction import Reduction
from pmmkit.seakeeping import AddedResistance, Operability, Rao, Response
from pmmkit.validation import Comparison, errors_in_percent
from pmmkit.views.figures.captions import drawn
from pmmkit.views.pages.derivatives import derivatives_page
from pmmkit.views.pages.page_file import (
    Answers,
    figures_of,
    page_file,
    state_of,
    with_runs,
    worst_first,
)
from pmmkit.views.pages.records import misfit_page, run_page
from pmmkit.views.pages.sections import told_page
from pmmkit.views.pages.turning import track_page
from pmmkit.views.report import pictures, sections, tables
from pmmkit.views.report.captive.build import write_document
from pmmkit.views.report.captive.document import Document
from pmmkit.views.report.loop import Loop, diagnosis_answers, loop_answers, records_answers
from pmmkit.views.report.sections import checked_section
from pmmkit.views.report.turning import Turns, turning_section

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure


# The ship in waves as a page: motions, responses, added resistance, records.


_SHOWN: Final = 12


def seakeeping_answers(
    rao: Rao,
    *,
    added: AddedResistance | None = None,
    responses: Sequence[Response] = (),
    operability: Operability | None = None,
    more: Sequence[Described] = (),
    figures: Mapping[str, Figure] | None = None,
) -> Answers:
    """What the page of a ship in waves holds.

    more: what else is told, such as records beside the motions. figures: what else is drawn, by
    caption.
    """
    froude = rao.speed / math.sqrt(rao.g * rao.L)
    facts = {
        "length": f"{rao.L:.4g} m",
        "Froude numbers": ", ".join(f"{x:.3f}" for x in froude[:6]),
        "headings": ", ".join(f"{math.degrees(x):.0f}°" for x in rao.heading[:8]),
    }
    told = [*_told(rao, rao.plot(), "Heave, pitch and roll over the length of the waves.")]
    for answer in responses[:_SHOWN]:
        told += _named(answer, f"{answer.speed:.2f} m/s, {answer.heading_deg:.0f}°")
    if operability is not None:
        told += _told(operability, operability.plot(), "The largest value over what is allowed.")
    if added is not None:
        told += _told(added, added.plot(), "Added resistance in regular waves.")
    for item in more:
        told += _named(item, "")
    drawings = [drawn(figure, caption) for caption, figure in (figures or {}).items()]
    told += [Section(figures=drawings)] if drawings else []
    return {
        "state": state_of(title=f"{rao.name} in waves", kind="seakeeping", runs=0, model=""),
        "told ship": told_page(facts=facts, after=told),
    }


def _told(thing: Described, figure: Figure, caption: str) -> list[Section]:
    first, *rest = thing.sections()
    return [replace(first, figures=[drawn(figure, caption)]), *rest]


def _named(thing: Described, name: str) -> list[Section]:
    """Sections under the name of what they belong to."""
    found = list(thing.sections())
    before = f"{name}: " if name else ""
    return [replace(item, title=f"{before}{item.title or thing._headline()}") for item in found]


# A comparison as a page: the map of runs, each of them measured and modelled.


def comparison_answers(found: Comparison, findings: Sequence[CheckFinding] = ()) -> Answers:
    """What the page of a comparison holds; findings are those of the checks."""
    misfit = misfit_page(found)
    answers: Answers = {
        "state": state_of(
            title=found.campaign or "Tests",
            kind=found.kind,
            runs=len(found.captive) + len(found.free),
            model=found.model,
        ),
        "misfit 0": misfit,
        "told data": told_page(after=[checked_section(findings)]),
        "told where": told_page(folded=[*found.sections(), *_in_percent(found)]),
    }
    return with_runs(answers, worst_first(misfit), partial(run_page, found), "run {} 0".format)


def _in_percent(found: Comparison) -> list[Section]:
    """The errors of static runs as workshops table them."""
    static = [run for run in found.captive if not run.view.run.dynamic]
    if not static:
        return []
    table = errors_in_percent(static)
    channels = list(dict.fromkeys(table["channel"]))
    cells = {
        (row["run"], row["channel"]): f"{number(row['E_percent'], 3)} "
        f"({number(row['U_D_percent'], 2)}, {number(row['U_V_percent'], 2)})"
        for row in table.to_dict("records")
    }
    sizes = table["E_percent"].abs().groupby(table["channel"]).mean()
    rows = [
        [run.view.run.id, *(cells.get((run.view.run.id, name)) for name in channels)]
        for run in static
    ]
    rows.append(["mean size", *(number(float(sizes[name]), 3) for name in channels)])
    grid = Grid(
        head=["run", *(f"{name}: E (U_D, U_V)" for name in channels)], groups=[Group(rows=rows)]
    )
    title = "Static runs: E = measured less predicted, in per cent of the measured (k = 2)"
    return [Section(title=title, tables=[grid])]


def write_report(result: Any, path: str | Path, **about: Any) -> Path:
    """Write the report of a result as one HTML file: style and figures inside, nothing loaded.

    Parameters
    ----------
    result : Reduction, Comparison, Loop, Diagnosis, Rao or Document
        What is told: derivatives, a model beside tests, a diagnosis of captive tests or of
        records, a ship in waves, or a test report.
    path : path
        File to write, all or nothing; of a test report also ``.docx``, for Word.
    **about
        Of a reduction ``reference`` (values of a source to stand beside ours), ``turns``
        (`Turns` with the model that was found) and ``loop`` (what a simpler model of the same
        runs lacks). Of a comparison and of both diagnoses ``findings`` of the checks; of these
        ``title``, of captive tests ``runs`` (how many), of records the ``session`` that was asked.
        Of a ship in waves ``added``, ``responses``, ``operability``, and what ``more`` is told
        and by ``figures`` drawn. Of a test report the ``template`` for Word that is filled.

    Returns
    -------
    Path
        The file.
    """
    target = Path(path)
    if isinstance(result, Document):
        write_document(result, target, **about)
    else:
        write_text(target, page_file(answers_of(result, **about)))
    return target


def reduction_answers(
    reduction: Reduction,
    *,
    reference: ReferenceTable | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> Answers:
    """What the page of a reduction holds, figures drawn (see `write_report`)."""
    answers: Answers = {
        "state": state_of(
            title=reduction.campaign.title or "Captive tests",
            kind="captive",
            runs=len(reduction.runs),
            model="",
        ),
        "derivatives": derivatives_page(reduction, reference),
        "told data": told_page(
            facts=_facts(reduction),
            after=[
                sections.done(reduction),
                checked_section(reduction.findings, list(pictures.of_findings(reduction))),
                Section(title="Runs", tables=[tables.settings(reduction)]),
                sections.provenance(reduction, reference),
            ],
        ),
        "told derivatives": told_page(
            before=[
                Section(
                    title="At a glance",
                    paragraphs=[str(reduction.verdict), *_headline(reduction, turns)],
                    points=reduction.verdict.reasons,
                )
            ],
            after=[
                *sections.remarks(reduction),
                *_pictures(
                    "Over the Froude number, and together",
                    pictures.of_derivatives(reduction.table, reference),
                ),
                *_pictures("Forces and what was fitted", pictures.of_forces(reduction)),
                sections.influence(reduction),
                sections.comparison(
                    reduction, reference or ReferenceTable.published(reduction.table)
                ),
            ],
        ),
    }
    if turns:
        answers["told ship"] = told_page(after=[turning_section(turns)])
        answers["turns"] = {"before": track_page(turns.tracks[len(turns.tracks) // 2])}
    return answers | (loop_answers(loop, facts={}) if loop else {})


@singledispatch
def answers_of(result: Any, **about: Any) -> Answers:
    """What the page of a result holds."""
    del about
    raise TypeError(f"{type(result).__name__} has no page.")


answers_of.register(Comparison, comparison_answers)
answers_of.register(Diagnosis, records_answers)
answers_of.register(Loop, diagnosis_answers)
answers_of.register(Rao, seakeeping_answers)
answers_of.register(Reduction, reduction_answers)


def _facts(reduction: Reduction) -> dict[str, str]:
    campaign, table = reduction.campaign, reduction.table
    froude = [f"{x:.3f}" for x in table.Fn]
    span = ", ".join(froude) if len(froude) < 4 else f"{froude[0]} … {froude[-1]}"
    warnings = [item for item in reduction.findings if item.severity == "warning"]
    return {
        "runs used": str(len(reduction.runs)),
        "runs left out, with reasons": str(len(campaign.excluded)),
        "Froude numbers": "all" if table.pooled else span,
        "structure": str(table.provenance.get("structure", "custom")),
        "warnings of the checks": str(len(warnings)),
    }


def _headline(reduction: Reduction, turns: Turns | None) -> list[str]:
    said = []
    if turns and len(turns.tracks) > 1:
        moved = turns.changes
        low, high = sorted(track.Fn for track in turns.tracks)[:: len(turns.tracks) - 1]
        said.append(
            f"From Fn {low:.3f} to {high:.3f} a turn with {abs(turns.tracks[0].rudder_deg):g}° of "
            f"rudder changes: steady radius {percent(moved['steady_diameter_L'])}, tactical "
            f"diameter {percent(moved['tactical_diameter_L'])}, transfer "
            f"{percent(moved['transfer_L'])}, advance {percent(moved['advance_L'])}."
        )
    if reduction.propulsion is not None:
        found = reduction.propulsion
        said.append(
            f"Thrust deduction t = {found.thrust_deduction:.3f} from "
            f"{counted(len(found.runs), 'straight run')}."
        )
    return said


def _pictures(title: str, figures: Iterable[Picture]) -> list[Section]:
    found = list(figures)
    return [Section(title=title, figures=found)] if found else []


# The files of a reduction, all or nothing.


def write_reduction(
    reduction: Reduction,
    out: Path,
    *,
    model: Model | None,
    reference: ReferenceTable | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> list[str]:
    """Everything that a reduction gives, into one folder.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    out : Path
        The folder.
    model : Model or None
        The model that was made of it.
    reference : ReferenceTable, optional
        Values to compare with in the report.
    turns : Turns, optional
        Turning circles with the model.
    loop : Loop, optional
        What a simpler model lacks.

    Returns
    -------
    list of str
        Names of the files.
    """
    answers = reduction_answers(reduction, reference=reference, turns=turns, loop=loop)
    return write_results(
        out,
        (
            *_tables(reduction, reference or ReferenceTable.published(reduction.table)),
            *(
                (picture["file"], picture["svg"])
                for name, told in answers.items()
                if name.startswith("told ")
                for picture in figures_of(told)
                if picture["file"]
            ),
            *([(MODEL.file, partial(save_model, model))] if model else []),
            *(_turns(turns) if turns else ()),
            ("report.html", page_file(answers)),
        ),
    )


def _tables(reduction: Reduction, beside: ReferenceTable | None) -> Iterator[tuple[str, Any]]:
    yield "derivatives.csv", partial(write_table, reduction.table)
    yield "derivatives.nc", partial(write_table, reduction.table)
    yield "derivatives_by_method.csv", by_method(reduction, beside)
    yield "influence.csv", reduction.influences.to_pandas()
    yield "runs.csv", reduction.runs_to_pandas()
    sunk = reduction.squat_to_pandas()
    if len(sunk):
        yield "squat.csv", sunk
    yield "findings.json", [item.to_dict() for item in reduction.findings]


def _turns(turns: Turns) -> Iterator[tuple[str, Any]]:
    for track in turns.tracks:
        yield f"track_Fn{track.Fn:.3f}.csv", track.to_csv()
        yield f"metrics_Fn{track.Fn:.3f}.json", metrics_of(track)
    for name, sweep in turns.sweeps.items():
        plain = "".join(letter if letter.isalnum() else "_" for letter in name.lower())
        yield f"sweep_{plain}.csv", sweep.to_dataframe().reset_index()


def by_method(reduction: Reduction, reference: ReferenceTable | None = None) -> pd.DataFrame:
    """The derivatives by every way in one table."""
    import pandas as pd

    frames = [estimate.to_pandas() for estimate in reduction.estimates.values()]
    frames += [table.to_pandas() for table in reduction.families.values()]
    frames += [table.to_pandas().assign(run=name) for name, table in reduction.single_runs.items()]
    if reference is not None:
        beside = compare(reduction.table, reference.table)
        frames.append(
            beside[["Fn", "derivative"]].assign(
                value=beside["reference"], method=f"published: {reference.name}", runs=0
            )
        )
    columns = [*reduction.table.to_pandas().columns, "run", "share"]
    whole = pd.concat([frame.reindex(columns=columns) for frame in frames], ignore_index=True)
    whole["run"] = whole["run"].astype(object).fillna("")
    return whole[whole["value"].notna() | whole["share"].notna()].reset_index(drop=True)
