"""Syntax trees: what equations and effects may consist of, in whatever language they are written.

All nodes are frozen and compared by what they say; the place in a text where one was read from
does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any


class Unwritable(Exception):
    """What a language has no words for, or what no tree is made of."""


@dataclass(frozen=True)
class Node:
    """A part of a tree."""

    def nodes(self) -> Iterator[Node]:
        """All nodes of the tree, the root first.

        Examples
        --------
        >>> [type(node).__name__ for node in Unary("-", Name("x")).nodes()]
        ['Unary', 'Name']
        """
        yield self
        for value in vars(self).values():
            for inner in _nodes_in(value):
                yield from inner.nodes()

    def names(self) -> frozenset[str]:
        """The words of all names in the tree, those of functions among them."""
        return frozenset(node.word for node in self.nodes() if isinstance(node, Name))

    def replaced(self, rule: Callable[[Any], Any]) -> Any:
        """The tree in which each node, from the leaves to the root, is what a rule makes of it.

        Examples
        --------
        >>> doubled = lambda node: Number(2 * node.value) if isinstance(node, Number) else node
        >>> Binary("+", Name("x"), Number(3)).replaced(doubled).right
        Number(value=6)
        """
        changed = {
            name: _replaced_in(value, rule)
            for name, value in vars(self).items()
            if isinstance(value, Node | tuple)
        }
        return rule(replace(self, **changed) if changed else self)


def _nodes_in(value: Any) -> Iterator[Node]:
    """The nodes that stand in a field of a node, not those within them."""
    if isinstance(value, Node):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _nodes_in(item)


def _replaced_in(value: Any, rule: Callable[[Any], Any]) -> Any:
    if isinstance(value, tuple):
        return tuple([_replaced_in(item, rule) for item in value])
    return value.replaced(rule) if isinstance(value, Node) else value


@dataclass(frozen=True)
class Number(Node):
    """A number, whole or not, or a truth: its `value`; other constants are `Stray`.

    `place`: where it stood in a text.
    """

    value: bool | int | float
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Name(Node):
    """A variable, a constant or a function by its name, a `word`; `place` as of a `Number`."""

    word: str
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Member(Node):
    """What belongs to something else: ``math.pi`` is the `word` ``pi`` `of` ``math``."""

    of: Expression
    word: str


@dataclass(frozen=True)
class Call(Node):
    """A `function` of arguments, `inner` by order and `named`; `place` as of a `Number`."""

    function: Expression
    inner: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...] = ()
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Unary(Node):
    """A `sign`, ``-``, ``+`` or ``not``, before `inner`; `place` as of a `Number`."""

    sign: str
    inner: Expression
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Binary(Node):
    """A `sign` of arithmetic between `left` and `right`; `place` as of a `Number`."""

    sign: str
    left: Expression
    right: Expression
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Logic(Node):
    """``and`` or ``or`` between two operands or more."""

    sign: str
    inner: tuple[Expression, ...]


@dataclass(frozen=True)
class Compare(Node):
    """A chain of comparisons: each operand with the one before it."""

    signs: tuple[str, ...]
    inner: tuple[Expression, ...]


@dataclass(frozen=True)
class Conditional(Node):
    """One of two values."""

    test: Expression
    yes: Expression
    no: Expression


@dataclass(frozen=True)
class Subscript(Node):
    """What stands in a list, `of`, `at` a place; places count from 0."""

    of: Expression
    at: Expression


@dataclass(frozen=True)
class Span(Node):
    """Places from `low` on to before `high`."""

    low: Expression | None
    high: Expression | None


@dataclass(frozen=True)
class Several(Node):
    """Values together, `inner`: a tuple."""

    inner: tuple[Expression, ...]


@dataclass(frozen=True)
class Stray(Node):
    """What has no place in a tree; whoever comes to it says so."""

    kind: str


Expression = (
    Number
    | Name
    | Member
    | Call
    | Unary
    | Binary
    | Logic
    | Compare
    | Conditional
    | Subscript
    | Span
    | Several
    | Stray
)


@dataclass(frozen=True)
class Assign(Node):
    """A value put under a name, at a place, or several at once."""

    target: Expression
    value: Expression


@dataclass(frozen=True)
class Augmented(Node):
    """A value changed by an operator: ``x += 1``."""

    target: Expression
    sign: str
    value: Expression


@dataclass(frozen=True)
class Do(Node):
    """A call for what it does."""

    value: Expression


@dataclass(frozen=True)
class If(Node):
    """A branch."""

    test: Expression
    yes: tuple[Statement, ...]
    no: tuple[Statement, ...]


@dataclass(frozen=True)
class While(Node):
    """A loop as long as something holds; `otherwise` where no break ended it."""

    test: Expression
    body: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class For(Node):
    """A loop over values; `otherwise` where no break ended it."""

    target: Expression
    over: Expression
    body: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class Leave(Node):
    """``break``, ``continue`` or ``pass``."""

    word: str


@dataclass(frozen=True)
class Return(Node):
    """The end of a function, and the `value` that it gives."""

    value: Expression | None


Statement = Assign | Augmented | Do | If | While | For | Leave | Return | Stray


@dataclass(frozen=True)
class Function(Node):
    """A function.

    Parameters
    ----------
    name : str
    arguments : tuple of str
        In their order.
    defaults : tuple of (str, Expression)
        Of arguments that may be left out.
    body : tuple of Statement
        Without the docstring.
    told : str
        The docstring.
    plain : bool
        Whether all arguments have an order, and none stands for several.
    """

    name: str
    arguments: tuple[str, ...]
    body: tuple[Statement, ...]
    defaults: tuple[tuple[str, Expression], ...] = ()
    told: str = ""
    plain: bool = True
