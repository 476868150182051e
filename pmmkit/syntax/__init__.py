"""Formulas and functions as trees, read from Python's text, and what each language calls them."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.syntax.c.kinds import c_number
    from pmmkit.syntax.c.program import CProgram
    from pmmkit.syntax.comments import comment, plain
    from pmmkit.syntax.llvm.program import LlvmProgram
    from pmmkit.syntax.matlab.names import is_matlab_name, matlab_name, matlab_value
    from pmmkit.syntax.matlab.transcribe import MatlabLine, transcribe
    from pmmkit.syntax.printing import python_lines
    from pmmkit.syntax.reading import expression, functions, statements
    from pmmkit.syntax.tree import (
        Binary,
        Call,
        Expression,
        Function,
        Member,
        Name,
        Number,
        Return,
        Several,
        Span,
        Subscript,
        Unary,
        Unwritable,
    )

__all__ = [
    "Binary",
    "CProgram",
    "Call",
    "Expression",
    "Function",
    "LlvmProgram",
    "MatlabLine",
    "Member",
    "Name",
    "Number",
    "Return",
    "Several",
    "Span",
    "Subscript",
    "Unary",
    "Unwritable",
    "c_number",
    "comment",
    "expression",
    "functions",
    "is_matlab_name",
    "matlab_name",
    "matlab_value",
    "plain",
    "python_lines",
    "statements",
    "transcribe",
]

lazy(__name__)
