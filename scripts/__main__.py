"""Sets everything up, then runs: ``python -m scripts demo`` and ``python -m scripts test``."""

import os
import subprocess
import sys
import time

from scripts.set_up import environment

# Each worker of the tests has a core; threads of its linear algebra would take it from the others.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
USAGE = """\
python -m scripts demo [options of pmmkit demo]    set up, reduce the S175 tests, turn the ship
python -m scripts test [options of pytest]         set up, check format, types and rooms, run tests
On Windows write py instead of python."""


def demo(options):
    """Set up and run the demonstration."""
    environment.ensure()
    return subprocess.call([environment.program("pmmkit"), "demo", *options], cwd=environment.ROOT)


def test(options):
    """Set up, then run every check; all of them run, and all that fail are named."""
    environment.ensure(development=True)
    steps = {
        "format": ["ruff", "format", "--check", "."],
        "lint": ["ruff", "check", "."],
        "types": ["mypy"],
        "rooms": ["lint-imports"],
        "tests": ["pytest", "-n", "auto", *options],
    }
    failed = []
    for name, (tool, *arguments) in steps.items():
        environment.say(f"== {name}: {tool} {' '.join(arguments)}")
        started = time.monotonic()
        command = [environment.program(tool), *arguments]
        if subprocess.call(command, cwd=environment.ROOT, env=ONE_THREAD | os.environ):
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
    commands = {"demo": demo, "test": test}
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
