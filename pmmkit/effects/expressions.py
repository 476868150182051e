"""Forces that a user writes down as expressions of the motion, turned into a function.

What is read here is data: only the words below are known, each number is checked, and the function
is written from what was understood, never from the text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NoReturn

from pmmkit.conventions import CHANNELS
from pmmkit.effects import primitives
from pmmkit.numerics import ABSURD

MOTION: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "v": ("(v / U)", ("v", "U")),
    "r": ("(r * L / U)", ("r", "L", "U")),
    "u": ("(u / U)", ("u", "U")),
    "p": ("(p * L / U)", ("p", "L", "U")),
    "phi": ("phi", ("phi",)),
    "d": ("delta", ("delta",)),
    "delta": ("delta", ("delta",)),
    "beta": ("beta", ("beta",)),
    "Fn": ("Fn", ("Fn",)),
    "sinkage": ("(sinkage / d)", ("sinkage", "d")),
    "trim": ("trim", ("trim",)),
}
"""Words for the motion in the prime system: how each is written, and what it asks for."""
FUNCTIONS: Final[Mapping[str, tuple[str, int]]] = {
    "abs": ("fabs({0})", 1),
    "sat": ("minimum(maximum({0}, -({1})), {1})", 2),
    "beyond": ("({0} - minimum(maximum({0}, -({1})), {1}))", 2),
    "min": ("minimum({0}, {1})", 2),
    "max": ("maximum({0}, {1})", 2),
    "sin": ("sin({0})", 1),
    "cos": ("cos({0})", 1),
    "tanh": ("tanh({0})", 1),
    "exp": ("exp({0})", 1),
    "sqrt": ("sqrt(maximum({0}, 0.0))", 1),
    "lag": ("", 2),
}
"""Functions with the number of their arguments. ``sat(x, a)`` is x within ±a, ``beyond(x, a)`` what
goes beyond, ``lag(x, T)`` follows x with a lag of T in L/U."""
MOST: Final = 9
"""Largest power of a factor."""
TOKENS: Final = 300
"""Words, numbers and marks of one expression."""
DEPTH: Final = 30
"""Brackets inside each other."""
LONGEST: Final = 20_000
"""Characters of an expression when its powers and functions are written out."""
_TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark>\*\*|[*/^+(),|-])|(?P<stray>\S))"
)
_WORDS: Final = re.compile(r"\b(?:" + "|".join(FUNCTIONS) + r")\s*\(|\b(?:beta|Fn|sinkage|trim)\b")


def is_power(word: str) -> bool:
    """Whether a word is a whole number from 1 to `MOST`."""
    return word.isdigit() and len(word) < 4 and 1 <= int(word) <= MOST


class NotUnderstood(ValueError):
    """What cannot be read, and the place in the text."""

    def __init__(self, message: str, place: int) -> None:
        super().__init__(message)
        self.place = place


def is_expression(text: str) -> bool:
    """Whether a text needs more than products of the motion.

    Examples
    --------
    >>> is_expression("Y: a*sat(v, 0.1)"), is_expression("Y: v*|v|*r")
    (True, False)
    """
    return _WORDS.search(text) is not None


@dataclass(frozen=True)
class Node:
    """A number, a word, a function or an operation, with what it works on."""

    kind: str
    word: str
    place: int
    inner: tuple[Node, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Written:
    """A function as text, and what it asks for and gives.

    Parameters
    ----------
    source : str
        Of a function named ``force``.
    outputs, states : tuple of str
        As of an `Effect`.
    words : frozenset of str
        Words of the motion that stand in it.
    """

    source: str
    outputs: tuple[str, ...]
    states: tuple[str, ...]
    words: frozenset[str]

    def function(self, name: str) -> Callable[..., Any]:
        """The function, in the words of `effects.primitives`."""
        space: dict[str, Any] = {word: getattr(primitives, word) for word in primitives.__all__}
        exec(compile(self.source, f"<effect {name}>", "exec"), space)
        made: Callable[..., Any] = space["force"]
        return made


def written(
    name: str,
    statements: Sequence[tuple[str, str, int]],
    coefficients: Sequence[str],
    parameters: Sequence[str],
) -> Written:
    """The force of an effect from its statements.

    Parameters
    ----------
    name : str
        Of the effect; its states are named after it.
    statements : sequence of (channel, expression, place)
        Each a sum of terms, and each term with one coefficient as a factor. Forces are over
        ½ρL²U² (moments ½ρL³U²).
    coefficients, parameters : sequence of str
        Names that are fitted, and names of the nonlinear parameters.

    Raises
    ------
    NotUnderstood
        With the place in the text.

    Examples
    --------
    >>> drag = written("keel", [("Y", "a*beyond(v, edge)", 0)], ["a"], ["edge"])
    >>> drag.function("keel")(v=0.5, U=1.0, L=4.0, rho=1000.0, a=-0.01, edge=0.25)
    (-20.0,)
    """
    writer = _Writer(name=name, coefficients=tuple(coefficients), parameters=tuple(parameters))
    sums: dict[str, str] = {}
    for channel, expression, place in statements:
        tree = _Reader(expression, place).whole()
        _check_linear(tree, writer.coefficients)
        own = writer.text(tree)
        sums[channel] = f"{sums[channel]} + {own}" if channel in sums else own
    for coefficient in coefficients:
        if coefficient not in writer.used:
            raise NotUnderstood(f"{coefficient} stands in no term", 0)
    channels = [channel for channel in CHANNELS if channel in sums]
    asked = sorted({"U", "L", "rho", *writer.asked} - {"v"})
    arguments = [
        *(["v"] if "v" in writer.asked else []),
        *asked,
        *writer.states,
        *(name for name in (*coefficients, *parameters) if name in writer.used),
    ]
    forces = [f"unit * {'L * ' if c in 'NK' else ''}({sums[c]})" for c in channels]
    lines = [
        f"def force({', '.join(arguments)}):",
        "    unit = 0.5 * rho * L * L * U * U",
        *(f"    {line}" for line in writer.lines),
        f"    return ({', '.join([*forces, *writer.rates])},)",
    ]
    return Written(
        source="\n".join(lines) + "\n",
        outputs=(*channels, *(f"{state}_rate" for state in writer.states)),
        states=tuple(writer.states),
        words=frozenset(writer.words),
    )


@dataclass
class _Writer:
    """Text of a function from trees, and what was met on the way."""

    name: str
    coefficients: tuple[str, ...]
    parameters: tuple[str, ...]
    asked: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    words: set[str] = field(default_factory=set)
    states: list[str] = field(default_factory=list)
    rates: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)

    def text(self, node: Node) -> str:
        if node.kind == "number":
            return repr(float(node.word))
        if node.kind == "word":
            return self._word(node)
        found = self._joined(node)
        if len(found) > LONGEST:
            raise NotUnderstood("an expression grows too long here when written out", node.place)
        return found

    def _joined(self, node: Node) -> str:
        inner = [self.text(item) for item in node.inner]
        if node.kind == "function":
            if node.word == "lag":
                return self._lag(*inner)
            return FUNCTIONS[node.word][0].format(*inner)
        if node.kind == "power":
            return f"({' * '.join(inner * int(node.word))})"
        if node.kind == "minus":
            return f"(-{inner[0]})"
        return f"({inner[0]} {node.word} {inner[1]})"

    def _word(self, node: Node) -> str:
        if node.word in (*self.coefficients, *self.parameters):
            self.used.add(node.word)
            return node.word
        if node.word not in MOTION:
            known = ", ".join((*MOTION, *self.coefficients, *self.parameters))
            raise NotUnderstood(
                f"{node.word!r} is unknown here; there are {known}. A coefficient gets a usual "
                f"size ('{node.word} ~ 0.01'), a parameter its values ('{node.word} ~ [0.1, 0.2]')",
                node.place,
            )
        text, asked = MOTION[node.word]
        self.asked.update(asked)
        self.words.add(node.word)
        return text

    def _lag(self, follows: str, lag: str) -> str:
        state = f"late_{self.name}_{len(self.states) + 1}"
        self.states.append(state)
        self.rates.append(f"({follows} - {state}) * U / (({lag}) * L)")
        return state


def _check_linear(tree: Node, coefficients: Sequence[str]) -> None:
    """Each term has one coefficient, as a factor."""
    for term in _terms(tree):
        factors = list(_factors(term))
        own = [item for item in factors if item.kind == "word" and item.word in coefficients]
        inside = [
            item
            for factor in factors
            if factor not in own
            for item in _words_in(factor)
            if item.word in coefficients
        ]
        if inside:
            raise NotUnderstood(
                f"{inside[0].word} is a coefficient: it multiplies a term, and stands in no "
                f"function, power or denominator",
                inside[0].place,
            )
        if len(own) != 1:
            raise NotUnderstood(
                "each term needs one coefficient with a usual size, as in "
                "'Y: a*v*|beta|; a ~ -0.01'",
                own[1].place if own else term.place,
            )


def _terms(node: Node) -> Iterator[Node]:
    if node.kind == "operation" and node.word in "+-":
        for item in node.inner:
            yield from _terms(item)
    elif node.kind == "minus":
        yield from _terms(node.inner[0])
    else:
        yield node


def _factors(node: Node) -> Iterator[Node]:
    if node.kind == "operation" and node.word == "*":
        for item in node.inner:
            yield from _factors(item)
    elif node.kind == "minus":
        yield from _factors(node.inner[0])
    elif node.kind == "operation" and node.word == "/":
        yield from _factors(node.inner[0])
        yield Node("function", "abs", node.place, (node.inner[1],))
    else:
        yield node


def _words_in(node: Node) -> Iterator[Node]:
    if node.kind == "word":
        yield node
    for item in node.inner:
        yield from _words_in(item)


class _Reader:
    """A tree from an expression, by recursive descent."""

    def __init__(self, text: str, start: int) -> None:
        self.tokens = [
            (str(kind), found.group(kind), start + found.start(kind))
            for found in _TOKEN.finditer(text)
            if (kind := found.lastgroup) is not None
        ]
        self.end = start + len(text.rstrip())
        self.at = 0
        self.depth = 0
        for kind, word, place in self.tokens:
            if kind == "stray":
                raise NotUnderstood(f"{word!r} has no meaning here", place)
            if kind == "number" and not float(word) <= ABSURD:
                raise NotUnderstood(f"{word:.40} is absurdly large", place)
        if len(self.tokens) > TOKENS:
            place = self.tokens[TOKENS][2]
            raise NotUnderstood(f"an expression has at most {TOKENS} words and marks", place)

    def whole(self) -> Node:
        tree = self._sum()
        if self.at < len(self.tokens):
            self._stop(f"{self.tokens[self.at][1]!r} has no meaning here")
        return tree

    def _peek(self) -> str:
        return self.tokens[self.at][1] if self.at < len(self.tokens) else ""

    def _place(self) -> int:
        return self.tokens[self.at][2] if self.at < len(self.tokens) else self.end

    def _take(self, mark: str) -> None:
        if self._peek() != mark:
            self._stop(f"{mark!r} is missing")
        self.at += 1

    def _stop(self, message: str) -> NoReturn:
        raise NotUnderstood(message, self._place())

    def _sum(self) -> Node:
        return self._chain(self._product, "+-")

    def _product(self) -> Node:
        return self._chain(self._signed, "*/")

    def _chain(self, inner: Callable[[], Node], marks: str) -> Node:
        tree = inner()
        while self._peek() and self._peek() in marks:
            mark, place = self._peek(), self._place()
            self.at += 1
            tree = Node("operation", mark, place, (tree, inner()))
        return tree

    def _signed(self) -> Node:
        self.depth += 1
        if self.depth > DEPTH:
            self._stop(f"at most {DEPTH} brackets and signs stand inside each other")
        found = self._unsigned()
        self.depth -= 1
        return found

    def _unsigned(self) -> Node:
        if self._peek() in ("-", "+"):
            mark, place = self._peek(), self._place()
            self.at += 1
            inner = self._signed()
            return Node("minus", "-", place, (inner,)) if mark == "-" else inner
        return self._power()

    def _power(self) -> Node:
        tree = self._atom()
        if self._peek() not in ("^", "**"):
            return tree
        self.at += 1
        place, word = self._place(), self._peek()
        if not is_power(word):
            self._stop(f"a power is a whole number from 1 to {MOST}")
        self.at += 1
        return Node("power", word, place, (tree,))

    def _atom(self) -> Node:
        if self.at >= len(self.tokens):
            self._stop("a factor is missing")
        kind, word, place = self.tokens[self.at]
        self.at += 1
        if kind == "number":
            return Node("number", word, place)
        if word == "(":
            tree = self._sum()
            self._take(")")
            return tree
        if word == "|":
            tree = self._sum()
            self._take("|")
            return Node("function", "abs", place, (tree,))
        if kind != "word":
            self.at -= 1
            self._stop(f"{word!r} has no meaning here")
        if self._peek() != "(":
            return Node("word", word, place)
        return self._called(word, place)

    def _called(self, word: str, place: int) -> Node:
        if word not in FUNCTIONS:
            known = ", ".join(FUNCTIONS)
            raise NotUnderstood(f"there is no function {word!r}; there are {known}", place)
        self._take("(")
        inner = [self._sum()]
        while self._peek() == ",":
            self.at += 1
            inner.append(self._sum())
        self._take(")")
        count = FUNCTIONS[word][1]
        if len(inner) != count:
            raise NotUnderstood(f"{word} takes {count} arguments, not {len(inner)}", place)
        return Node("function", word, place, tuple(inner))
