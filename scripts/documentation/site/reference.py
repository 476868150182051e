"""Reference pages: public words, options of commands, sources, words of laboratories."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from itertools import groupby

import typer

import pmmkit
from pmmkit.cli.app import Command, application
from pmmkit.conventions import bibliography
from pmmkit.conventions.sources import Known, Reference
from pmmkit.presentation.vocabulary import vocabulary
from scripts.documentation.fences import table
from scripts.documentation.rooms import layers, words
from scripts.documentation.site.sections import toctree

KNOWN: dict[Known, str] = {
    "read": "Read",
    "quoted": "As programs and pages quote them",
    "unseen": "For where an idea comes from; not at hand",
}
SUBJECTS = {
    "channel": "Channels",
    "setting": "Settings of a test",
    "test": "Kinds of test",
    "statistic": "Statistics of repeats",
    "doubt": "Doubts in a header",
}


def python_pages() -> dict[str, str]:
    """A page for each public word, and one that lists them by room."""
    rooms = [room for row in layers() for room in row]
    public = {name: thing for name in pmmkit.__all__ if callable(thing := getattr(pmmkit, name))}

    def place(name: str) -> int:
        return rooms.index(public[name].__module__.split(".")[1])

    lines = ["Python: the public words", "=" * 24, ""]
    lines += ["After ``import pmmkit as pk`` they are reached as ``pk.reduce`` and so on.", ""]
    pages = {}
    for number, names in groupby(sorted(public, key=lambda name: (place(name), name)), key=place):
        title, listed = f"pmmkit.{rooms[number]}", list(names)
        lines += [title, "-" * len(title), "", words(rooms[number]).replace("`", "``"), ""]
        lines += [".. autosummary::", "   :nosignatures:", ""]
        lines += [f"   pmmkit.{name}" for name in listed]
        lines += ["", ".. toctree::", "   :hidden:", ""]
        lines += [f"   {name} <python/{name}>" for name in listed]
        lines += [""]
        pages |= {f"python/{name}.rst": word_page(name, public[name]) for name in listed}
    return {"python.rst": "\n".join(lines), **pages}


def word_page(name: str, thing: object) -> str:
    """The page of a public word."""
    title = f"pmmkit.{name}"
    kind = "class" if inspect.isclass(thing) else "function"
    members = "   :members:\n" if kind == "class" else ""
    return f"{title}\n{'=' * len(title)}\n\n.. auto{kind}:: {title}\n{members}"


def command_pages() -> dict[str, str]:
    """A page for each command with its arguments and options, and one that lists them."""
    commands = typer.main.get_command(application()).commands  # type: ignore[attr-defined]
    pages = {f"commands/{name}.md": command_page(name, item) for name, item in commands.items()}
    rows = [(f"[`{name}`](commands/{name}.md)", first(item)) for name, item in commands.items()]
    listed = table(("`pmmkit` …", ""), rows)
    head = "# Commands: every option\n\n[What they share](docs/commands.md).\n\n"
    return {"options.md": f"{head}{listed}\n\n{toctree(pages)}", **pages}


def first(command: Command) -> str:
    """The first line of what a command says of itself."""
    return (command.help or "").partition("\n")[0]


def command_page(name: str, command: Command) -> str:
    """What a command says of itself, its arguments and options."""
    context = command.make_context(f"pmmkit {name}", [], resilient_parsing=True)
    usage = command.get_usage(context).partition(": ")[2]
    example = (command.epilog or "").partition(": ")[2]
    parts = [f"# pmmkit {name}", plain(command.help or ""), f"    {usage}"]
    parts += [f"For example\n\n    {example}"]
    for title, records in command.sections(context).items():
        rows = [(f"`{left}`", plain(right)) for left, right in records]
        parts += [f"## {title}", table(("", ""), rows)]
    return "\n\n".join(parts) + "\n"


def plain(text: str) -> str:
    """Text of the console with its marks of Markdown escaped."""
    return re.sub(r"([\\*_`<>\[\]])", r"\\\1", text)


def sources_page() -> str:
    """The bibliography by how far each source was seen, with its key."""
    parts = [
        "# Bibliography",
        "What pmmkit quotes, with the key of each source. `pk.citation(model)` gives the entries "
        "in BibTeX of what a model or a table uses.",
    ]
    for known, title in KNOWN.items():
        entries = [item for item in bibliography().values() if item.known == known]
        parts += [f"## {title}", "\n".join(f"- {source(item)}" for item in entries)]
    return "\n\n".join(parts) + "\n"


def source(entry: Reference) -> str:
    """One source on one line."""
    return ". ".join(_parts(entry)) + f". `{entry.key}`"


def _parts(entry: Reference) -> Iterator[str]:
    names = ", ".join("et al." if x == "others" else x.strip("{}") for x in entry.author)
    if names:
        yield names.rstrip(".")
    if entry.title:
        yield plain(entry.title) + (f" ({entry.year})" if entry.year else "")
    where = entry.journal or entry.booktitle
    volume = f"{entry.volume}({entry.number})" if entry.volume and entry.number else entry.volume
    number = "" if entry.volume else entry.number
    pages = f"pp. {entry.pages.replace('--', '–')}" if entry.pages else ""
    told = (where, volume, number, entry.institution, entry.school, entry.publisher, pages)
    if any(told):
        yield plain(", ".join(filter(None, told)))
    if entry.note:
        yield plain(entry.note)
    if entry.doi:
        yield f"[doi:{plain(entry.doi)}](https://doi.org/{entry.doi})"
    if entry.url:
        yield f"<{entry.url}>"


def words_page() -> str:
    """Words of laboratories in other languages, by our names."""
    parts = [
        "# Words of laboratories",
        "Headers and names of files are told in these languages too (German, Japanese, Chinese, "
        "Korean, French, Spanish, Portuguese), with or without accents, and `pmmkit inspect` shows "
        "what was told by what. They stand in `pmmkit/presentation/vocabulary.toml`.",
    ]
    for subject, named in vocabulary().items():
        rows = [(f"`{name}`", ", ".join(listed)) for name, listed in named.items()]
        parts += [f"## {SUBJECTS[subject]}", table(("ours", "theirs"), rows)]
    return "\n\n".join(parts) + "\n"
