"""Syntax trees: what equations and effects may consist of, in whatever language they are written.

All nodes are frozen and compared by what they say; the place in a text where one was read from
does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar


class Unwritable(Exception):
    """What a language has no words for, or what no tree is made of."""


@dataclass(frozen=True)
class Node:
    """A part of a tree."""


@dataclass(frozen=True)
class Number(Node):
    """A number, whole or not, or a truth; other constants are `Stray`."""

    value: bool | int | float
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Name(Node):
    """A variable, a constant or a function by its name."""

    word: str
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Member(Node):
    """What belongs to something else: ``math.pi``, ``State.u``."""

    of: Expression
    word: str


@dataclass(frozen=True)
class Call(Node):
    """A function of arguments, some of them by name."""

    function: Expression
    inner: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...] = ()
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Unary(Node):
    """``-``, ``+`` or ``not`` in front of an operand."""

    sign: str
    inner: Expression
    place: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Binary(Node):
    """An operator of arithmetic between two operands."""

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
    """What stands at a place of a list; places count from 0."""

    of: Expression
    at: Expression


@dataclass(frozen=True)
class Span(Node):
    """Places from one end to another."""

    low: Expression | None
    high: Expression | None


@dataclass(frozen=True)
class Several(Node):
    """Values together: a tuple."""

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
    """The end of a function."""

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


Tree = TypeVar("Tree")


def replaced(tree: Tree, rule: Callable[[Any], Any]) -> Tree:
    """A tree in which each node, from the leaves to the root, is what a rule makes of it.

    Parameters
    ----------
    tree : Node or tuple of nodes
    rule : callable
        Gives a node for a node: the same where nothing is to change.

    Examples
    --------
    >>> doubled = lambda node: Number(2 * node.value) if isinstance(node, Number) else node
    >>> replaced(Binary("+", Name("x"), Number(3)), doubled).right
    Number(value=6)
    """
    made: Any = tree
    if isinstance(tree, tuple):
        return tuple([replaced(item, rule) for item in tree])  # type: ignore[return-value]
    if isinstance(tree, Node):
        changed = {}
        for name, value in vars(tree).items():
            if isinstance(value, Node | tuple):
                new = replaced(value, rule)
                if new is not value:
                    changed[name] = new
        made = rule(replace(tree, **changed) if changed else tree)
    return made  # type: ignore[no-any-return]


def nodes(tree: Any) -> Iterator[Node]:
    """All nodes of a tree, the root first.

    Examples
    --------
    >>> [type(node).__name__ for node in nodes(Unary("-", Name("x")))]
    ['Unary', 'Name']
    """
    if isinstance(tree, tuple):
        for item in tree:
            yield from nodes(item)
    elif isinstance(tree, Node):
        yield tree
        for value in vars(tree).values():
            if isinstance(value, Node | tuple):
                yield from nodes(value)


def names(tree: Any) -> frozenset[str]:
    """The words of all names in a tree, those of functions among them."""
    return frozenset(node.word for node in nodes(tree) if isinstance(node, Name))
