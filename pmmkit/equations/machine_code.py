"""Functions of lists as machine code: LLVM gets their text, numba what Python hands over."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from types import ModuleType
from typing import Any, Final

import llvmlite.binding
import llvmlite.ir
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.extending import intrinsic

from pmmkit.base import ModelError
from pmmkit.syntax import Function, LlvmProgram, Unwritable

Source = Callable[[], tuple[Mapping[str, Function], ModuleType]]
_NUMBERS: Final = {"bool": types.boolean, "int": types.int64, "double": types.float64}
_intrinsic: Final[Callable[[Callable[..., Any]], Any]] = intrinsic


def written(source: Source, prefix: str) -> Callable[[str], Any]:
    """What gives a function of a module, by its name, as one that numba calls with a tuple.

    source: gives trees and module of an `LlvmProgram`. prefix: as of that.
    """
    return partial(_written, source, prefix)


def _written(source: Source, prefix: str, name: str) -> Any:
    @_intrinsic
    def call(_context: Any, given: Any) -> Any:
        program = LlvmProgram(*source(), prefix)
        kinds = [_kind(item) for item in given]
        try:
            symbol, returned = program.take(name, kinds)
        except Unwritable as error:
            raise ModelError(
                f"Equations of this model cannot be compiled: they hold {error}.",
                remedy="Write the effect in the words that CONTRIBUTING.md names (add an effect), "
                "or simulate ship by ship with compiled=False.",
            ) from error
        gives = [_NUMBERS[kind] for kind in returned]
        one = types.none if not gives else gives[0] if len(gives) == 1 else types.Tuple(gives)

        def made(target: Any, builder: Any, _signature: Any, values: Any) -> Any:
            text = llvmlite.binding.parse_assembly(program.text)
            text.triple = builder.module.triple
            target.active_code_library.add_llvm_module(text)
            items = [
                target.make_array(item)(target, builder, value).data
                if kind == "list"
                else target.cast(builder, value, item, _NUMBERS[kind])
                for item, kind, value in zip(
                    given, kinds, cgutils.unpack_tuple(builder, values[0]), strict=True
                )
            ]
            result = target.get_value_type(one) if gives else llvmlite.ir.VoidType()
            asked = llvmlite.ir.FunctionType(result, [item.type for item in items])
            function = cgutils.get_or_insert_function(builder.module, asked, symbol)
            found = builder.call(function, items)
            return found if gives else target.get_dummy_value()

        return one(given), made

    return call


def absent(names: Iterable[str]) -> list[str]:
    """Functions that are nowhere in this process: LLVM would end it when it looks for them."""
    # numba puts those that it knows where LLVM finds them.
    _ = cpu_target.target_context
    return [name for name in names if not llvmlite.binding.address_of_symbol(name)]


def _kind(item: Any) -> str:
    """What LLVM is handed for a value of numba."""
    item = types.unliteral(item)
    if isinstance(item, types.Array):
        if item.dtype != types.float64 or item.layout != "C":
            raise TypeError(f"{item}: the equations take floats that lie side by side.")
        return "list"
    if isinstance(item, types.Boolean):
        return "bool"
    return "int" if isinstance(item, types.Integer) else "double"
