"""Which changes of a line no test notices: small mistakes are made one at a time, and tests run.

    python -m scripts.studies.mutants [--modules pmmkit/reduction/solve.py ...] [--each 42]
                  [--seed 0] [--tests tests/reduction ...] [--slow] [--budget 60]
                  [--limit-seconds 300] [--workers 2] [--out survivors.json] [--only survivors.json]

The checkout is copied to a temporary folder for each worker and is not touched. For each module the
tests of its room (or --tests) run once with probes in it, which say what lines each test reaches.
Then --each changes are drawn: + for -, * for /, a comparison turned or moved to its edge, `and` for
`or`, a `not` or a sign left out, a number one more or less, times 1.1 or a half, a result of the
other sign. For each the tests that reach the line run, the quickest first, up to --budget seconds
of what they took with the probes, until one fails. Tests marked slow run with --slow alone.

killed      a test fell
survived    none did: the change means nothing, or a test is missing
time-out    they did not end within --limit-seconds
unreached   no test that was asked runs this line

Survivors stand in --out; with --only FILE they are tried again, against other tests where --tests
are given. A worker has numpy and the like loaded and forks for each change: not on Windows.
"""

from __future__ import annotations

import argparse
import ast
import builtins
import json
import multiprocessing
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from hypothesis import Phase, is_hypothesis_test, settings

ROOT = Path(__file__).parents[2]
COPIED = ("pmmkit", "tests", "scripts", "datasets", "docs")
FILES = ("pyproject.toml", "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "RELEASING.md")
MODULES = (
    "pmmkit/reduction/solve.py",
    "pmmkit/diagnosis/captive/evidence.py",
    "pmmkit/intake/checks/inertia.py",
    "pmmkit/campaigns/motion/kinematics.py",
    "pmmkit/equations/run.py",
)
WARM = ("scipy.optimize", "scipy.linalg", "scipy.stats", "pandas", "xarray", "numba", "h5py")
SWAPPED: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Lt: (ast.GtE, ast.LtE),
    ast.LtE: (ast.Gt, ast.Lt),
    ast.Gt: (ast.LtE, ast.GtE),
    ast.GtE: (ast.Lt, ast.Gt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}
NUMBERS = ("float", "int", "Array")
PROBED = "reached_lines"
NEVER = -1


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """A change of a module: text from one place to another, and the line whose probe it has."""

    module: str
    line: int
    statement: int
    begin: int
    end: int
    before: str
    after: str

    def applied(self, source: str) -> str:
        """The module with the change; a ValueError where it is another by now."""
        if source[self.begin : self.end] != self.before:
            raise ValueError(f"{self.module} is another than when this change was drawn.")
        return source[: self.begin] + self.after + source[self.end :]

    def words(self) -> str:
        """The change in a line."""
        before, after = (" ".join(text.split()) for text in (self.before, self.after))
        return f"{Path(self.module).name}:{self.line}  {before}  ->  {after}"


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What came of a change."""

    mutant: Mutant
    outcome: str
    tests: int
    seconds: float
    by: str = ""


def mutants(module: str, source: str) -> Iterator[Mutant]:
    """All changes of a module."""
    begins = [0]
    for row in source.splitlines(keepends=True):
        begins.append(begins[-1] + len(row))

    def place(row: int, column: int) -> int:
        text = source[begins[row - 1] : begins[row]].encode()
        return begins[row - 1] + len(text[:column].decode())

    for node, statement, after in changes(ast.parse(source), NEVER, numbers=False):
        begin = place(node.lineno, node.col_offset)
        end = place(node.end_lineno or 0, node.end_col_offset or 0)
        yield Mutant(
            module=module,
            line=node.lineno,
            statement=statement,
            begin=begin,
            end=end,
            before=source[begin:end],
            after=after,
        )


def changes(node: ast.AST, statement: int, *, numbers: bool) -> Iterator[tuple[Any, int, str]]:
    """Nodes with the line of the statement of a function that has them, and what takes their place;
    annotations, decorators, texts and errors stay as they are."""
    if isinstance(node, (ast.JoinedStr, ast.Raise, ast.Import, ast.ImportFrom)):
        return
    if isinstance(node, ast.FunctionDef):
        numbers = node.returns is not None and ast.unparse(node.returns) in NUMBERS
        for default in [*node.args.defaults, *filter(None, node.args.kw_defaults)]:
            yield from changes(default, statement, numbers=False)
        for part in node.body:
            yield from changes(part, part.lineno, numbers=numbers)
        return
    if isinstance(node, ast.stmt) and statement != NEVER:
        statement = node.lineno
    if isinstance(node, ast.expr):
        yield from ((node, statement, f"({text})") for text in instead(node))
    if isinstance(node, ast.AugAssign):
        for kind in SWAPPED.get(type(node.op), ()):
            other = ast.AugAssign(target=node.target, op=kind(), value=node.value)
            yield node, statement, ast.unparse(other)
    if isinstance(node, ast.Return) and numbers and node.value is not None:
        yield node, statement, f"return -({ast.unparse(node.value)})"
    left_out = ("annotation", "decorator_list", "keywords") if is_class(node) else ("annotation",)
    for name, value in ast.iter_fields(node):
        if name not in left_out:
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, ast.AST):
                    yield from changes(part, statement, numbers=numbers)


def is_class(node: ast.AST) -> bool:
    """Whether a node is that of a class, whose words in brackets say how it is made."""
    return isinstance(node, ast.ClassDef)


def instead(node: ast.expr) -> Iterator[str]:
    """What may stand in the place of an expression."""
    if isinstance(node, ast.BinOp) and not any(map(is_text, (node.left, node.right))):
        for kind in SWAPPED.get(type(node.op), ()):
            yield ast.unparse(ast.BinOp(left=node.left, op=kind(), right=node.right))
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        for kind in SWAPPED.get(type(node.ops[0]), ()):
            yield ast.unparse(ast.Compare(node.left, [kind()], node.comparators))
    elif isinstance(node, ast.BoolOp):
        for kind in SWAPPED[type(node.op)]:
            yield ast.unparse(ast.BoolOp(op=kind(), values=node.values))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
        yield ast.unparse(node.operand)
    elif isinstance(node, ast.Constant) and type(node.value) is int:
        yield from (repr(node.value + 1), repr(node.value - 1))
    elif isinstance(node, ast.Constant) and type(node.value) is float:
        yield from (repr(1.1 * node.value), repr(0.5 * node.value)) if node.value else ["0.1"]


def is_text(node: ast.expr) -> bool:
    """Whether an operand is a text."""
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


class Probes(ast.NodeTransformer):
    """A module that notes each statement of its functions that runs, by its line."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        for part in ast.walk(node):
            for name in ("body", "orelse", "finalbody"):
                rows = getattr(part, name, None)
                if isinstance(rows, list) and not is_class(part):
                    setattr(part, name, [one for row in rows for one in (probe(row), row)])
        return node


def probe(row: ast.stmt) -> ast.stmt:
    """The statement that notes another."""
    note = f"__import__('builtins').__dict__.setdefault({PROBED!r}, set()).add({row.lineno})"
    return ast.parse(note).body[0]


def probed(source: str) -> str:
    """A module with probes; the text of its docstrings comes before them, where doctests are."""
    tree = Probes().visit(ast.parse(source))
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and len(node.body) > 1:
            text = node.body[1]
            if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
                node.body[:2] = node.body[1::-1]
    return ast.unparse(ast.fix_missing_locations(tree))


class Watch:
    """What lines each test reaches, and how long it takes."""

    def __init__(self) -> None:
        self.found: dict[str, tuple[float, list[int]]] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        lines: set[int] = builtins.__dict__.setdefault(PROBED, set())
        lines.clear()
        began = time.perf_counter()
        answer = yield
        if lines:
            self.found[item.nodeid] = (time.perf_counter() - began, sorted(lines))
        return answer


class Choice:
    """Tests by name in a given order; a property is not made smaller where it fell."""

    def __init__(self, names: Sequence[str]) -> None:
        self.order = {name: number for number, name in enumerate(names)}
        self.fell = ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        items[:] = sorted(
            (item for item in items if item.nodeid in self.order),
            key=lambda item: self.order[item.nodeid],
        )
        for item in items:
            if is_hypothesis_test(getattr(item, "obj", None)):
                function = getattr(item.obj, "__func__", item.obj)
                function._hypothesis_internal_use_settings = settings(
                    function._hypothesis_internal_use_settings,
                    phases=(Phase.explicit, Phase.generate),
                    database=None,
                )

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.fell:
            self.fell = report.nodeid


def copy_of_checkout(folder: Path) -> None:
    """What tests need, in a folder."""
    leave = shutil.ignore_patterns("*.pyc", "_build", ".hypothesis")
    for name in COPIED:
        shutil.copytree(ROOT / name, folder / name, ignore=leave)
    for name in FILES:
        shutil.copy2(ROOT / name, folder / name)


def forked(folder: Path, words: Sequence[str], plugin: Any, limit: float) -> tuple[int | None, Any]:
    """Exit code of pytest in a process of its own in a copy, None where it did not end in time, and
    what its plugin found."""
    answer = folder / "answer.json"
    answer.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        code = 3
        try:
            code = _pytest(folder, words, plugin)
            answer.write_text(json.dumps(getattr(plugin, "found", getattr(plugin, "fell", None))))
        finally:
            os._exit(code)
    end = time.monotonic() + limit
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            told = json.loads(answer.read_text()) if answer.exists() else None
            return os.waitstatus_to_exitcode(status), told
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None, None


def _pytest(folder: Path, words: Sequence[str], plugin: Any) -> int:
    os.setsid()
    os.chdir(folder)
    with (folder / "output.txt").open("w") as told:
        for stream in (1, 2):
            os.dup2(told.fileno(), stream)
    sys.path[:] = [str(folder), *(x for x in sys.path if Path(x).resolve() != ROOT)]
    os.environ |= {
        "PYTHONPATH": str(folder),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PMMKIT_CACHE": str(folder / "cache"),
    }
    sys.dont_write_bytecode = True
    for name in [x for x in sys.modules if x.split(".")[0] in ("scripts", "pmmkit", "tests")]:
        del sys.modules[name]
    own = ["-q", "-p", "no:cacheprovider", "--rootdir", str(folder)]
    own += ["-c", str(folder / "pyproject.toml"), "--tb=no", "--no-summary"]
    return int(pytest.main([*own, *words], plugins=[plugin]))


FOLDER: list[Path] = []


def settled(base: Path) -> None:
    """A worker's own copy."""
    folder = base / str(os.getpid())
    copy_of_checkout(folder)
    FOLDER.append(folder)


def reach(job: tuple[str, tuple[str, ...], bool]) -> tuple[str, dict[str, tuple[float, list[int]]]]:
    """What lines of a module each of some tests reaches."""
    module, tests, slow = job
    (folder,) = FOLDER
    source = (ROOT / module).read_text(encoding="utf-8")
    (folder / module).write_text(probed(source), encoding="utf-8")
    marked = [] if slow else ["-m", "not slow"]
    try:
        _, found = forked(folder, [*tests, *marked], Watch(), 3600.0)
    finally:
        (folder / module).write_text(source, encoding="utf-8")
    if not found:
        raise SystemExit(
            f"No test reaches {module}:\n{(folder / 'output.txt').read_text()[-2000:]}"
        )
    return module, found


def tried(job: tuple[Mutant, tuple[str, ...]], limit: float) -> Tried:
    """A change, and whether one of some tests notices it."""
    mutant, names = job
    (folder,) = FOLDER
    if not names:
        return Tried(mutant=mutant, outcome="unreached", tests=0, seconds=0.0)
    place = folder / mutant.module
    source = place.read_text(encoding="utf-8")
    began = time.perf_counter()
    place.write_text(mutant.applied(source), encoding="utf-8")
    try:
        files = dict.fromkeys(name.split("::")[0] for name in names)
        code, by = forked(folder, ["-x", *files], Choice(names), limit)
    finally:
        place.write_text(source, encoding="utf-8")
    outcome = "time-out" if code is None else "survived" if code == 0 else "killed"
    return Tried(
        mutant=mutant,
        outcome=outcome,
        tests=len(names),
        seconds=time.perf_counter() - began,
        by=(by or "nothing is imported") if outcome == "killed" else "",
    )


def chosen(
    mutant: Mutant, reached: dict[str, tuple[float, list[int]]], budget: float
) -> tuple[str, ...]:
    """Tests that reach a change, the quickest first, up to a sum of seconds; one at least."""
    names, spent = [], 0.0
    for name, (seconds, lines) in sorted(reached.items(), key=lambda item: item[1][0]):
        if mutant.statement == NEVER or mutant.statement in lines:
            spent += seconds
            if names and spent > budget:
                break
            names.append(name)
    return tuple(names)


def room_of(module: str) -> tuple[str, ...]:
    """Examples of a module and the tests of its room."""
    return module, f"tests/{Path(module).parts[1].removesuffix('.py')}"


def table(found: Sequence[Tried]) -> Iterator[str]:
    """What came of the changes of a module, in lines."""
    for item in sorted(found, key=lambda item: item.mutant.line):
        by = f"  ({item.by})" if item.by else ""
        yield f"{item.outcome:9s} {item.seconds:6.1f} s {item.tests:4d}  {item.mutant.words()}{by}"
    counts = Counter(item.outcome for item in found)
    mean = sum(item.seconds for item in found) / max(len(found), 1)
    yield (
        f"{len(found)} changes: "
        + ", ".join(f"{count} {name}" for name, count in counts.items())
        + f"; {mean:.1f} s each"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--modules", nargs="+", default=list(MODULES), help="paths of modules")
    parser.add_argument("--each", type=int, default=42, help="changes of a module")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--tests", nargs="+", help="in place of those of the module's room")
    parser.add_argument("--slow", action="store_true", help="tests marked slow too")
    parser.add_argument("--budget", type=float, default=60.0, help="seconds of tests of a change")
    parser.add_argument("--limit-seconds", type=float, default=300.0, help="of a change")
    parser.add_argument("--workers", "--jobs", type=int, default=2, help="processes")
    parser.add_argument("--out", type=Path, default=Path("survivors.json"), help="of survivors")
    parser.add_argument("--only", type=Path, help="changes of such a file")
    o = parser.parse_args()
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    for name in WARM:
        import_module(name)
    if o.only:
        drawn = [Mutant(**item) for item in json.loads(o.only.read_text())]
    else:
        drawn = []
        for module in o.modules:
            every = list(mutants(module, (ROOT / module).read_text(encoding="utf-8")))
            random.Random(f"{o.seed} {module}").shuffle(every)
            drawn += every[: o.each]
    modules = list(dict.fromkeys(item.module for item in drawn))
    began, found = time.perf_counter(), []
    with (
        tempfile.TemporaryDirectory() as base,
        ProcessPoolExecutor(
            o.workers, multiprocessing.get_context("fork"), settled, (Path(base),)
        ) as pool,
    ):
        jobs = [(module, tuple(o.tests or room_of(module)), o.slow) for module in modules]
        reached = dict(pool.map(reach, jobs))
        print(f"{time.perf_counter() - began:.0f} s to see what tests reach", flush=True)
        work = [(item, chosen(item, reached[item.module], o.budget)) for item in drawn]
        every_tried = pool.map(partial(tried, limit=o.limit_seconds), work)
        for module in modules:
            own = [next(every_tried) for item in drawn if item.module == module]
            found += own
            print(f"\n{module}, {len(reached[module])} tests", *table(own), sep="\n", flush=True)
    left = [item.mutant for item in found if item.outcome in ("survived", "unreached")]
    o.out.write_text(json.dumps([asdict(item) for item in left], indent=1))
    print(f"\n{time.perf_counter() - began:.0f} s; {len(left)} in {o.out}; --seed {o.seed}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
