"""The project's own virtual environment, made from nothing but Python and the package registry.

Standard library only, and readable by every Python 3, so that an old one is told what it lacks.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

OLDEST = (3, 11)
ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / ".venv"
STAMP = FOLDER / "pmmkit-set-up.json"
PROGRAMS = FOLDER / ("Scripts" if os.name == "nt" else "bin")
PYTHON = PROGRAMS / ("python.exe" if os.name == "nt" else "python")
OFFLINE = (
    "name resolution",
    "newconnectionerror",
    "failed to establish",
    "network is unreachable",
    "connection refused",
    "timed out",
    "proxyerror",
    "dns error",
    "could not connect",
    "error sending request",
    "connection error",
    "name or service not known",
)


class SetUpError(Exception):
    """The environment cannot be made; the message says what to do."""


def say(text):
    """One line for the person at the keyboard."""
    print(text, file=sys.stderr, flush=True)


def version(python):
    """Version of a Python as (major, minor); (0, 0) where it does not run."""
    code = "import sys; print(*sys.version_info[:2])"
    try:
        told = subprocess.check_output([str(python), "-c", code], stderr=subprocess.DEVNULL)
        major, minor = told.split()
        return int(major), int(minor)
    except (OSError, ValueError, subprocess.CalledProcessError):
        return 0, 0


def newer_python():
    """The start of a command that runs a Python new enough where this one is not, or None."""
    for minor in range(OLDEST[1] + 8, OLDEST[1] - 1, -1):
        found = shutil.which(f"python3.{minor}")
        if found and version(found) >= OLDEST:
            return [found]
    if shutil.which("uv"):
        return ["uv", "run", "--no-project", "--python", f">={OLDEST[0]}.{OLDEST[1]}", "python"]
    return None


def program(name):
    """Path of a program that the environment holds."""
    return str(PROGRAMS / (name + ".exe" if os.name == "nt" else name))


def ensure(development=False, documentation=False):
    """Make the environment, or bring it up to date; nothing happens where it is.

    Parameters
    ----------
    development : bool
        Whether the tools of the group ``dev`` are needed too.
    documentation : bool
        Whether what builds the documentation site is needed too.

    Raises
    ------
    SetUpError
        If it cannot be made; the message says why.
    """
    done = _stamped()
    current = done.get("fingerprint") == _fingerprint()
    development = development or bool(done.get("development"))
    documentation = documentation or bool(done.get("documentation"))
    wanted = {"development": development, "documentation": documentation}
    if current and all(done.get(name) or not needed for name, needed in wanted.items()):
        return
    started = time.monotonic()
    say(f"Setting up {FOLDER} (once, and when pyproject.toml changes) ...")
    if version(PYTHON) < OLDEST or not _can_install():
        _create()
    if STAMP.exists():
        STAMP.unlink()
    project = f"{ROOT}[docs]" if documentation else str(ROOT)
    _run([*_installer(), "--editable", project, *(_tools() if development else [])])
    stamp = {"fingerprint": _fingerprint(), **wanted}
    STAMP.write_text(json.dumps(stamp), encoding="utf-8")
    say(f"Set up in {time.monotonic() - started:.0f} s.")


def _stamped():
    try:
        return json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def _fingerprint():
    content = (ROOT / "pyproject.toml").read_bytes()
    return hashlib.sha256(f"{ROOT} {version(PYTHON)}".encode() + content).hexdigest()


def _tools():
    import tomllib

    with (ROOT / "pyproject.toml").open("rb") as stream:
        return tomllib.load(stream)["dependency-groups"]["dev"]


def _can_install():
    if shutil.which("uv"):
        return True
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.call([str(PYTHON), "-m", "pip", "--version"], **quiet) == 0


def _create():
    if FOLDER.exists():
        shutil.rmtree(str(FOLDER))
    if shutil.which("uv"):
        _run(["uv", "venv", "--python", sys.executable, str(FOLDER)])
    else:
        _run([sys.executable, "-m", "venv", str(FOLDER)])


def _installer():
    if shutil.which("uv"):
        return ["uv", "pip", "install", "--python", str(PYTHON)]
    return [str(PYTHON), "-m", "pip", "install", "--disable-pip-version-check", "--no-input"]


def _run(command):
    """Run a part of the set-up; its last line is shown on a terminal, all of it on failure."""
    shown = sys.stderr.isatty()
    said = []
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        cwd=str(ROOT),
        encoding="utf-8",
        errors="replace",
    ) as process:
        for line in process.stdout:
            said.append(line.rstrip())
            if shown:
                print(f"\r\033[K{line.strip()[:78]}", end="", file=sys.stderr, flush=True)
    if shown:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    if process.returncode:
        raise SetUpError("\n".join([*said[-15:], _advice("\n".join(said).lower())]))


def _advice(said):
    if "ensurepip is not" in said:
        return (
            "This Python cannot make virtual environments: install the package python3-venv "
            "(Debian, Ubuntu: apt install python3-venv), or uv, and start again."
        )
    if any(sign in said for sign in OFFLINE):
        return (
            "The package registry cannot be reached. The first start needs it: check the network "
            "and the proxy settings (HTTPS_PROXY, PIP_INDEX_URL), and start again."
        )
    return "The set-up failed; what the installer said stands above. Start again once it is mended."
