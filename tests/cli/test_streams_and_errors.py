"""How a command ends when nobody listens, and how much of an error it shows."""

from __future__ import annotations

import io
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from pmmkit.base import DataError, Problem
from pmmkit.cli import main
from pmmkit.cli.output import LINES, WIDEST, tell_error

SHIPS = [sys.executable, "-m", "pmmkit", "ships"]
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="needs a shell of Unix")


def shell(command: str) -> tuple[int, str]:
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stderr


@pytest.mark.slow
@POSIX
@pytest.mark.parametrize(
    ("redirected", "status", "said"),
    [
        (">&-", 0, ""),
        ("2>&- >&- <&-", 0, ""),
        ("--json >&-", 0, None),
        ("| true", 1, ""),
        (">/dev/full", 1, "cannot be written: No space left on device"),
        ("--json >/dev/full", 1, "cannot be written: No space left on device"),
    ],
)
def test_a_closed_or_full_output_is_no_traceback(redirected, status, said):
    if "/dev/full" in redirected and not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    found, errors = shell(f"{' '.join(SHIPS)} {redirected}")
    assert found == status
    assert "Traceback" not in errors
    assert "Exception ignored" not in errors
    if said is not None:
        assert said in errors if said else not errors


@pytest.mark.slow
@POSIX
def test_an_error_with_both_outputs_closed_still_has_its_status():
    status, _ = shell(f"{sys.executable} -m pmmkit stability nothing --speed 1 >&- 2>&-")
    assert status == 1


def test_a_warning_is_one_line_without_the_place_in_the_code(monkeypatch, capsys):
    def ships():
        warnings.warn("Equations are interpreted.", stacklevel=1)
        return ("kvlcc2",)

    monkeypatch.setattr("pmmkit.models.ships", ships)
    assert main(["ships"]) == 0
    assert capsys.readouterr().err == "pmmkit: Equations are interpreted.\n"


def test_an_interrupt_while_output_is_flushed_is_no_traceback(monkeypatch):
    class Interrupted(io.StringIO):
        def flush(self):
            raise KeyboardInterrupt

    monkeypatch.setattr(sys, "stdout", Interrupted())
    assert main(["ships"]) == 130


def test_a_short_error_is_shown_as_it_is(capsys):
    tell_error(DataError(["one", "two"], title="Not read"), as_json=False)
    assert capsys.readouterr().err == "pmmkit: Not read (2 problems):\n  1. one\n  2. two\n"


def test_a_long_error_is_a_screen_and_a_file(capsys):
    problems = [f"row {number} is wrong{' ' + 'x' * 5000 if number == 3 else ''}"
                for number in range(900)]  # fmt: skip
    tell_error(DataError(problems, title="Not read"), as_json=False)
    lines = capsys.readouterr().err.rstrip("\n").split("\n")
    assert len(lines) <= LINES
    assert max(map(len, lines)) <= WIDEST + len("pmmkit: ")
    assert lines[-1].startswith("  … all of it: ")
    file = Path(lines[-1].split(": ", 1)[1])
    assert file.read_text(encoding="utf-8").splitlines()[-1] == "  900. row 899 is wrong"
    if sys.platform != "win32":
        assert file.stat().st_mode & 0o777 == 0o600
    file.unlink()


def test_what_to_do_is_not_cut_off_with_a_long_message(capsys):
    problems = [
        Problem(message=f"{'long ' * 300}{number}", remedy=f"Do {number}.") for number in range(9)
    ]
    tell_error(DataError(problems), as_json=False)
    lines = capsys.readouterr().err.rstrip("\n").split("\n")
    assert [line[-5:] for line in lines[1:-1]] == [f"Do {number}." for number in range(9)]
    Path(lines[-1].split(": ", 1)[1]).unlink()


def test_what_fits_a_screen_is_shown_whole(capsys):
    problems = [f"{'word ' * 100}{number}" for number in range(5)]
    tell_error(DataError(problems), as_json=False)
    assert capsys.readouterr().err == f"pmmkit: {DataError(problems)}\n"


def test_an_error_does_not_steer_the_terminal(capsys):
    tell_error(DataError("column '\x1b]0;gone\x07\x1b[2J\x9b31m'"), as_json=False)
    assert capsys.readouterr().err.rstrip("\n").isprintable()


SHIP = '[ship]\nname = "kvlcc2-l7"\n[water]\nrho = 1000.0\n'
RUN = (
    '[[runs]]\nid = "A"\ntest = "static_drift"\nspeed = {speed}\ndrift_deg = 4.0\nfile = "a.csv"\n'
)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (SHIP.replace("kvlcc2-l7", "box") + "[propeller]\nD = 1e308\n", "propeller.D"),
        (
            '[ship]\nname = "box"\nL = 4.0\nB = 1.0\nd = 0.25\nvolume = 0.5\nIzz = 500.0\n'
            "xG = 1e308\n[water]\nrho = 1000.0\n",
            "ship.xG",
        ),
        (SHIP.replace("1000.0", "1e99"), "water.rho"),
        (SHIP + RUN.format(speed="-1e300"), "runs #1.speed"),
        (SHIP + RUN.format(speed="1" + "0" * 400), "runs #1.speed"),
    ],
)
def test_absurd_numbers_of_a_campaign_are_named_with_their_place(text, place, tmp_path, capsys):
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    (tmp_path / "a.csv").write_text("t,X,Y,N\n0,1,2,3\n", encoding="utf-8")
    assert main(["reduce", str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert f"campaign.toml, {place}: " in said
    assert "absurdly large" in said


DEEP = (f"[trial]\n{'.'.join(['a'] * 3000)} = 1\n", f"[[runs]]\na = {'[' * 200}{']' * 200}\n")


@pytest.mark.parametrize("deep", DEEP, ids=["tables", "lists"])
def test_tables_in_tables_without_end_are_refused(deep, tmp_path, capsys):
    (tmp_path / "campaign.toml").write_text(SHIP + deep, encoding="utf-8")
    assert main(["check", str(tmp_path)]) == 1
    assert "stand inside each other" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["simulate", "stability", "export"])
@pytest.mark.parametrize("key", ["L", "xG", "mass", "rho", "Xuu"])
def test_absurd_numbers_of_a_model_are_named_with_their_place(key, command, tmp_path, capsys):
    import re

    import pmmkit as pk

    pk.save_model(pk.load_model("kvlcc2-l7"), tmp_path / "m.toml")
    text = (tmp_path / "m.toml").read_text(encoding="utf-8")
    changed = re.sub(rf"(?m)^{key} = .*$", f"{key} = 1e308", text, count=1)
    (tmp_path / "m.toml").write_text(changed, encoding="utf-8")
    options = {"export": ["-o", str(tmp_path / "m.py")]}.get(
        command, ["--out", str(tmp_path / "out")]
    )
    assert main([command, str(tmp_path / "m.toml"), "--speed", "1.2", *options]) == 1
    said = capsys.readouterr().err
    assert re.search(rf"m\.toml, [\w.]*\.{key}: 1e\+308 is absurdly large", said)
