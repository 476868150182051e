"""A user's own effect from text, read by a small grammar."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NoReturn

from pmmkit.base import DataError, Problem, UnknownNameError
from pmmkit.conventions import CHANNELS, parse_derivative
from pmmkit.effects.added_mass import AddedMass
from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.entries import CATALOGUE
from pmmkit.effects.expressions import (
    MOST,
    NotUnderstood,
    WrittenFunction,
    has_meaning,
    is_expression,
    is_power,
    written,
)
from pmmkit.files import read_toml, toml_text
from pmmkit.numerics import ABSURD
from pmmkit.presentation import printable
from pmmkit.syntax import Function

FACTORS: Final = {"v": "v", "r": "r", "u": "u", "p": "p", "phi": "phi", "d": "d", "delta": "d"}
SCALES: Final = {"X": 6e-4, "Y": 3.2e-3, "N": 1.3e-3, "K": 1e-4}
MOTIONS: Final = {"v": 0.2, "r": 0.4, "u": 1.0, "p": 0.1, "phi": 0.1, "d": 0.35, "0": 1.0}
"""Usual forces and motions in the prime system; a tenth of such a force is a usual size."""
_TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<modulus>\|\s*[A-Za-z]+\s*\|)|(?P<mark>\*\*|[*^+:-])|(?P<stray>\S))"
)
_NAME: Final = re.compile(r"[a-z][a-z0-9_]{0,59}")
LONGEST: Final = 4000
"""Characters of a text."""
FACTORS_IN_TERM: Final = 20
"""Largest order of a product, all its powers together."""
_WINDOW: Final = 60
"""Characters of a line that are shown beside the place of a fault."""
_KEYS: Final = ("name", "family", "summary", "terms", "typical", "check")


def own_effect(
    name: str,
    text: str,
    *,
    family: str = "own",
    summary: str = "",
    check: str = "",
    typical: Mapping[str, float] | None = None,
) -> Effect:
    """An effect from text such as ``Y: v*|v|*r; N: v*v*r``.

    Parameters
    ----------
    name : str
        Small letters, digits and ``_``; not a name of the catalogue. ``my bilge`` is made
        ``my_bilge``, with a warning.
    text : str
        Statements parted by ``;`` or line breaks. ``Y: v*|v|*r + v^3`` gives products of v, r, u,
        p, phi, d (delta) and their moduli in a channel; each has its derivative as coefficient.
        ``Y: a*v*|v|; N: -0.4*a*v*|v|; a ~ -0.01`` has one coefficient for both, with its usual
        size; a number is a share of a named coefficient. These are derivatives of the hull.
        What is no product is an expression of the words and functions of `effects.expressions`,
        beside the motion ``beta``, ``Fn``, ``sinkage`` over the draught and ``trim``:
        ``Y: a*Fn^2*sat(v, edge); a ~ -0.01; edge ~ [0.05, 0.1]`` has a nonlinear parameter with
        the values at which a diagnosis tries it, and becomes a part of a model. Forces are over
        ½ρL²U², moments over ½ρL³U². ``Yvdot: a*v^2; a ~ -0.02`` is added mass that changes with
        the motion, over ½ρL³ (½ρL⁴, ½ρL⁵).
    family, summary, check : str
        Family by which an answer is given first; one sentence; a run that would show it.
    typical : mapping of str to float, optional
        Usual sizes, as ``~`` in the text gives them, prime system with the speed of the instant;
        by default a tenth of a usual force.

    Returns
    -------
    Effect

    Raises
    ------
    DataError
        If the text cannot be read; the message shows the place.

    Examples
    --------
    >>> own_effect("fins", "Y: v*|v|*r; N: v*v*r; Nvvr ~ -0.04").typical
    mappingproxy({'Yv|v|r': 0.01..., 'Nvvr': -0.04})
    """
    name = _valid(name)
    if not _NAME.fullmatch(name) or name in CATALOGUE:
        known = "it is one of the catalogue" if name in CATALOGUE else "use a to z, 0 to 9, _"
        raise DataError(f"{name!r:.40} cannot be the name of an own effect: {known}.")
    if not isinstance(text, str):
        raise DataError(f"The terms of {name} must be a text such as 'Y: v*|v|*r'.")
    if len(text) > LONGEST:
        _stop(name, text, LONGEST, f"a text has at most {LONGEST} characters, not {len(text)}")
    given = {_label(key): _Size(float(size)) for key, size in (typical or {}).items()}
    channels, said = _parted(name, text)
    given |= said
    for label, size in given.items():
        for value in (size.typical, *size.grid):
            if not math.isfinite(value) or value == 0.0:
                _stop(name, text, size.place, f"the usual size of {label} must not be {value:g}")
    make = _expressed if is_expression(text) or any(x.grid for x in given.values()) else _products
    about = {
        "name": name,
        "family": family,
        "summary": summary,
        "check": check,
        "text": _whole(text, typical),
    }
    return make(text, channels, given, about)


def _whole(text: str, typical: Mapping[str, float] | None) -> str:
    """A text with the sizes that were given beside it."""
    return "; ".join([text.strip(), *(f"{key} ~ {x!r}" for key, x in (typical or {}).items())])


def _parted(name: str, text: str) -> tuple[list[tuple[str, int]], dict[str, _Size]]:
    """The statements of channels with their places, and the sizes that are given."""
    channels, given = [], {}
    for statement, start in _statements(text):
        if "~" in statement:
            label, size = _size(name, text, statement, start)
            given[label] = size
        else:
            channels.append((statement, start))
    return channels, given


@dataclass(frozen=True)
class _Size:
    """Usual size of a coefficient or values of a parameter, and where they stand in the text."""

    typical: float
    grid: tuple[float, ...] = ()
    place: int = 0


def _products(
    text: str,
    channels: Sequence[tuple[str, int]],
    given: Mapping[str, _Size],
    about: Mapping[str, Any],
) -> Effect:
    """An effect of derivatives of the hull."""
    name = about["name"]
    shares: dict[str, dict[str, float]] = {}
    for statement, start in channels:
        for label, derivative, share, place in _terms(name, text, statement, start, set(given)):
            own = shares.setdefault(label, {})
            if derivative in own:
                _stop(name, text, place, f"{derivative} stands there twice")
            own[derivative] = share
    if not shares:
        raise DataError(f"Own effect {name}: {text!r:.60} holds no term such as 'Y: v*|v|*r'.")
    for label, size in given.items():
        if label not in shares:
            _stop(name, text or label, size.place, f"{label} stands in no term")
    factors = {
        factor.strip("|")
        for own in shares.values()
        for derivative in own
        for factor in parse_derivative(derivative).factors
    }
    return Effect(
        **about,
        kind="terms",
        shares=MappingProxyType({k: MappingProxyType(v) for k, v in shares.items()}),
        parameters=tuple(
            Parameter(
                name=label,
                text=f"of {', '.join(own)}",
                typical=given[label].typical if label in given else _usual(label),
            )
            for label, own in shares.items()
        ),
        excites=_excited(factors),
    )


def _excited(words: Set[str]) -> tuple[str, ...]:
    """What tests must hold to show forces of these words."""
    needs = {
        "roll": {"p", "phi"},
        "rudder": {"d", "delta"},
        "several speeds": {"Fn"},
        "sinkage": {"sinkage", "trim"},
    }
    return tuple(word for word, asked in needs.items() if asked & words)


def _expressed(
    text: str,
    channels: Sequence[tuple[str, int]],
    given: Mapping[str, _Size],
    about: Mapping[str, Any],
) -> Effect:
    """An effect with a force of its own."""
    found = _written(about["name"], text, channels, given)
    masses = set(found.outputs) <= set(AddedMass.places())
    unit = "over ½ρL³ (½ρL⁴, ½ρL⁵)" if masses else "over ½ρL²U² (½ρL³U²)"
    return Effect(
        **about,
        kind="state" if found.states else "mass" if masses else "force",
        force=found.function(about["name"]),
        outputs=found.outputs,
        states=found.states,
        parameters=tuple(
            Parameter(name=label, text="nonlinear parameter", grid=size.grid)
            if size.grid
            else Parameter(name=label, text=unit, typical=size.typical)
            for label, size in given.items()
        ),
        excites=_excited(found.words),
    )


def _written(
    name: str, text: str, channels: Sequence[tuple[str, int]], given: Mapping[str, _Size]
) -> WrittenFunction:
    """The function that expressions make."""
    for label, size in given.items():
        if has_meaning(label, name):
            _stop(name, text, size.place, f"{label} has a meaning already: choose another name")
    statements = []
    for statement, start in channels:
        channel, colon, expression = statement.partition(":")
        if channel.strip() not in (*CHANNELS, *AddedMass.places()) or not colon:
            _stop(name, text, start, "a statement begins with X:, Y:, N:, K: or Yvdot: …")
        statements.append((channel.strip(), expression, start + len(channel) + 1))
    coefficients = [label for label, size in given.items() if not size.grid]
    tried = [label for label, size in given.items() if size.grid]
    if len(tried) > 1:
        _stop(name, text, given[tried[1]].place, "one parameter can have several values, not two")
    try:
        return written(name, statements, coefficients, tried)
    except NotUnderstood as error:
        _stop(name, text, error.place, str(error))


def function_of_text(name: str, text: str) -> Function:
    """The function ``force`` of an effect that a text makes, as it was understood.

    Parameters
    ----------
    name : str
        Of the effect.
    text : str
        The words of a user.

    Raises
    ------
    DataError
        If the text cannot be read.
    """
    channels, given = _parted(name, text)
    return _written(name, text, channels, given).tree


@cache
def written_effect(name: str, text: str) -> Effect:
    """The effect that a model file holds as text.

    Raises
    ------
    DataError
        If the text cannot be read.
    """
    return own_effect(name, text)


def own_effects(path: str | Path) -> tuple[Effect, ...]:
    """Own effects from a TOML file.

    Parameters
    ----------
    path : path
        With a table ``[[effects]]`` for each: ``name`` and ``terms``, and where wanted ``family``,
        ``summary``, ``check`` and ``typical``, a table of usual sizes.

    Returns
    -------
    tuple of Effect

    Raises
    ------
    DataError
        With everything that is wrong, and where.
    """
    entries = read_toml(Path(path)).get("effects")
    if not isinstance(entries, list) or not entries:
        raise DataError(
            Problem(file=str(path), message="there is no effect.", remedy="Write [[effects]].")
        )
    found: list[Effect] = []
    wrong: list[Problem] = []
    for number, entry in enumerate(entries, start=1):
        try:
            found.append(_entry(entry, [item.name for item in found]))
        except DataError as error:
            place = f"[[effects]] #{number}"
            wrong += [
                Problem(file=str(path), entry=place, message=item.message)
                for item in error.problems
            ]
    if wrong:
        raise DataError(wrong, title="Own effects not read")
    return tuple(found)


def own_effects_text(effects: Sequence[Effect]) -> str:
    """The file of own effects that `own_effects` reads.

    Parameters
    ----------
    effects : sequence of Effect
        Those without a text, written in Python, have no place in it.

    Returns
    -------
    str
        TOML.

    Examples
    --------
    >>> print(own_effects_text([own_effect("keel", "Y: v*|v|*r")]).strip())
    [[effects]]
    name = "keel"
    family = "own"
    terms = "Y: v*|v|*r"
    """
    tables = []
    for item in effects:
        held = {"name": item.name, "family": item.family, "summary": item.summary}
        held |= {"terms": item.text, "check": item.check}
        tables += [{key: text for key, text in held.items() if text}] * bool(item.text)
    return toml_text({"effects": tables})


def _valid(name: str) -> str:
    """A name in small letters, with ``_`` in place of blanks and hyphens; a change is said."""
    made = re.sub(r"[\s_-]+", "_", name.strip().lower())
    if made == name or not _NAME.fullmatch(made):
        return name
    warnings.warn(f"The effect {name!r} is called {made} here.", stacklevel=3)
    return made


def _entry(entry: Any, taken: list[str]) -> Effect:
    if not isinstance(entry, dict):
        raise DataError("an effect is a table of name, terms and more.")
    stray = [key for key in entry if key not in _KEYS]
    lost = [key for key in ("name", "terms") if key not in entry]
    wrong = [
        key
        for key in entry
        if key in _KEYS and key != "typical" and not isinstance(entry[key], str)
    ]
    sizes = entry.get("typical", {})
    sound = isinstance(sizes, dict) and all(
        isinstance(x, (int, float)) and not isinstance(x, bool) for x in sizes.values()
    )
    found = [f"there is no key {key!r}; an effect has {', '.join(_KEYS)}." for key in stray]
    found += [f"{key} is missing." for key in lost]
    found += [f"{key} must be a text." for key in wrong]
    found += [] if sound else ["typical must be a table of numbers."]
    if found:
        raise DataError(found)
    texts = {key: entry[key] for key in ("family", "summary", "check") if key in entry}
    made = own_effect(entry["name"], entry["terms"], typical=sizes, **texts)
    if made.name in taken:
        raise DataError(f"the name {made.name!r} stands there twice.")
    return made


def _statements(text: str) -> Iterator[tuple[str, int]]:
    for found in re.finditer(r"[^;\n]+", text):
        if found.group().strip():
            yield found.group(), found.start()


def _label(text: str) -> str:
    """A coefficient's name: derivatives in their canonical spelling."""
    try:
        return parse_derivative(text.strip()).name
    except UnknownNameError:
        return text.strip()


def _size(name: str, text: str, statement: str, start: int) -> tuple[str, _Size]:
    left, _, right = statement.partition("~")
    place = start + len(left) + 1
    values = right.strip()
    listed = values.startswith("[") and values.endswith("]")
    try:
        numbers = tuple(float(x) for x in values.strip("[]").split(","))
    except ValueError:
        _stop(name, text, place, "a usual size is a number, values of a parameter [1, 2, 3]")
    if len(numbers) > 1 and not listed:
        _stop(name, text, place, "a usual size is a number, values of a parameter [1, 2, 3]")
    middle = numbers[len(numbers) // 2]
    return _label(left), _Size(middle, numbers if listed else (), start)


def _terms(
    name: str, text: str, statement: str, start: int, named: set[str]
) -> Iterator[tuple[str, str, float, int]]:
    """Coefficient, derivative, share and place of each term of a channel."""
    tokens = [
        (str(kind), found.group(kind), start + found.start(kind))
        for found in _TOKEN.finditer(statement)
        if (kind := found.lastgroup) is not None
    ]
    end = start + len(statement.rstrip())
    for kind, word, place in tokens:
        if kind == "stray":
            _stop(name, text, place, f"{word!r} has no meaning here")
    if len(tokens) < 2 or tokens[0][1] not in CHANNELS or tokens[1][1] != ":":
        place = tokens[0][2] if tokens else start
        _stop(name, text, place, "a statement begins with X:, Y:, N: or K:")
    channel, at = tokens[0][1], 2
    while True:
        term: list[tuple[str, str, int]] = []
        sign = 1.0
        first = tokens[at][2] if at < len(tokens) else end
        while at < len(tokens) and not term and tokens[at][1] in "+-":
            sign = -sign if tokens[at][1] == "-" else sign
            at += 1
        while at < len(tokens) and tokens[at][1] not in ("+", "-"):
            term.append(tokens[at])
            at += 1
        yield _term(name, text, channel, term, sign, named, first, end)
        if at >= len(tokens):
            return


def _term(
    name: str,
    text: str,
    channel: str,
    term: list[tuple[str, str, int]],
    sign: float,
    named: set[str],
    first: int,
    end: int,
) -> tuple[str, str, float, int]:
    """One product: an optional share and coefficient, then factors with their powers."""
    share, label, factors, at, order = sign, "", "", 0, 0
    while at < len(term) or not factors:
        if at >= len(term):
            _stop(name, text, end if not term else term[-1][2], "a factor is missing")
        kind, word, place = term[at]
        inner = word.strip("| ")
        if kind == "number" and at == 0:
            share *= float(word)
            if not abs(share) <= ABSURD:
                _stop(name, text, place, f"{word:.40} is absurdly large")
            if len(term) == 1 and share == 1.0:
                factors = "0"
        elif kind == "word" and word in named and not label and not factors:
            label = word
        elif kind in ("word", "modulus") and inner in FACTORS:
            factor = FACTORS[inner] if kind == "word" else f"|{FACTORS[inner]}|"
            if factor == "|phi|":
                _stop(name, text, place, "there is no modulus of phi")
            at, power = _power(name, text, term, at)
            factors += factor * power
            order += power
            if order > FACTORS_IN_TERM:
                _stop(name, text, place, f"a product has at most {FACTORS_IN_TERM} factors")
        else:
            hint = f" and no coefficient with a usual size ('{word} ~ 0.01')"
            _stop(
                name,
                text,
                place,
                f"{word!r} is no factor ({', '.join(FACTORS)}){hint if kind == 'word' else ''}",
            )
        at += 1
        if at < len(term):
            if term[at][1] != "*" or at + 1 == len(term):
                _stop(name, text, term[at][2], "factors are joined by * and end with a factor")
            at += 1
    derivative = parse_derivative(channel + factors).name
    if not label and share != 1.0:
        _stop(
            name,
            text,
            first,
            "a number or a minus belongs to a coefficient with a name and a "
            "usual size, as in 'N: -0.4*a*v; a ~ 0.01'",
        )
    return label or derivative, derivative, share, first


def _power(name: str, text: str, term: list[tuple[str, str, int]], at: int) -> tuple[int, int]:
    """Place after a power, and the power."""
    if at + 1 >= len(term) or term[at + 1][1] not in ("^", "**"):
        return at, 1
    kind, word, place = term[at + 2] if at + 2 < len(term) else ("", "", term[at + 1][2])
    if kind != "number" or not is_power(word):
        _stop(name, text, place, f"a power is a whole number from 1 to {MOST}")
    return at + 2, int(word)


def _stop(name: str, text: str, place: int, message: str) -> NoReturn:
    start = text.rfind("\n", 0, place) + 1
    line, column = text[start:].split("\n", 1)[0], place - start
    first = max(0, column - _WINDOW)
    line, column = printable(line[first : column + _WINDOW]), column - first
    raise DataError(
        f"Own effect {name}: {message} (character {place + 1}).\n    {line}\n    {' ' * column}^"
    )


def _usual(derivative: str) -> float:
    facts = parse_derivative(derivative)
    return 0.1 * SCALES[facts.channel] / math.prod(MOTIONS[x.strip("|")] for x in facts.factors)
