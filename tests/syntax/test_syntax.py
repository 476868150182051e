"""Trees are what was read, whatever brackets the text had, and print as the same again."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.effects import primitives
from pmmkit.syntax import (
    Binary,
    Call,
    Member,
    Name,
    Number,
    Several,
    Subscript,
    Unary,
    Unwritable,
    expression,
    functions,
    python_lines,
    statements,
)
from pmmkit.syntax.printing import PythonPrinter
from pmmkit.syntax.reading import function_of
from pmmkit.syntax.tree import Compare, Conditional, Logic, Stray
from pmmkit.syntax.words import FUNCTIONS, bound, called, counted, word_of

NAMES = st.sampled_from("abc").map(Name)
NUMBERS = st.one_of(
    st.integers(0, 10**12), st.floats(0.0, allow_infinity=True, allow_nan=False)
).map(Number)


SIGNS = st.sampled_from(("+", "-", "*", "/", "//", "%", "**", "@"))
COMPARED = st.sampled_from(("==", "!=", "<", "<=", ">", ">="))


def _grown(inner):
    few = st.lists(inner, max_size=3).map(tuple)
    two, three = st.tuples(inner, inner), st.tuples(inner, inner, inner)
    return st.one_of(
        st.builds(Unary, st.sampled_from(("-", "+", "not")), inner),
        st.builds(Binary, SIGNS, inner, inner),
        st.builds(Conditional, inner, inner, inner),
        st.builds(Compare, st.tuples(COMPARED), two),
        st.builds(Compare, st.tuples(COMPARED, COMPARED), three),
        st.builds(Logic, st.sampled_from(("and", "or")), st.one_of(two, three)),
        st.builds(Subscript, inner, inner),
        st.builds(Member, NAMES, st.just("real")),
        st.builds(Call, NAMES, few),
        st.builds(Several, few),
    )


@given(st.recursive(st.one_of(NAMES, NUMBERS), _grown, max_leaves=12))
def test_what_is_printed_is_read_as_the_same_tree(tree):
    assert expression(PythonPrinter().text(tree)) == tree


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("-x**2", "-x ** 2"),
        ("(-x)**2", "(-x) ** 2"),
        ("2**-x", "2 ** -x"),
        ("a**b**c", "a ** b ** c"),
        ("(a**b)**c", "(a ** b) ** c"),
        ("a-(b-c)", "a - (b - c)"),
        ("(a-b)-c", "a - b - c"),
        ("a/(b*c)", "a / (b * c)"),
        ("(a/b)*c", "a / b * c"),
        ("-(a*b)", "-(a * b)"),
        ("(a < b) == (b < c)", "(a < b) == (b < c)"),
        ("not (a and b) or c", "not (a and b) or c"),
        ("(a if b else c) if d else e", "(a if b else c) if d else e"),
        ("1e400 + 5e-324", "1e309 + 5e-324"),
    ],
)
def test_brackets_stand_where_the_meaning_asks_for_them(text, printed):
    assert PythonPrinter().text(expression(text)) == printed
    assert expression(printed) == expression(text)


TEXT = '''
def told(a, b=2.0):
    """Words."""
    x, y = a, b
    y: float = 1.0
    for i in range(3):
        if i == 2:
            continue
        elif a > b:
            break
        x += i
    else:
        pass
    while x < 0.0:
        x[i], y = y, x[1:, :2]
    points.T.copy(a, key=b)
    return x,
'''


def test_functions_are_read_whole_and_run_as_before():
    (tree,) = functions(TEXT).values()
    assert (tree.name, tree.arguments, tree.told) == ("told", ("a", "b"), "Words.")
    assert not [node for node in tree.nodes() if isinstance(node, Stray)]
    again = "\n".join(python_lines(tree, mark="kept"))
    assert again.startswith("@kept\ndef told(a, b=2.0):\n    x, y = a, b\n    y = 1.0\n")
    assert functions(again)["told"].body == tree.body
    source = "\n".join(python_lines(function_of(primitives.interpolate)))
    space: dict = {}
    exec(source, space)
    xs, ys = (0.0, 1.0, 3.0), (5.0, 7.0, 8.0)
    for x in (-1.0, 0.0, 0.3, 1.0, 2.0, 9.0, math.nan):
        assert space["interpolate"](x, xs, ys) == primitives.interpolate(x, xs, ys)


def test_what_no_tree_is_made_of_is_said_by_whoever_comes_to_it():
    for text in ("with a:\n    b", "[x for x in y]", "x[::2]", "f(*a)", "'text'.y", "a = b = c"):
        block = statements(text)
        assert any(isinstance(node, Stray) for item in block for node in item.nodes())
        with pytest.raises(Unwritable, match="Python is not written for"):
            python_lines(block)
    with pytest.raises(Unwritable, match="inside another"):
        function_of(lambda x: x)
    with pytest.raises(Unwritable, match="not there"):
        function_of(len)


def test_names_are_replaced_and_nothing_is_changed_in_place():
    tree = expression("k[3] + f(k[4], k[x])")

    def rule(node):
        match node:
            case Subscript(of=Name(word="k"), at=Number(value=at)):
                return Name(f"k_{at}")
        return node

    assert tree.replaced(rule) == expression("k_3 + f(k_4, k[x])")
    assert tree == expression("k[3] + f(k[4], k[x])")
    assert tree.replaced(lambda node: node) is not None
    assert tree.names() == {"k", "f", "x"}


def test_every_function_of_the_list_is_found_by_what_it_is():
    for word, known in FUNCTIONS.items():
        function = vars(__import__(known.home, fromlist=[word]))[word]
        assert word_of(function) == word
    assert word_of(sum) is None
    assert [counted("atan2", 2), counted("atan2", 1), counted("min", 1)] == [True, False, False]


def _scaled(x, by=2.5, *, plus=0.0):
    return x * by + plus


def test_arguments_of_a_call_are_put_in_order():
    def usual(x, by=2.5):
        return x * by

    tree = functions("def usual(x, by=2.5):\n    return x * by")["usual"]
    call = expression("usual(a, by=b)")
    assert bound(tree, usual, call) == (Name("a"), Name("b"))
    assert bound(tree, usual, expression("usual(x=a)")) == (Name("a"), Number(2.5))
    assert called(call, {"usual": usual}) == ("usual", usual)
    for text, why in (("usual()", "leaves an argument out"), ("usual(a, b, c)", "has not")):
        with pytest.raises(Unwritable, match=why):
            bound(tree, usual, expression(text))
    assert not function_of(_scaled).plain
    with pytest.raises(Unwritable, match="by its name"):
        called(expression("f(x)(y)"), {})
