"""Functions of Python, in the words that it shares with C, as the text of LLVM's language.

A compiler that has to find out what kinds of values stand behind the names of any program takes
longer for that than for the machine code: ten seconds where this takes one. Here kinds are few
(`Kind`), and lists are addresses of numbers: what is written is handed to LLVM as it stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import FunctionType, ModuleType
from typing import Any, Final

from pmmkit.syntax.c.kinds import identifier
from pmmkit.syntax.llvm.function import LlvmBody
from pmmkit.syntax.llvm.kinds import BOOL, DOUBLE, INT, LIST, NOTHING, Kind, Value, constant
from pmmkit.syntax.reading import function_of
from pmmkit.syntax.tree import Call, Expression, Function, Unwritable
from pmmkit.syntax.words import bound

_KINDS: Final = {"bool": BOOL, "int": INT, "double": DOUBLE, "list": LIST}
_WORDS: Final = {kind: word for word, kind in _KINDS.items()}


class LlvmProgram:
    """A module of LLVM that grows by the functions that are asked for and all that they call.

    Parameters
    ----------
    trees : mapping of str to Function
        Functions of a module that have no source elsewhere.
    module : module
        The same functions, and what stands beside them.
    prefix : str
        Of the names that others see: of two functions of one name and of arguments of the same
        kinds a session takes the first.
    """

    def __init__(self, trees: Mapping[str, Function], module: ModuleType, prefix: str) -> None:
        self._trees = trees
        self._own = vars(module)
        self._prefix = prefix
        self._done: dict[tuple[Any, tuple[Kind, ...]], tuple[str, Kind] | None] = {}
        self._tables: dict[tuple[Kind, str], str] = {}
        self._declared: dict[str, str] = {}
        self._parts: list[str] = []
        self._loops: list[str] = []

    def take(self, name: str, kinds: Sequence[str]) -> tuple[str, tuple[str, ...]]:
        """Translate a function of the module for arguments of some kinds.

        Parameters
        ----------
        name : str
        kinds : sequence of str
            ``bool``, ``int``, ``double``, or ``list`` for the address of numbers.

        Returns
        -------
        str, tuple of str
            Its name in LLVM, and the kinds of what it returns: none, one, or several together.

        Raises
        ------
        Unwritable
            If it is written with what is not known here.
        """
        asked = tuple(_KINDS[kind] for kind in kinds)
        own, returned = self.function(self._own[name], asked, name)
        given = ", ".join(f"{kind.llvm} %{place}" for place, kind in enumerate(asked))
        seen = ".".join([f"{self._prefix}{name}", *kinds])
        result = "" if returned == NOTHING else "%r = "
        ret = "ret void" if returned == NOTHING else f"ret {returned.llvm} %r"
        self._parts.append(
            f"define {returned.llvm} @{seen}({given}) noinline nounwind {{\n"
            f"{result}call {returned.llvm} @{own}({given})\n{ret}\n}}\n"
        )
        if returned == NOTHING:
            return seen, ()
        return seen, tuple(_WORDS[kind] for kind in returned.inner or (returned,))

    @property
    def text(self) -> str:
        """The module."""
        return "\n".join([*sorted(self._declared.values()), *self._parts, *self._loops])

    @property
    def outer(self) -> list[str]:
        """Functions of the C library that it calls by their names."""
        return sorted(name for name in self._declared if not name.startswith("llvm."))

    def long_loop(self) -> str:
        """Mark of a loop over many places, which LLVM may make vectors of.

        It would unroll it before it looks for vectors, and then find none. Loops over the states,
        of which most ships have six, are not marked: unrolled they are faster.
        """
        at = len(self._loops)
        self._loops.append(f'!{at} = distinct !{{!{at}, !{{!"llvm.loop.unroll.disable"}}}}')
        return f", !llvm.loop !{at}"

    def declared(self, result: str, name: str, rest: str) -> None:
        """Note a function of LLVM or of the C library."""
        self._declared[name] = f"declare {result} @{name}{rest}"

    def table(self, value: Sequence[Any]) -> Value:
        """Numbers that stand in a module; rows of equal length are a table of tables."""
        rows = [value] if isinstance(value[0], int | float) else list(value)
        if len({len(row) for row in rows}) != 1:
            raise Unwritable("rows of different length")
        flat = [x for row in rows for x in row]
        inner = INT if all(isinstance(x, int) for x in flat) else DOUBLE
        key = inner, repr(flat)
        if key not in self._tables:
            name = self._tables[key] = f"@table_{len(self._tables)}"
            items = ", ".join(
                f"{inner.llvm} {constant(x if inner == INT else float(x)).text}" for x in flat
            )
            self._parts.append(
                f"{name} = private unnamed_addr constant [{len(flat)} x {inner.llvm}] [{items}]"
            )
        kind = Kind("ptr", len(rows[0]), (inner,))
        return Value(self._tables[key], kind if rows[0] is value else Kind("ptr", None, (kind,)))

    def arguments(self, function: FunctionType, alias: str, tree: Call) -> tuple[Expression, ...]:
        """What a call gives each argument of a function."""
        return bound(self._tree(function, alias), function, tree)

    def function(
        self, function: FunctionType, kinds: tuple[Kind, ...], alias: str
    ) -> tuple[str, Kind]:
        """Name and kind of what is returned, of a function for arguments of some kinds."""
        key = function, kinds
        if key not in self._done:
            self._done[key] = None
            tree = self._tree(function, alias)
            if len(tree.arguments) != len(kinds) or not tree.plain:
                raise Unwritable("arguments of a form that is not written")
            try:
                body = LlvmBody(self, tree, kinds, function.__globals__)
            except Unwritable as error:
                raise Unwritable(f"{error}, in {alias}") from error
            name = f"{identifier(alias)}_{len(self._done)}"
            arguments = ", ".join(f"{kind.llvm} %a{i}" for i, kind in enumerate(kinds))
            head = f"define internal {body.returned.llvm} @{name}({arguments}) nounwind {{"
            self._parts.append("\n".join([head, *body.lines, "}\n"]))
            self._done[key] = name, body.returned
        found = self._done[key]
        if found is None:
            raise Unwritable("a function that calls itself")
        return found

    def _tree(self, function: FunctionType, alias: str) -> Function:
        for name in (alias, function.__name__):
            own = self._own.get(name)
            if name in self._trees and getattr(own, "__code__", None) is function.__code__:
                return self._trees[name]
        return function_of(function)
