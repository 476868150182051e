"""The application: one file a command, and what its options offer."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
import typer

from pmmkit.actions import Outcome, action, jobs, shared
from pmmkit.actions.jobs import convert, export, identify
from pmmkit.base import ONE_THREAD
from pmmkit.cli import app, main
from pmmkit.exports import ENDINGS
from pmmkit.identification.methods import METHODS
from pmmkit.models import write_table
from pmmkit.simulation import MANOEUVRES

NAMES = sorted(file.stem for file in Path(jobs.__path__[0]).glob("*.py") if file.stem != "__init__")


def group():
    return typer.main.get_command(app.application())


def test_every_file_is_a_command_with_help_and_json():
    found = group().commands
    assert sorted(found) == sorted(name.replace("_", "-") for name in NAMES)
    for command in found.values():
        assert command.help
        assert [item.opts for item in command.params][-1] == ["--json"]


def test_a_command_that_is_asked_for_is_loaded_alone():
    found = typer.main.get_command(app.application("new-campaign"))
    assert list(found.commands) == ["new-campaign"]
    assert len(typer.main.get_command(app.application("new_campaign")).commands) == len(NAMES)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_option_is_without_words(name):
    command = group().commands[name.replace("_", "-")]
    assert all(item.help for item in command.params)


def test_the_status_of_an_outcome_is_that_of_the_command(monkeypatch, capsys):
    outcome = Outcome(content={"errors": 2}, lines=["two errors"], status=1)
    own = replace(action("ships"), do=lambda _: outcome)
    monkeypatch.setattr("pmmkit.cli.app.action", lambda _: own)
    assert main(["ships"]) == 1
    assert capsys.readouterr().out == "two errors\n"
    assert main(["ships", "--json"]) == 1
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ('{\n  "errors": 2\n}\n', "two errors\n")


TYPED = """
import sys
sys.argv = ["pmmkit", "ships", "--quiet"]
from pmmkit.cli import main
main()
import numpy, os
from threadpoolctl import threadpool_info
print(os.environ["OPENBLAS_NUM_THREADS"], *(x["num_threads"] for x in threadpool_info()))
"""


@pytest.mark.parametrize("asked", [None, "3"])
def test_a_typed_command_factors_its_small_matrices_with_one_thread(asked):
    """Two that wait for each other take a hundred times as long where another program works; who
    asks for more gets them."""
    own = {name: x for name, x in os.environ.items() if name not in ONE_THREAD}
    if asked:
        own |= dict.fromkeys(ONE_THREAD, asked)
    done = subprocess.run(
        [sys.executable, "-c", TYPED], env=own, capture_output=True, text=True, check=True
    )
    told, *threads = done.stdout.splitlines()[-1].split()
    assert told == (asked or "1")
    assert asked or set(threads) == {"1"}


def test_what_an_option_offers_is_what_there_is(tmp_path):
    assert set(get_args(identify.Method)) == {*METHODS, "all"}
    assert set(get_args(export.Format)) == set(ENDINGS)
    offered = shared.Manoeuvre.__metadata__[0].text
    named = offered.rstrip(".").replace(" or ", ", ").split(", ")
    assert set(named) == set(MANOEUVRES)
    endings = {f".{item}" for item in get_args(convert.Format)}
    told = inspect.getdoc(write_table)
    assert all(f"``{ending}``" in told for ending in endings)
