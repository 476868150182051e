"""Forces that a user writes down as expressions of the motion, turned into a function.

What is read here is data: only the words below are known, each number is checked, and the function
is written from what was understood, never from the text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from keyword import iskeyword
from typing import Any, Final, NoReturn

from pmmkit.conventions import CHANNELS, parse_derivative
from pmmkit.effects import primitives
from pmmkit.effects.added_mass import AddedMass
from pmmkit.numerics import ABSURD
from pmmkit.syntax import (
    Binary,
    Call,
    Expression,
    Function,
    Name,
    Number,
    Return,
    Several,
    Unary,
    expression,
    python_lines,
    statements,
)

MOTION: Final[Mapping[str, Expression]] = {
    word: expression(text)
    for word, text in {
        "v": "v / U",
        "r": "r * L / U",
        "u": "u / U",
        "p": "p * L / U",
        "phi": "phi",
        "d": "delta",
        "delta": "delta",
        "beta": "beta",
        "Fn": "Fn",
        "sinkage": "sinkage / d",
        "trim": "trim",
    }.items()
}
"""Words for the motion in the prime system: what each is."""
FUNCTIONS: Final[Mapping[str, tuple[tuple[str, ...], Expression]]] = {
    word: (tuple(arguments.split()), expression(text))
    for word, arguments, text in (
        ("abs", "x", "fabs(x)"),
        ("sat", "x a", "minimum(maximum(x, -a), a)"),
        ("beyond", "x a", "x - minimum(maximum(x, -a), a)"),
        ("min", "x a", "minimum(x, a)"),
        ("max", "x a", "maximum(x, a)"),
        ("sin", "x", "sin(x)"),
        ("cos", "x", "cos(x)"),
        ("tanh", "x", "tanh(x)"),
        ("exp", "x", "exp(x)"),
        ("sqrt", "x", "sqrt(maximum(x, 0.0))"),
        ("lag", "x T", "(x - state) * U / (T * L)"),
    )
}
"""Functions with the names of their arguments, and what they are in words of `effects.primitives`.
``sat(x, a)`` is x within ±a, ``beyond(x, a)`` what goes beyond. ``lag(x, T)`` follows x with a lag
of T in L/U: a state, whose rate stands here."""
MOST: Final = 9
"""Largest power of a factor."""
TOKENS: Final = 300
"""Words, numbers and marks of one expression."""
DEPTH: Final = 30
"""Brackets inside each other."""
LONGEST: Final = 5000
"""Numbers, words, operators and functions of an expression when its powers and functions are
written out."""
_STATE: Final = "late_"
"""What names of states begin with."""
_BODY: Final = statements("unit = 0.5 * rho * L * L * U * U")
_NAMED: Final = _BODY[0].names()
_MEANT: Final = frozenset(
    (*MOTION, *Several((*MOTION.values(),)).names(), *_NAMED, *FUNCTIONS, *primitives.__all__)
)
_TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>[0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark>\*\*|[*/^+(),|-])|(?P<stray>\S))"
)
_WORDS: Final = re.compile(
    r"\b(?:" + "|".join(FUNCTIONS) + r")\s*\(|\b(?:beta|Fn|sinkage|trim)\b|dot\s*:"
)


def is_power(word: str) -> bool:
    """Whether a word is a whole number from 1 to `MOST`."""
    return word.isdigit() and len(word) < 4 and 1 <= int(word) <= MOST


def has_meaning(name: str, effect: str) -> bool:
    """Whether a name means something in an expression of an effect: no coefficient can have it.

    Examples
    --------
    >>> [word for word in ("edge", "Fn", "sat", "L", "lambda") if has_meaning(word, "keel")]
    ['Fn', 'sat', 'L', 'lambda']
    """
    return name in _MEANT or iskeyword(name) or name.startswith(f"{_STATE}{effect}_")


class NotUnderstood(ValueError):
    """What cannot be read, and the place in the text."""

    def __init__(self, message: str, place: int) -> None:
        super().__init__(message)
        self.place = place


def is_expression(text: str) -> bool:
    """Whether a text needs more than products of the motion.

    Examples
    --------
    >>> [is_expression(text) for text in ("Y: a*sat(v, 0.1)", "Yvdot: a*v^2", "Y: v*|v|*r")]
    [True, True, False]
    """
    return _WORDS.search(text) is not None


@dataclass(frozen=True, kw_only=True)
class WrittenFunction:
    """A function, and what it asks for and gives.

    `outputs, states`: as of an `Effect`. `words`: words of the motion that stand in it.
    """

    tree: Function
    outputs: tuple[str, ...]
    states: tuple[str, ...]
    words: frozenset[str]

    def function(self, name: str) -> Callable[..., Any]:
        """The function, in the words of `effects.primitives`."""
        space: dict[str, Any] = {word: getattr(primitives, word) for word in primitives.__all__}
        text = "\n".join(python_lines(self.tree))
        exec(compile(text, f"<effect {name}>", "exec"), space)
        made: Callable[..., Any] = space["force"]
        return made


_UNIT: Final = (Name("unit"), expression("unit * L"))
"""Of forces, of moments."""


def _mass_unit(place: str) -> Expression:
    """Force or moment per acceleration of a derivative, which the speed has no part in."""
    arms = 2 + ("NK".find(place[0]) >= 0) + parse_derivative(place).length_power
    return expression(" * ".join(["0.5 * rho", *["L"] * arms]))


def written(
    name: str,
    said: Sequence[tuple[str, str, int]],
    coefficients: Sequence[str],
    parameters: Sequence[str],
) -> WrittenFunction:
    """The force of an effect from its statements.

    Examples
    --------
    >>> drag = written("keel", [("Y", "a*beyond(v, edge)", 0)], ["a"], ["edge"])
    >>> drag.function("keel")(v=0.5, U=1.0, L=4.0, rho=1000.0, a=-0.01, edge=0.25)
    (-20.0,)
    """
    own = _Expansion(name=name, given=(*coefficients, *parameters))
    sums: dict[str, Expression] = {}
    for channel, text, place in said:
        tree = _Reader(text, place).whole()
        _check_linear(tree, coefficients)
        grown, _ = own.of(tree)
        sums[channel] = Binary("+", sums[channel], grown) if channel in sums else grown
    channels = [x for x in (*CHANNELS, *AddedMass.places()) if x in sums]
    masses = [x for x in channels if x not in CHANNELS]
    if masses and (own.states or len(masses) < len(channels)):
        raise NotUnderstood("added mass and forces are two effects, and added mass has no lag", 0)
    forces = [
        Binary("*", _mass_unit(c) if masses else _UNIT["NK".find(c) >= 0], sums[c])
        for c in channels
    ]
    returned = (*forces, *own.rates)
    body, named = ((), frozenset[str]()) if masses else (_BODY, _NAMED)
    asked = (Several(returned).names() | named) - {"unit", *primitives.__all__}
    for coefficient in coefficients:
        if coefficient not in asked:
            raise NotUnderstood(f"{coefficient} stands in no term", 0)
    motion = sorted(asked - {"v", *own.states, *own.given})
    arguments = [
        *(["v"] if "v" in asked else []),
        *motion,
        *own.states,
        *(x for x in (*coefficients, *parameters) if x in asked),
    ]
    return WrittenFunction(
        tree=Function("force", tuple(arguments), (*body, Return(Several(returned)))),
        outputs=(*channels, *(f"{state}_rate" for state in own.states)),
        states=tuple(own.states),
        words=frozenset(own.words),
    )


@dataclass
class _Expansion:
    """Trees in the words of `effects.primitives` from those of a text, and what was met on the way.

    `given` are the names of the text's own; `words`, `states` and `rates` grow.
    """

    name: str
    given: tuple[str, ...]
    words: set[str] = field(default_factory=set)
    states: list[str] = field(default_factory=list)
    rates: list[Expression] = field(default_factory=list)

    def of(self, tree: Expression) -> tuple[Expression, int]:
        """A tree written out, and how many nodes it has."""
        match tree:
            case Name():
                return self._word(tree)
            case Unary(inner=inner):
                grown, size = self.of(inner)
                return Unary("-", grown), size + 1
            case Binary(sign="**", left=left, right=Number(value=power), place=place):
                grown, size = self.of(left)
                product = grown
                for _ in range(int(power) - 1):
                    product = Binary("*", product, grown)
                return product, _sized(size * int(power) + int(power) - 1, place)
            case Binary(sign=sign, left=left, right=right, place=place):
                (a, first), (b, second) = self.of(left), self.of(right)
                return Binary(sign, a, b), _sized(first + second + 1, place)
            case Call(function=Name(word=word), inner=inner, place=place):
                return self._call(word, [self.of(item) for item in inner], place)
        return tree, 1

    def _word(self, tree: Name) -> tuple[Expression, int]:
        if tree.word in self.given:
            return tree, 1
        if tree.word not in MOTION:
            known = ", ".join((*MOTION, *self.given))
            raise NotUnderstood(
                f"{tree.word!r} is unknown here; there are {known}. A coefficient gets a usual "
                f"size ('{tree.word} ~ 0.01'), a parameter its values "
                f"('{tree.word} ~ [0.1, 0.2]')",
                tree.place,
            )
        self.words.add(tree.word)
        meant = MOTION[tree.word]
        return meant, sum(1 for _ in meant.nodes())

    def _call(
        self, word: str, given: Sequence[tuple[Expression, int]], place: int
    ) -> tuple[Expression, int]:
        own, meaning = FUNCTIONS[word]
        values = {name: tree for name, (tree, _) in zip(own, given, strict=True)}
        sizes = {name: size for name, (_, size) in zip(own, given, strict=True)}
        if word == "lag":
            state = f"{_STATE}{self.name}_{len(self.states) + 1}"
            self.states.append(state)
            values["state"] = Name(state)
        size = sum(sizes.get(x.word, 1) if isinstance(x, Name) else 1 for x in meaning.nodes())
        _sized(size, place)
        grown = meaning.replaced(
            lambda node: values.get(node.word, node) if isinstance(node, Name) else node
        )
        if word == "lag":
            self.rates.append(grown)
            return values["state"], 1
        return grown, size


def _sized(size: int, place: int) -> int:
    if size > LONGEST:
        raise NotUnderstood("an expression grows too long here when written out", place)
    return size


def _check_linear(tree: Expression, coefficients: Sequence[str]) -> None:
    """Each term has one coefficient, as a factor."""
    for term in _terms(tree):
        own, others = [], []
        for factor, divides in _factors(term):
            if isinstance(factor, Name) and factor.word in coefficients and not divides:
                own.append(factor)
            else:
                others.append(factor)
        for item in Several(tuple(others)).nodes():
            if isinstance(item, Name) and item.word in coefficients:
                raise NotUnderstood(
                    f"{item.word} is a coefficient: it multiplies a term, and stands in no "
                    f"function, power or denominator",
                    item.place,
                )
        if len(own) != 1:
            raise NotUnderstood(
                "each term needs one coefficient with a usual size, as in "
                "'Y: a*v*|beta|; a ~ -0.01'",
                own[1].place if own else _place_of(term),
            )


def _place_of(tree: Expression) -> int:
    return getattr(tree, "place", 0)


def _terms(tree: Expression) -> Iterator[Expression]:
    match tree:
        case Binary(sign="+" | "-", left=left, right=right):
            yield from _terms(left)
            yield from _terms(right)
        case Unary(inner=inner):
            yield from _terms(inner)
        case _:
            yield tree


def _factors(tree: Expression) -> Iterator[tuple[Expression, bool]]:
    """The factors of a term, and whether each divides."""
    match tree:
        case Binary(sign="*", left=left, right=right):
            yield from _factors(left)
            yield from _factors(right)
        case Binary(sign="/", left=left, right=right):
            yield from _factors(left)
            yield right, True
        case Unary(inner=inner):
            yield from _factors(inner)
        case _:
            yield tree, False


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

    def whole(self) -> Expression:
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

    def _sum(self) -> Expression:
        return self._chain(self._product, "+-")

    def _product(self) -> Expression:
        return self._chain(self._signed, "*/")

    def _chain(self, inner: Callable[[], Expression], marks: str) -> Expression:
        tree = inner()
        while self._peek() and self._peek() in marks:
            mark, place = self._peek(), self._place()
            self.at += 1
            tree = Binary(mark, tree, inner(), place)
        return tree

    def _signed(self) -> Expression:
        self.depth += 1
        if self.depth > DEPTH:
            self._stop(f"at most {DEPTH} brackets and signs stand inside each other")
        found = self._unsigned()
        self.depth -= 1
        return found

    def _unsigned(self) -> Expression:
        if self._peek() in ("-", "+"):
            mark, place = self._peek(), self._place()
            self.at += 1
            inner = self._signed()
            return Unary("-", inner, place) if mark == "-" else inner
        return self._power()

    def _power(self) -> Expression:
        tree = self._atom()
        if self._peek() not in ("^", "**"):
            return tree
        self.at += 1
        place, word = self._place(), self._peek()
        if not is_power(word):
            self._stop(f"a power is a whole number from 1 to {MOST}")
        self.at += 1
        return Binary("**", tree, Number(int(word)), place)

    def _atom(self) -> Expression:
        if self.at >= len(self.tokens):
            self._stop("a factor is missing")
        kind, word, place = self.tokens[self.at]
        self.at += 1
        if kind == "number":
            return Number(float(word), place)
        if word == "(":
            tree = self._sum()
            self._take(")")
            return tree
        if word == "|":
            tree = self._sum()
            self._take("|")
            return Call(Name("abs", place), (tree,), place=place)
        if kind != "word":
            self.at -= 1
            self._stop(f"{word!r} has no meaning here")
        if self._peek() != "(":
            return Name(word, place)
        return self._called(word, place)

    def _called(self, word: str, place: int) -> Expression:
        if word not in FUNCTIONS:
            known = ", ".join(FUNCTIONS)
            raise NotUnderstood(f"there is no function {word!r}; there are {known}", place)
        self._take("(")
        inner = [self._sum()]
        while self._peek() == ",":
            self.at += 1
            inner.append(self._sum())
        self._take(")")
        count = len(FUNCTIONS[word][0])
        if len(inner) != count:
            raise NotUnderstood(f"{word} takes {count} arguments, not {len(inner)}", place)
        return Call(Name(word, place), tuple(inner), place=place)
