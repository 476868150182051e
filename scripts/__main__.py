"""Sets everything up, then runs a command: ``python -m scripts demo``, ``… docs``, ``… test``."""

import os
import subprocess
import sys
import time

from scripts.set_up import environment

# Each worker of the tests has a core; threads of its linear algebra would take it from the others.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
# Very many processes import the same modules: their bytecode is kept whatever the shell says.
KEPT = {"PYTHONDONTWRITEBYTECODE": ""}
CHECKS = {
    "format": ["ruff", "format", "--check", "."],
    "lint": ["ruff", "check", "."],
    "types": ["mypy", "--num-workers", "auto"],
    "rooms": ["lint-imports"],
}
# Slow tests come first (tests/conftest.py), one at a time, so that no worker is left with one.
TESTS = ["pytest", "-n", "auto", "--dist", "loadgroup", "--no-loadscope-reorder"]
FAST = ["-m", "not slow"]
USAGE = """\
python -m scripts demo [options of pmmkit demo]    set up, reduce the S175 tests, turn the ship
python -m scripts test [options of pytest]         set up, check format, types and rooms, run tests
python -m scripts test --fast [options of pytest]  the same without the tests that take long
python -m scripts check [format lint types rooms]  set up, and these checks alone
python -m scripts docs [--without-notebooks]       set up, build the documentation site
On Windows write py instead of python."""


def demo(options):
    """Set up and run the demonstration."""
    environment.ensure()
    return subprocess.call([environment.program("pmmkit"), "demo", *options], cwd=environment.ROOT)


def check(options):
    """Set up, then run the checks that are named, or all."""
    unknown = [name for name in options if name not in CHECKS]
    if unknown:
        environment.say(USAGE)
        return 2
    environment.ensure(development=True)
    return run({name: CHECKS[name] for name in options or CHECKS})


def docs(options):
    """Set up and build the documentation site."""
    environment.ensure(documentation=True)
    command = [str(environment.PYTHON), "-m", "scripts.documentation.site", *options]
    return subprocess.call(command, cwd=environment.ROOT, env=ONE_THREAD | os.environ)


def test(options):
    """Set up, then run every check; all of them run, and all that fail are named."""
    environment.ensure(development=True)
    fast = "--fast" in options
    rest = [option for option in options if option != "--fast"]
    return run({**CHECKS, "tests": [*TESTS, *(FAST if fast else ()), *rest]})


def run(steps):
    """Run steps one after another, with the time of each; 1 if any failed."""
    failed = []
    for name, (tool, *arguments) in steps.items():
        environment.say(f"== {name}: {tool} {' '.join(arguments)}")
        started = time.monotonic()
        command = [environment.program(tool), *arguments]
        if subprocess.call(command, cwd=environment.ROOT, env=ONE_THREAD | os.environ | KEPT):
            failed.append(name)
        environment.say(f"== {name}: {time.monotonic() - started:.1f} s")
    environment.say(f"Failed: {', '.join(failed)}." if failed else "Everything passed.")
    return 1 if failed else 0


def main(arguments):
    """Run one of the commands, in a newer Python where this one is too old."""
    if sys.version_info < environment.OLDEST:
        newer = environment.newer_python()
        if newer:
            command = [*newer, "-m", "scripts", *arguments]
            return subprocess.call(command, cwd=str(environment.ROOT))
        environment.say(
            "pmmkit needs Python 3.11 or newer; this is {}.{}. Install one from "
            "https://www.python.org/downloads or with your package manager, or install uv, "
            "and start again.".format(*sys.version_info)
        )
        return 1
    commands = {"demo": demo, "docs": docs, "check": check, "test": test}
    if not arguments or arguments[0] not in commands:
        environment.say(USAGE)
        return 2
    try:
        return commands[arguments[0]](arguments[1:])
    except environment.SetUpError as error:
        environment.say(str(error))
        return 1
    except KeyboardInterrupt:
        environment.say("Stopped.")
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
