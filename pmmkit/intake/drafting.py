"""A campaign file for a folder: guessed, corrected by choosing, completed by answers."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, get_args

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns import TEST_KINDS, CampaignFile, campaign_of
from pmmkit.files import CAMPAIGN, toml_string
from pmmkit.intake.drafts.columns import ColumnChoice, signed, their_column, with_choices
from pmmkit.intake.drafts.propose import campaign_draft
from pmmkit.intake.drafts.questions import questions_of, with_answer, with_density
from pmmkit.intake.drafts.write import written
from pmmkit.intake.folder import MOST_COUNTED, Look, look
from pmmkit.intake.guessing import Suggestion
from pmmkit.intake.seen import ColumnLook

_ENTRY: Final = re.compile(r"\[\[(?P<table>runs|tables)\]\] #(?P<number>\d+)")
_KEY: Final = re.compile(r"key '(?P<key>[^']+)'")
TITLE: Final = "campaign.title"
"""Name under which a title is answered; a draft has that of its folder."""
_TITLE: Final = re.compile(r"^title = .*$", re.MULTILINE)
_ID: Final = re.compile(r'^id = "(?P<id>(?:[^"\\]|\\.)*)"')


@dataclass(frozen=True, kw_only=True)
class DraftAnswers:
    """What a person said of a folder.

    Parameters
    ----------
    folder : Path
        Where the files lie; its campaign file is, or will be, there too.
    choices : tuple of ColumnChoice
        Of columns.
    ship : str
        A ship of the library, or nothing.
    answers : mapping of str to str
        By the name of a `Field`, as typed.
    """

    folder: Path
    choices: tuple[ColumnChoice, ...] = ()
    ship: str = ""
    answers: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def target(self) -> Path:
        """The campaign file."""
        return self.folder / CAMPAIGN.file

    @property
    def stamp(self) -> tuple[Any, ...]:
        """What a `Basis` depends on: the choices, the folder with sizes and times of its files."""
        files = []
        for place, _, names in os.walk(self.folder):
            for name in names:
                with suppress(OSError):
                    found = os.stat(os.path.join(place, name))
                    files.append((place, name, found.st_size, found.st_mtime_ns))
            if len(files) > MOST_COUNTED:
                break
        return str(self.folder), self.choices, self.ship, hash(tuple(sorted(files)))

    def basis(self) -> Basis:
        """Look at the files of the folder; of thousands this takes a minute. Answers do not count.

        Raises
        ------
        DataError
            As `drafted`.
        """
        return _changed(self) if self.target.is_file() else _drafted(self)

    def drafted(self, basis: Basis | None = None) -> Drafted:
        """The campaign file of the folder with what a person said; the basis may be known.

        Raises
        ------
        DataError
            If there are no measurements, the file that is there is damaged, or a choice is of
            nothing.
        """
        new = not self.target.is_file()
        basis = basis or self.basis()
        asks = tuple(_fields(basis.text))
        said = dict(self.answers)
        text = _titled(basis.text, said.get(TITLE, "")) if new else basis.text
        for item in asks:
            if said.get(item.name, "").strip():
                text = with_answer(text, [item.line], said[item.name])
        text = with_density(text)
        left = {item.name: item.state for item in _fields(text)}
        asks = tuple(
            replace(
                item,
                answer=said.get(item.name, ""),
                state="answered"
                if said.get(item.name, "").strip()
                else left.get(item.name, item.state),
            )
            for item in asks
        )
        asks, rest = _judged(text, self.target, asks)
        waiting = any(item.state == "needed" for item in asks)
        return Drafted(
            seen=basis.seen,
            text=text,
            fields=asks,
            problems=() if waiting else rest,
            new=new,
            changed=text != basis.before,
            apart=basis.apart,
        )


@dataclass(frozen=True, kw_only=True)
class Field:
    """One thing that is asked.

    `name`: table and key, with the run where it is of one: ``ship.L``, ``runs[a].speed``. `key,
    run, text`: table and key; the run or nothing; what is asked. `state`: as of a `Question`,
    or that it has an answer. `guess, why`: what is taken meanwhile and where it comes from.
    `options`: between which one chooses; empty where it is typed. `answer, error`: what was
    typed, and what is wrong with it. `line`: of the campaign file, the first is 1.
    """

    name: str
    key: str
    run: str
    text: str
    state: str
    guess: str
    why: str
    options: tuple[str, ...]
    line: int
    answer: str = ""
    error: str = ""

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "name": self.name,
            "key": self.key,
            "run": self.run,
            "text": self.text,
            "state": self.state,
            "guess": self.guess.strip('"') if self.options else self.guess,
            "why": self.why,
            "options": list(self.options),
            "answer": self.answer,
            "error": self.error,
        }


@dataclass(frozen=True, kw_only=True)
class Drafted:
    """A campaign file that is proposed, or that is there with changes proposed.

    Parameters
    ----------
    seen : Look
        The files, their columns as guessed, chosen or stated.
    text : str
        The file.
    fields : tuple of Field
        What is asked, the needed first.
    problems : tuple of Problem
        What else keeps it from being opened; empty while something is needed.
    new : bool
        Whether there is no campaign file yet.
    changed : bool
        Whether the text is another one than the file's.
    apart : frozenset of str
        First files of layouts whose runs name their columns themselves.
    """

    seen: Look
    text: str
    fields: tuple[Field, ...]
    problems: tuple[Problem, ...]
    new: bool
    changed: bool
    apart: frozenset[str] = frozenset()

    @property
    def complete(self) -> bool:
        """Whether it can be opened."""
        return not self.problems and not any(x.state == "needed" or x.error for x in self.fields)


@dataclass(frozen=True, kw_only=True)
class Basis:
    """What the files say with the columns as they were chosen, before anything is answered.

    `text, before`: the campaign file, and the one that is there.
    """

    seen: Look
    text: str
    before: str = ""
    apart: frozenset[str] = frozenset()


def _drafted(asked: DraftAnswers) -> Basis:
    """What `pmmkit new-campaign` writes, with the choices."""
    draft = campaign_draft(
        asked.folder, asked.target, ship=asked.ship or None, choices=asked.choices
    )
    looks = {id(x.look): signed(x.look, asked.choices) for x in (*draft.runs, *draft.tables)}
    draft = replace(
        draft,
        runs=tuple(replace(x, look=looks[id(x.look)]) for x in draft.runs),
        tables=tuple(replace(x, look=looks[id(x.look)]) for x in draft.tables),
    )
    shown = {found.shown: found for found in looks.values()}
    groups = tuple(
        replace(group, files=(shown.get(group.first.shown, group.first), *group.files[1:]))
        for group in draft.look.groups
    )
    return Basis(seen=replace(draft.look, groups=groups), text=written(draft).text)


def _changed(asked: DraftAnswers) -> Basis:
    """The file that is there, with other columns where some were chosen."""
    try:
        text = asked.target.read_text("utf-8")
        stated = tomllib.loads(text)
    except (OSError, ValueError) as error:
        raise DataError(
            f"{asked.target} cannot be read ({error}). Correct it by hand, or move it away to "
            "begin anew."
        ) from error
    seen, apart = as_stated(look(asked.folder), stated)
    if not asked.choices:
        return Basis(seen=seen, text=text, before=text, apart=apart)
    if any(choice.file in apart for choice in asked.choices):
        raise DataError("Runs of these files name their columns themselves: change them there.")
    held = {
        (group.first.shown, column.position): column.suggestion
        for group in seen.groups
        for column in group.first.columns
    }
    chosen = with_choices(seen, asked.choices)
    columns: dict[str, Any] = {}
    for choice in asked.choices:
        before = held.get((choice.file, choice.column))
        if before is not None and before.name != choice.name:
            columns.setdefault(before.name, False)
        group = next(x for x in chosen.groups if x.first.shown == choice.file)
        column = group.first.columns[choice.column]
        if column.suggestion is not None:
            theirs = their_column(column, column.suggestion, group.first)
            columns[choice.name] = tomllib.loads(f"x = {theirs}")["x"]
    return Basis(
        seen=chosen, text=CampaignFile(text).with_columns(columns), before=text, apart=apart
    )


def as_stated(seen: Look, raw: Mapping[str, Any]) -> tuple[Look, frozenset[str]]:
    """Files with their columns as a campaign file names them."""
    entries = [x for name in ("runs", "tables") for x in raw.get(name, []) if isinstance(x, dict)]
    own = {x.get("file"): x["columns"] for x in entries if isinstance(x.get("columns"), dict)}
    top = raw.get("columns", {})
    groups, apart = [], set()
    for group in seen.groups:
        named = next((own[x.shown] for x in group.files if x.shown in own), None)
        if named is not None:
            apart.add(group.first.shown)
        columns = {**(top if isinstance(top, dict) else {}), **(named or {})}
        first = replace(
            group.first, columns=tuple(_as_named(column, columns) for column in group.first.columns)
        )
        groups.append(replace(group, files=(first, *group.files[1:])))
    return replace(seen, groups=tuple(groups)), frozenset(apart)


def _as_named(column: ColumnLook, columns: Mapping[str, Any]) -> ColumnLook:
    """A column as the file names it; a guess stays where its name is not taken."""
    stated = _stated(column.title, column.position, columns)
    guess = column.suggestion
    kept = None if guess is not None and guess.name in columns else guess
    return replace(column, suggestion=stated or kept)


def _stated(title: str, position: int, columns: Mapping[str, Any]) -> Suggestion | None:
    for name, entry in columns.items():
        theirs = {"name": entry} if isinstance(entry, str) else entry
        if not isinstance(theirs, dict):
            continue
        if theirs.get("name") == title or theirs.get("column") == position + 1:
            scale = theirs.get("scale", 1.0)
            return Suggestion(
                name=name,
                certainty="surely",
                reason="stated",
                unit=theirs.get("unit"),
                scale=float(scale) if isinstance(scale, int | float) else 1.0,
            )
    return None


def _titled(text: str, title: str) -> str:
    """A drafted file with a title of its own, where one was typed."""
    line = f"title = {toml_string(title.strip())}"
    return _TITLE.sub(lambda _: line, text, count=1) if title.strip() else text


def _fields(text: str) -> Iterator[Field]:
    """The questions of a file, those of many runs one by one."""
    lines = text.split("\n")
    for question in questions_of(text):
        table, _, key = question.key.rpartition(".")
        for line in question.lines:
            run = _run_at(lines, line) if table in ("runs", "tables") else ""
            yield Field(
                name=f"{table}[{run}].{key}" if run else question.key,
                key=question.key,
                run=run,
                text=question.text,
                state=question.kind,
                guess=question.guess,
                why=question.why,
                options=_options(table, key, text),
                line=line,
            )


def _run_at(lines: Sequence[str], number: int) -> str:
    """Id of the entry in which a line stands."""
    for line in reversed(lines[:number]):
        found = _ID.match(line)
        if found is not None:
            return str(tomllib.loads(f'x = "{found["id"]}"')["x"])
        if line.startswith("[["):
            break
    return ""


def _options(table: str, key: str, text: str) -> tuple[str, ...]:
    """What a key may be, where that is one of some words."""
    if key == "test" and table in ("runs", "tables"):
        free = 'kind = "free-running"' in text
        return tuple(name for name, kind in TEST_KINDS.items() if kind.free_running == free)
    known = CampaignFile.keys_of(table).get(key)
    options = () if known is None else get_args(known.annotation)
    return tuple(options) if options and all(isinstance(x, str) for x in options) else ()


def _judged(
    text: str, target: Path, asks: Sequence[Field]
) -> tuple[tuple[Field, ...], tuple[Problem, ...]]:
    """Fields with what is wrong with their answers, and the problems that are of none."""
    try:
        campaign_of(tomllib.loads(text), target)
    except CampaignError as error:
        problems = error.problems
    except DataError as error:
        problems = (Problem(message=str(error)),)
    except ValueError as error:
        problems = (Problem(message=f"the file is no TOML: {error}"),)
    else:
        return tuple(asks), ()
    ids = {
        table: [entry.get("id", "") for entry in tomllib.loads(text).get(table, [])]
        for table in ("runs", "tables")
    }
    errors: dict[str, str] = {}
    rest = []
    for problem in problems:
        name = _field_of(problem, ids)
        if any(item.name == name and item.answer.strip() for item in asks):
            errors[name] = problem.message
        else:
            rest.append(problem)
    return tuple(replace(item, error=errors.get(item.name, "")) for item in asks), tuple(rest)


def _field_of(problem: Problem, ids: Mapping[str, Sequence[str]]) -> str:
    entry = problem.entry or ""
    key = _KEY.search(entry)
    listed = _ENTRY.search(entry)
    if key is None:
        return ""
    if listed is not None:
        named = ids[listed["table"]]
        number = int(listed["number"]) - 1
        run = named[number] if number < len(named) else ""
        return f"{listed['table']}[{run}].{key['key']}"
    return f"{entry.partition(',')[0].strip('[]')}.{key['key']}"
