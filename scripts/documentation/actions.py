"""The commands, and the options that several of them share, as their dataclasses declare them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from pmmkit.actions import Action, JobSetting, about, action, by_stage, names
from scripts.documentation.fences import table

FEW = 3
"""So many commands that have an option make it one that is shared."""


def command_table() -> str:
    """All commands with what they do, by the stage of the work."""
    rows = (
        (stage if name == listed[0] else "", f"`pmmkit {name}`", _sentence(name))
        for stage, listed in by_stage().items()
        for name in listed
    )
    return table(("", "command", ""), rows)


def _sentence(name: str) -> str:
    return " ".join(about(name).split("\n\n")[0].split())


def shared_table(actions: Iterable[Action] = ()) -> str:
    """Options that mean the same to several commands.

    Parameters
    ----------
    actions : iterable of Action
        All commands by default.
    """
    found: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for own in actions or map(action, names()):
        for item in own.fields:
            if item.options:
                found[option_words(item), item.help.text].append(f"`{own.name}`")
    rows = [
        (option, text, ", ".join(listed))
        for (option, text), listed in sorted(found.items())
        if len(listed) >= FEW
    ]
    return table(("option", "", "commands"), rows)


def option_words(item: JobSetting) -> str:
    """An option with its limits, and what it is if absent."""
    told = f"`{item.option.split('/')[0]}`"
    choices = f" {' or '.join(map(str, item.choices))}" if item.choices else ""
    plain = item.default in (None, (), "", False, True) or item.required
    return told + choices + ("" if plain else f" ({item.default} if absent)")


TABLES = {"commands.md": {"commands": command_table, "options": shared_table}}
