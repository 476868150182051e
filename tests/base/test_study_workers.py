"""Studies send their work as commands do."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import ModuleType, SimpleNamespace

import pytest

from scripts.studies import workers


def squared(number, *, plus=0):
    return number * number + plus


def options(*given):
    parser = argparse.ArgumentParser()
    workers.add_workers(parser, usual=3)
    return parser.parse_args(given)


def test_options_are_those_of_commands():
    assert options().workers == 3
    assert options("--jobs", "2").workers == options("--workers", "2").workers == 2
    assert options("--scheduler", "tcp://h:1").scheduler == "tcp://h:1"
    with pytest.raises(SystemExit):
        options("--workers", "2", "--scheduler", "tcp://h:1")
    with workers.crew(options("--workers", "1")) as executor:
        assert executor is None


def test_results_stand_in_the_order_of_the_things():
    work = partial(squared, plus=1)
    expected = [k * k + 1 for k in range(20)]
    assert workers.in_order(work, range(20), None) == expected
    with ThreadPoolExecutor(2) as executor:
        assert workers.in_order(work, range(20), executor) == expected
        assert dict(workers.as_done(squared, [3, 4], executor)) == {0: 9, 1: 16}


def test_a_function_of_the_study_that_was_started_is_sent_by_the_name_of_its_module(monkeypatch):
    main = ModuleType("__main__")
    main.__spec__ = SimpleNamespace(name=workers.__name__)
    monkeypatch.setitem(sys.modules, "__main__", main)

    def crew():
        """Stands in the module that was started."""

    crew.__module__ = "__main__"
    assert workers.by_name(crew) is workers.crew
    assert workers.by_name(partial(crew, 1)).func is workers.crew
    assert workers.by_name(squared) is squared
