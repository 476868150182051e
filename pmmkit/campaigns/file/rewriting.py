"""Changes of a campaign file that leave its comments, its order and all else as they were."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError
from pmmkit.files import toml_text

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

_HEAD: Final = re.compile(r"^\s*\[\[?\s*(?P<name>[^\[\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY: Final = re.compile(r"^(?P<key>[\w-]+|\"[^\"]*\")(?P<equals>\s*=\s*)(?P<rest>.*)$")


@dataclass(frozen=True)
class CampaignFile:
    """The text of a campaign file, of which single entries are changed; what its tables may hold.

    Parameters
    ----------
    text : str
        The campaign file.
    """

    text: str

    @staticmethod
    def keys_of(table: str) -> Mapping[str, FieldInfo]:
        """Keys that a table of a campaign file may have, with what each means.

        Parameters
        ----------
        table : str
            Such as ``report``, or ``report.gauges`` of one of the gauges there.

        Returns
        -------
        mapping of str to FieldInfo
            Empty where the keys are names, and where there is no such table.
        """
        from pmmkit.campaigns.file.schema import TABLES
        from pmmkit.campaigns.file.single_tables import GaugeEntry

        model = GaugeEntry if table == "report.gauges" else TABLES.get(table)
        return {} if model is None else model.model_fields

    @staticmethod
    def stated(table: str, raw: Any, file: str) -> dict[str, Any]:
        """What a table states, checked.

        Parameters
        ----------
        table : str
            One whose keys are fixed, such as ``imo``.
        raw : object
            What the TOML file holds.
        file : str
            Its name, for messages.

        Raises
        ------
        DataError
            With everything that is wrong in it.
        """
        from pmmkit.campaigns.file.schema import TABLES, read_entry
        from pmmkit.campaigns.file.single_tables import Faults, StrictTable

        faults = Faults(file)
        found = read_entry(TABLES[table] or StrictTable, raw, f"[{table}]", faults)
        if faults.problems or found is None:
            raise DataError(faults.problems, title=f"{file} cannot be read")
        return {name: value for name, value in found if value is not None}

    def with_columns(self, columns: Mapping[str, Any]) -> str:
        """The file with other entries of ``[columns]``.

        Parameters
        ----------
        columns : mapping of str to object
            Our name, and what stands right of it: a text, a table, or None where the entry goes.

        Raises
        ------
        DataError
            If the file is no TOML, or is written so that a line cannot be changed by itself.

        Examples
        --------
        >>> file = '[columns]  # of gauge 2\\nX = "Fx"  # checked\\n[end]\\n'
        >>> asked = {"X": {"name": "Fx", "scale": -1.0}, "Y": "Fy"}
        >>> print(CampaignFile(file).with_columns(asked), end="")
        [columns]  # of gauge 2
        X = { name = "Fx", scale = -1.0 } # checked
        Y = "Fy"
        [end]
        """
        raw = _read(self.text)
        held = {**raw.get("columns", {}), **columns}
        wanted = {**raw, "columns": {name: item for name, item in held.items() if item is not None}}
        lines = self.text.split("\n")
        found = _sections(lines, "columns")
        if not found:
            place = min(
                (i for i, line in enumerate(lines) if _is_list(line) or _named(line) == "end"),
                default=len(lines),
            )
            lines[place:place] = ["[columns]", ""]
            found = [(place, place + 1)]
        return _checked(_changed(lines, *found[0], columns), wanted)

    def with_correction(self, entry: Mapping[str, Any]) -> str:
        """The file with a correction, in the place of one of the same runs and action.

        Parameters
        ----------
        entry : mapping
            Keys of ``[[corrections]]``.

        Raises
        ------
        DataError
            As `with_columns`.

        Examples
        --------
        >>> asked = {"runs": ["a"], "action": "window", "t_start": 2.0, "reason": "calm"}
        >>> file = CampaignFile('[campaign]\\ntitle = "x"  # mine\\n')
        >>> first = CampaignFile(file.with_correction(asked))
        >>> print(first.with_correction({**asked, "t_start": 3.5}), end="")
        [campaign]
        title = "x"  # mine
        <BLANKLINE>
        [[corrections]]
        runs = ["a"]
        action = "window"
        t_start = 3.5
        reason = "calm"
        """
        raw = _read(self.text)
        listed = list(raw.get("corrections", []))
        lines = self.text.split("\n")
        place = _same(listed, entry)
        if place is None:
            end = next((i for i, line in enumerate(lines) if _named(line) == "end"), len(lines))
            before = ["", *toml_text({"corrections": [dict(entry)]}).splitlines()]
            while end and not lines[end - 1].strip():
                end -= 1
            lines[end:end] = before
            return _checked(lines, {**raw, "corrections": [*listed, dict(entry)]})
        changed = {key: value for key, value in entry.items() if listed[place].get(key) != value}
        listed[place] = dict(entry)
        section = _sections(lines, "corrections")[place]
        return _checked(_changed(lines, *section, changed), {**raw, "corrections": listed})

    def without_correction(self, entry: Mapping[str, Any]) -> str:
        """The file without the correction of these runs and this action.

        Parameters
        ----------
        entry : mapping
            With ``runs`` and ``action``.

        Raises
        ------
        DataError
            If there is none, or as `with_columns`.
        """
        raw = _read(self.text)
        listed = list(raw.get("corrections", []))
        place = _same(listed, entry)
        if place is None:
            raise DataError("The campaign file has no such correction.")
        lines = self.text.split("\n")
        start, stop = _sections(lines, "corrections")[place]
        before = start and not lines[start - 1].strip()
        del lines[start - bool(before) : stop]
        left = [item for number, item in enumerate(listed) if number != place]
        rest = {name: item for name, item in raw.items() if name != "corrections"}
        return _checked(lines, {**rest, "corrections": left} if left else rest)


def _same(listed: Sequence[Mapping[str, Any]], entry: Mapping[str, Any]) -> int | None:
    """Place of the last correction of the same runs and action."""
    key = ("runs", "action")
    alike = [i for i, item in enumerate(listed) if all(item.get(k) == entry[k] for k in key)]
    return alike[-1] if alike else None


def _read(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"The campaign file is damaged: {error}. Correct it by hand.") from error


def _named(line: str) -> str:
    """Name of the table that begins with a line; empty where none does."""
    head = _HEAD.match(line)
    return head["name"] if head is not None else ""


def _is_list(line: str) -> bool:
    return bool(_named(line)) and line.lstrip().startswith("[[")


def _sections(lines: Sequence[str], name: str) -> list[tuple[int, int]]:
    """Head and end of the tables of a name, without the comments that belong to the next."""
    heads = [i for i, line in enumerate(lines) if _named(line)]
    found = []
    for start, stop in zip(heads, [*heads[1:], len(lines)], strict=True):
        if _named(lines[start]) != name:
            continue
        end = stop
        while end > start + 1 and (not lines[end - 1].strip() or _is_note(lines[end - 1])):
            end -= 1
        found.append((start, end))
    return found


def _is_note(line: str) -> bool:
    return line.lstrip().startswith("#")


def _changed(lines: list[str], start: int, stop: int, values: Mapping[str, Any]) -> list[str]:
    """Lines with other values of the keys of one table; new keys at its end."""
    out, left = list(lines), dict(values)
    for number in range(start + 1, stop):
        found = _KEY.match(lines[number])
        key = found["key"].strip('"') if found is not None else ""
        if found is None or key not in left:
            continue
        value = left.pop(key)
        note = _note(found["rest"])
        if value is None:
            out[number] = f"# {lines[number]}"
        else:
            out[number] = f"{key} = {_inline(value)} {note}".rstrip()
    more = [f"{key} = {_inline(value)}" for key, value in left.items() if value is not None]
    out[stop:stop] = more
    return out


def _note(rest: str) -> str:
    """The comment behind a value; a # within quotes begins none."""
    for place, char in enumerate(rest):
        if char == "#":
            try:
                tomllib.loads(f"x = {rest[:place]}")
            except tomllib.TOMLDecodeError:
                continue
            return rest[place:]
    return ""


def _inline(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_inline(item)}" for key, item in value.items()) + " }"
    return toml_text({"x": value}).removeprefix("x = ").rstrip("\n")


def _checked(lines: Sequence[str], wanted: Mapping[str, Any]) -> str:
    """The text, where it says what it should and nothing else."""
    end = "\r\n" if any(line.endswith("\r") for line in lines) else "\n"
    text = end.join(line.removesuffix("\r") for line in lines)
    if _read(text) != wanted:
        raise DataError(
            "The campaign file is written so that this cannot be changed without touching more of "
            "it. Change it by hand."
        )
    return text
