"""Functions of Python, in the words that it shares with C, as the text of a C program.

`pmmkit.syntax.matlab.transcribe` writes an effect out as a list of assignments, for readers who
know MATLAB. Here functions stay functions, with their loops and branches, so that the equations,
the integrator and every effect that can be compiled can be written.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from types import FunctionType, ModuleType
from typing import Any, Final

from pmmkit.syntax.c.function import Body
from pmmkit.syntax.c.kinds import NOTHING, ValueKind, c_number, identifier
from pmmkit.syntax.comments import comment
from pmmkit.syntax.reading import function_of, functions
from pmmkit.syntax.tree import Call, Expression, Function, Unwritable
from pmmkit.syntax.words import bound

PREFIX: Final = "eq_"
"""Of all translated functions, so that none has the name of one of C's."""
_WIDTH: Final = 100
_HEAD: Final = """\
static double larger(double a, double b) { return b > a ? b : a; }
static double smaller(double a, double b) { return b < a ? b : a; }
static int floored(int a, int b) { return a / b - (a % b != 0 && (a % b < 0) != (b < 0)); }
"""


class CProgram:
    """A C program that grows by the functions that are asked for and all that they call.

    Parameters
    ----------
    text : str
        Of the module; its functions have no source elsewhere.
    module : module
        What the text makes when it is run.
    """

    def __init__(self, text: str, module: ModuleType) -> None:
        self._trees = functions(text)
        self._own = vars(module)
        self._done: dict[tuple[Any, tuple[ValueKind, ...]], tuple[str, ValueKind]] = {}
        self._under_way: set[tuple[Any, tuple[ValueKind, ...]]] = set()
        self._names: set[str] = set()
        self._tables: dict[int, str] = {}
        self._kept: list[object] = []
        self._sizes: set[int] = set()
        self._parts: list[str] = []

    def take(self, name: str, kinds: Sequence[str]) -> str:
        """Translate a function of the module for arguments of some kinds; gives its name in C."""
        return self.function(self._own[name], tuple(map(ValueKind, kinds)), name)[0]

    @property
    def text(self) -> str:
        """The program: all functions are static and stand below those that they call."""
        members = {
            size: " ".join(f"double v{place};" for place in range(size))
            for size in sorted(self._sizes)
        }
        structs = [f"struct numbers_{size} {{ {inner} }};" for size, inner in members.items()]
        return "\n".join([*structs, _HEAD, *self._parts])

    def tuple_of(self, size: int) -> ValueKind:
        """The kind of so many numbers that a function returns together."""
        self._sizes.add(size)
        return ValueKind("tuple", size)

    def table(self, value: Sequence[Any], alias: str) -> str:
        """The name in C of numbers that stand in a module."""
        if id(value) in self._tables:
            return self._tables[id(value)]
        name = self._tables[id(value)] = self._free(f"table{alias}".replace("__", "_").lower())
        self._kept.append(value)
        rows = [value] if isinstance(value[0], int | float) else list(value)
        lists = [f"{{{', '.join(c_number(float(x)) for x in row)}}}" for row in rows]
        size = "" if len(rows) == 1 and rows[0] is value else f"[{len(rows)}]"
        inner = lists[0] if not size else "{\n    " + ",\n    ".join(lists) + "}"
        self._parts.append(f"static const double {name}{size}[{len(rows[0])}] = {inner};\n")
        return name

    def function(
        self, function: FunctionType, kinds: tuple[ValueKind, ...], alias: str
    ) -> tuple[str, ValueKind]:
        """Name in C and kind of what is returned, of a function for arguments of some kinds."""
        key = function, kinds
        if key in self._under_way:
            raise Unwritable("a function that calls itself")
        if key not in self._done:
            self._under_way.add(key)
            tree, outside = self._tree(function, alias), function.__globals__
            names = tree.arguments
            if len(names) != len(kinds) or not tree.plain:
                raise Unwritable("arguments of a form that C has not")
            body = Body(self, tree, dict(zip(names, kinds, strict=True)), outside)
            name = self._free(f"{PREFIX}{identifier(alias).lstrip('_')}")
            told = comment(tree.told.split("\n\n")[0], "//")
            arguments = ", ".join(map(_argument, names, kinds)) or "void"
            lines = [
                f"static {body.returned.text} {name}({arguments})",
                "{",
                *(f"    {line}" for line in body.lines),
                "}",
            ]
            head = [line.replace("\\", "/") for line in told if line != "//"]
            wrapped = [part for line in lines for part in _wrapped(line)]
            self._parts.append("\n".join([*head, *wrapped, ""]))
            self._under_way.discard(key)
            self._done[key] = name, body.returned
        return self._done[key]

    def arguments(self, function: FunctionType, alias: str, tree: Call) -> tuple[Expression, ...]:
        """What a call gives each argument of a function."""
        return bound(self._tree(function, alias), function, tree)

    def _tree(self, function: FunctionType, alias: str) -> Function:
        for name in (alias, function.__name__):
            if function.__globals__ is self._own and name in self._trees:
                return self._trees[name]
        return function_of(function)

    def _free(self, name: str) -> str:
        found, count = name, 1
        while found in self._names:
            count += 1
            found = f"{name}_{count}"
        self._names.add(found)
        return found


def _wrapped(line: str) -> list[str]:
    """A long line over several, for people; C does not mind."""
    indent = " " * (len(line) - len(line.lstrip()))
    return textwrap.wrap(
        line.strip(),
        _WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}    ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _argument(name: str, kind: ValueKind) -> str:
    own = identifier(name)
    if kind.name == "list":
        return f"double *{own}"
    if kind.name == "table":
        return f"const double *{own}, int {own}_count"
    if not kind.is_number or kind == NOTHING:
        raise Unwritable("an argument of a kind that C is not given")
    return f"{kind.text} {own}"
