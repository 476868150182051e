"""Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from pmmkit.actions.jobs.reduce import ReduceSettings, reduced
from pmmkit.actions.jobs.trial import TrialSettings, trial
from pmmkit.actions.outcome import Outcome, results_folder, words_of
from pmmkit.actions.setting import SettingError, setting, settings, stem
from pmmkit.actions.shared import Out
from pmmkit.presentation import WIDE, counted, quoted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import Question
    from pmmkit.models import Model


# Somebody's own files as far as they go: looked at, drafted, checked, reduced, turned.
#
# What stops the way is said with the lines of the campaign file that would open it. Nothing is
# computed with particulars that nobody stated; what is guessed and computed with stands above the
# results and in their title.


_HEADS: Final = {
    "needed": "Needed before it can go on:",
    "guessed": "Guessed and computed with; take the word TODO away where it is right:",
    "estimated": "Estimated from the particulars; what is known can be stated there:",
    "off": "Lines that are off; write them where they apply:",
}
_SHIPS: Final = 200
"""Drawn for the interval of the turn."""
_MOST: Final = 12
"""Questions of a kind that are printed; --json has all."""


@dataclass(frozen=True, kw_only=True)
class DraftProgress:
    """How far it went.

    `results`: where results go; a new folder if absent. `done`: stages with what came of each.
    `stopped`: what stopped it, in words; empty where nothing did. `wrong`: whether that is a
    contradiction of the data. `questions`: what a person must say or confirm. `result`: of the
    reduction, or of the measured manoeuvres. `interval`: tactical diameter over L with 95 %,
    estimates included. `then`: the command that comes after, where nothing stopped it and
    nothing is guessed.
    """

    file: Path
    results: Path | None = None
    done: tuple[tuple[str, str], ...] = ()
    stopped: str = ""
    wrong: bool = False
    questions: tuple[Question, ...] = ()
    result: Outcome | None = None
    interval: tuple[float, float] | None = None
    then: str = ""

    def after(self, stage: str, words: str) -> DraftProgress:
        """One stage further."""
        return replace(self, done=(*self.done, (stage, words)))

    @property
    def place(self) -> Path:
        """The campaign as it is typed."""
        from pmmkit.files import CAMPAIGN

        return self.file.parent if self.file.name == CAMPAIGN.file else self.file

    @property
    def guesses(self) -> int:
        """Answers that nobody has confirmed and that are computed with."""
        return sum(item.kind == "guessed" for item in self.questions)


def as_far_as_it_goes(path: Path, *, ship: str | None = None, out: Path | None = None) -> Outcome:
    """Bring files to a turn, or to the questions that stand before it."""
    from pmmkit.base import PmmkitError

    way = _with_campaign(path, ship, out)
    try:
        way, campaign = _checked(way)
        if not way.stopped:
            done = "trial" if campaign.kind == "free-running" else "reduced"
            results = way.results or results_folder(out, f"{stem(way.file)}-{done}")
            if campaign.kind == "free-running":
                way = _measured(way, campaign, results)
            else:
                way = _reduced(way, campaign, results)
    except PmmkitError as error:
        way = replace(way, stopped=words_of(error))
    return _told(way)


def _with_campaign(path: Path, ship: str | None, out: Path | None) -> DraftProgress:
    """The campaign that is there, or a draft in a folder of its own."""
    from pmmkit.base import FileExists
    from pmmkit.files import CAMPAIGN, write_text
    from pmmkit.intake import campaign_draft, look, questions_of, written

    own = path / CAMPAIGN.file if path.is_dir() else path
    if own.is_file() and (own.suffix == ".toml" or look(own).campaigns):
        text = own.read_text("utf-8", errors="replace") if own.suffix == ".toml" else ""
        found = DraftProgress(file=own, questions=questions_of(text))
        return found.after("read", f"{quoted(own)} is there and is taken as it stands")
    folder = results_folder(out, f"{stem(path)}-first")
    target = folder / CAMPAIGN.file
    if target.exists():
        raise FileExists(
            f"{target} is there: it was not replaced. To go on with it: "
            f"pmmkit demo --my-data {quoted(folder)}. Else name another --out."
        )
    draft = campaign_draft(path, target, ship=ship)
    text = written(draft).text
    write_text(target, text)
    entries = [*draft.runs, *draft.tables]
    tests = sorted({entry.test or "kind unknown" for entry in entries})
    count = len(entries) + sum(len(saved) for _, saved in draft.saved)
    way = DraftProgress(file=target, results=folder / "results", questions=questions_of(text))
    way = way.after("read", f"{count} {draft.kind} tests: {', '.join(tests)}")
    way = way.after("draft", f"{quoted(target)}; nothing was written to {quoted(path)}")
    if not draft.repeated:
        return way
    more = f" and {len(draft.repeated) - 1} more" if len(draft.repeated) > 1 else ""
    told = f"{draft.repeated[0]}{more}: other tables tell the same tests, see the end of the draft"
    return way.after("leave", told)


def _checked(way: DraftProgress) -> tuple[DraftProgress, Campaign]:
    """The campaign opened and its runs held against one another."""
    from pmmkit.campaigns import open_campaign
    from pmmkit.intake import examine, name_runs

    campaign = open_campaign(way.file)
    findings = examine(campaign)
    contradictions = [item for item in findings if item.severity == "error"]
    if contradictions:
        told = [
            " ".join(filter(None, (f"  {item.check}: {item.message}", item.remedy, where)))
            for item in contradictions
            for where in (f"Runs: {name_runs(item.runs)}." if item.runs else "",)
        ]
        stopped = "\n".join(["The checks contradict it:", *told, *_CORRECTION])
        return replace(way, stopped=stopped, wrong=True), campaign
    doubts = [item for item in findings if item.severity == "warning"]
    words = (
        f"no contradiction in {counted(len(campaign), 'run')}, {counted(len(doubts), 'warning')}"
    )
    return way.after("check", words), campaign


_CORRECTION: Final = (
    "A correction is written before [end] of the campaign file:",
    "  [[corrections]]",
    '  runs = ["..."]                 # their ids; * stands for any letters',
    '  action = "exclude"             # or another that is named above',
    '  reason = "..."                 # it stands in the report',
)


def _reduced(way: DraftProgress, campaign: Campaign, results: Path) -> DraftProgress:
    """Derivatives, the model and its turn."""
    from pmmkit.base import PmmkitError
    from pmmkit.files import MODEL
    from pmmkit.models import load_model

    guesses = counted(way.guesses, "guess")
    title = f"{campaign.title}, {guesses} not confirmed" if way.guesses else ""
    # By the largest structure that they determine.
    result = reduced(ReduceSettings(campaign=way.file, structure="auto"), results, title=title)
    content = result.content
    way = replace(way, result=result)
    if "depths" in content:
        way = way.after("reduce", f"{len(content['depths'])} depths, a folder for each")
        ratios = ",".join(f"{item['h_T']:.4g}" for item in content["depths"])
        speed = max(run.settings.speed for run in campaign.runs)
        sweep = f"pmmkit sweep {quoted(results)} --depths {ratios} --speeds {speed:.4g}"
        return replace(way, then=sweep)
    way = way.after("reduce", f"structure {content['structure']}, {content['verdict']['use']}")
    if content["model"] is None:
        return replace(way, stopped=" ".join(content["model_lacks"]))
    file = results / MODEL.file
    model = load_model(file)
    estimates = _estimates(model, way.file)
    way = replace(
        way,
        then=f"pmmkit compare {quoted(file)} {quoted(way.place)}",
        questions=(*way.questions, *estimates),
    )
    lent = [part.effect for part in model.parts.values() if part.estimated]
    way = way.after("model", f"{quoted(file)}; estimates in {', '.join(lent) or 'nothing'}")
    if not content["turns"]:
        return way
    try:
        return _turned(way, model)
    except PmmkitError as error:
        return way.after("turn", f"its interval is not known: {words_of(error)}")


def _turned(way: DraftProgress, model: Model) -> DraftProgress:
    """The tactical diameter at the middle of the speeds, with its interval."""
    from pmmkit.conventions import Criterion
    from pmmkit.simulation import monte_carlo

    froude = model.Fn[len(model.Fn) // 2]
    speed = froude * math.sqrt(model.water.g * model.ship.L)
    many = monte_carlo(model, speed=speed, rudder_deg=Criterion.HARD_OVER, n=_SHIPS)
    low, high = many.interval("tactical_diameter_L")
    return replace(way, interval=(low, high)).after(
        "turn",
        f"{Criterion.HARD_OVER:g}° of rudder at Fn {froude:.3f}: tactical diameter {low:.2g} to "
        f"{high:.2g} L with 95 %, estimates included",
    )


def _estimates(model: Model, file: Path) -> Iterator[Question]:
    """What a turn depends on most of what nobody stated, and where it can be."""
    from pmmkit.intake import Question
    from pmmkit.models import SECTIONS

    lines = file.read_text("utf-8", errors="replace").splitlines() if file.suffix == ".toml" else []
    place = next((k for k, line in enumerate(lines, start=1) if line == "[end]"), len(lines) + 1)
    for section in SECTIONS.values():
        part = model.parts.get(section.effect_name)
        for name in section.wanted if part else ():
            own = section.effect.parameter(name)
            if part is None or own is None or name not in part.estimated:
                continue
            value = part.values[name]
            spread = f" ± {WIDE * part.std[name]:.2g}" if name in part.std else ""
            yield Question(
                lines=(place,),
                key=f"{section.name}.{name}",
                text=f"{own.text}, in a table [{section.name}] before that line",
                kind="estimated",
                guess=f"{value:.3g}{spread} {own.unit}".rstrip(" -"),
                why=part.source_of(name),
            )


def _measured(way: DraftProgress, campaign: Campaign, results: Path) -> DraftProgress:
    """The manoeuvres of free-running records; a library ship is compared with them, another one
    becomes a model by her card."""
    from pmmkit.models import load_ship, ships

    known = [name for name in ships() if load_ship(name) == campaign.ship]
    then = f"pmmkit compare {known[0]} {quoted(way.place)}" if known else "pmmkit card form"
    result = trial(TrialSettings(campaign=way.file, out=results))
    measured = f"{len(result.content['runs'])} manoeuvres"
    way = replace(way, result=result, then=then).after("measure", measured)
    lacking = [x for x in way.questions if x.key in _OF_A_MODEL and x.kind != "guessed"]
    if not (known and lacking):
        return way
    asked = tuple(
        replace(x, kind="needed" if x in lacking else "off") if x.kind != "guessed" else x
        for x in way.questions
    )
    return replace(way, questions=asked, stopped="No model is compared without them.")


_OF_A_MODEL: Final = ("columns.delta", "columns.n")
"""Lines of records without which no model is compared with them."""


def _told(way: DraftProgress) -> Outcome:
    if not way.stopped:
        # What was asked stood in nobody's way.
        off = (replace(x, kind="off") if x.kind == "needed" else x for x in way.questions)
        way = replace(way, questions=tuple(off))
    lines = [f"{stage:>8}  {words}" for stage, words in way.done]
    if way.stopped:
        lines.append(f"    stop  {_why(way)}")
    if way.result is not None:
        if way.guesses:
            lines += ["", f"PROVISIONAL: computed with {counted(way.guesses, 'guess')} below."]
        lines += ["", *way.result.lines]
    lines += _asked(way.questions, way.file)
    again = f"pmmkit demo --my-data {quoted(way.place)}"
    following = way.then if way.then and not way.stopped else again
    lines += ["", f"Next: {following}"]
    if way.guesses and following != again:
        lines.append(f"Once the guesses are confirmed: {again}")
    status = way.result.status if way.result is not None else int(way.wrong)
    content = {
        "campaign": str(way.file),
        "stages": [{"name": name, "words": words} for name, words in way.done],
        "stopped": way.stopped,
        "provisional": bool(way.guesses) and way.result is not None,
        "questions": [asdict(item) for item in way.questions],
        "tactical_diameter_L": way.interval,
        "result": None if way.result is None else way.result.content,
        "next": following,
    }
    return Outcome(content=content, lines=lines, status=status)


def _why(way: DraftProgress) -> str:
    """What stopped it: the answers that are missing, each of which is asked below, or the error."""
    missing = sum(item.kind == "needed" for item in way.questions)
    if missing and not way.wrong:
        return f"{counted(missing, 'answer')} below must be given first"
    return way.stopped


def _asked(questions: Sequence[Question], file: Path) -> list[str]:
    """The questions by kind, with the lines of the campaign file."""
    lines = [] if not questions else ["", f"To say or to confirm in {quoted(file)}:"]
    for kind, head in _HEADS.items():
        own = [item for item in questions if item.kind == kind]
        if own:
            lines += [f"  {head}", *(f"    {item}" for item in own[:_MOST])]
        if len(own) > _MOST:
            lines.append(f"    and {len(own) - _MOST} more in the file.")
    return lines


STAGE: Final = ("begin", 1)
EXAMPLE: Final = "pmmkit demo --out my-demo"


@settings
class DemoSettings:
    """What is asked."""

    my_data: Path | None = setting(
        "Your own folder or file instead: as far as it goes towards a turn, and what is "
        "missing. Nothing is written there.",
        default=None,
    )
    ship: str | None = setting(
        "Ship of the library (pmmkit ships) that was tested, with --my-data.", default=None
    )
    out: Out = None


def demo(job: DemoSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.files import datasets_folder

    if job.my_data is not None:
        return as_far_as_it_goes(job.my_data, ship=job.ship, out=job.out)
    if job.ship is not None:
        raise SettingError("--ship goes with --my-data FOLDER.")
    ship = "s175-3dof"
    return reduced(
        ReduceSettings(campaign=datasets_folder() / "s175", parts=ship, reference=ship),
        results_folder(job.out, "pmmkit-demo"),
        reference_name="Son and Nomoto 1981",
        lacking="cubic",
    )
