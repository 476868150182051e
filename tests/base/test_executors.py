"""Where work runs: the same results wherever, and nothing lost when a worker is."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import current_process, get_context
from types import MappingProxyType

import numpy as np
import pytest

from pmmkit.base import DataError, each, opened
from pmmkit.base.executors import places, worker

HERE = os.getpid()


def called(things):
    return [f"thing {k}" for k in range(len(things))]


def outcomes(work, things, executor, **how):
    return dict(each(work, things, executor, names=called(things), **how))


def wave(k):
    """Something that has digits to lose, in a mapping that pickle alone does not take."""
    return MappingProxyType({"sum": float(np.sum(np.sin(np.arange(1000.0) * k)))})


@pytest.mark.slow
def test_the_same_to_the_bit_in_the_order_of_places_wherever_it_runs():
    things = list(range(40))
    alone = outcomes(wave, things, None)
    assert list(alone) == things
    with (
        ThreadPoolExecutor(3) as threads,
        ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes,
    ):
        for executor in (1, 2, threads, processes):
            assert outcomes(wave, things, executor) == alone


def test_nothing_to_do_starts_nothing(monkeypatch):
    monkeypatch.setattr("pmmkit.base.executors.board.processes", None)
    assert outcomes(wave, [], 4) == {}
    assert outcomes(wave, [3], 1) == outcomes(wave, [3], None)


def ends_but_here(marked):
    """Ends the process over what is marked, as for want of memory; not the one of the test."""
    if marked < 0:
        os._exit(9)
    return marked**2


@pytest.mark.slow
def test_what_ends_every_process_is_named_and_nothing_else_is_blamed():
    things, found = [3, 1, -4, 1, 5, 9, 2, 6], {}
    outcomes_of = each(ends_but_here, things, 2, names=called(things))
    with pytest.raises(DataError, match=r"thing 2 ended 3 times.*executor=1"):
        found.update(outcomes_of)
    assert 2 not in found
    assert all(result == things[place] ** 2 for place, result in found.items())


@pytest.mark.slow
def test_a_process_killed_half_way_loses_nothing(tmp_path):
    """The file is there once: who finds it ends its process."""
    fuse = tmp_path / "fuse"
    fuse.touch()

    def work(k):
        if k == 5:
            try:
                fuse.unlink()
            except FileNotFoundError:
                return k
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        return k

    assert sorted(outcomes(work, range(12), 2)) == list(range(12))
    assert not fuse.exists()


@pytest.mark.slow
def test_an_executor_that_breaks_or_is_closed_is_replaced_by_processes_of_this_machine(tmp_path):
    fuse = tmp_path / "fuse"
    fuse.touch()

    def work(k):
        if k == 3 and fuse.exists():
            fuse.unlink()
            os._exit(1)
        return -k

    expected = {k: -k for k in range(6)}
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as broken:
        assert outcomes(work, range(6), broken) == expected
    assert outcomes(work, range(6), broken) == expected


@pytest.mark.slow
def test_a_machine_that_starts_no_process_does_it_in_this_one(monkeypatch):
    monkeypatch.setattr(places, "starts", lambda made: False)
    assert outcomes(lambda k: os.getpid(), range(3), 2) == dict.fromkeys(range(3), HERE)


def test_a_process_that_may_have_none_below_it_does_it_itself(monkeypatch):
    """Such as that of the workbench for long work, which ends with the server."""
    monkeypatch.setitem(current_process()._config, "daemon", True)
    assert set(outcomes(lambda _: os.getpid(), [0, 1, 2], 2).values()) == {HERE}
    with places.opened(2, rounds=True) as crew:
        assert crew is None


def test_what_lives_in_this_process_only_is_done_here():
    lock = threading.Lock()
    with ThreadPoolExecutor(2) as threads:
        found = outcomes(lambda thing: thing is lock, [1, lock, 2], threads)
        assert found == {0: False, 1: True, 2: False}
        assert outcomes(lambda k: lock.locked() or k, [1, 2], threads) == {0: 1, 1: 2}


def test_a_file_that_only_some_see_is_read_here(tmp_path):
    (tmp_path / "seen").write_text("12")

    def read(name):
        if threading.current_thread() is not threading.main_thread() and name == "seen":
            raise FileNotFoundError(name)
        return name

    with ThreadPoolExecutor(1) as threads:
        assert outcomes(read, ["a", "seen", "b"], threads) == {0: "a", 1: "seen", 2: "b"}


def test_workers_that_see_nothing_are_told_of_with_what_to_do():
    def read(name):
        if threading.current_thread() is not threading.main_thread():
            raise FileNotFoundError(f"no such file: {name}")
        return name

    with (
        ThreadPoolExecutor(2) as threads,
        pytest.raises(DataError, match=r"No worker could .* no such file: .* same path"),
    ):
        outcomes(read, ["runs/a.csv"] * 9, threads)


def test_what_is_wrong_everywhere_is_raised_as_it_is_here():
    def read(k):
        if k == 2:
            raise LookupError("no column Y")
        return k

    with ThreadPoolExecutor(2) as threads:
        with pytest.raises(LookupError, match="no column Y"):
            outcomes(read, range(4), threads)
        told = outcomes(read, range(2, 9), threads, here=lambda k: ValueError(str(k)))
    assert isinstance(told[0], ValueError)
    assert [told[k] for k in range(1, 7)] == list(range(3, 9))


def test_another_version_of_pmmkit_does_nothing(monkeypatch):
    monkeypatch.setattr(
        worker, "done", lambda *given, done=worker.done: done(*given[:2], "0.0.0", 0)
    )
    with ThreadPoolExecutor(1) as threads, pytest.raises(DataError, match=r"0\.0\.0 is asked for"):
        outcomes(abs, range(9), threads)


def test_memory_of_what_is_under_way_is_held_down():
    """No more than there is, but for what needs more than that, which goes alone."""
    needs = [60.0, 30.0, 500.0, 45.0, 10.0] * 8

    def take(k):
        begin = time.monotonic()
        time.sleep(0.004)
        return begin, time.monotonic()

    with ThreadPoolExecutor(8) as threads:
        found = outcomes(take, range(40), threads, needs=needs, room=100.0)
    together = [
        [needs[other] for other, (begin, end) in found.items() if begin <= now < end]
        for now, _ in found.values()
    ]
    assert len(found) == 40
    assert all(sum(held) <= 100.0 or held == [500.0] for held in together)
    assert any(len(held) > 1 for held in together)


@pytest.mark.parametrize("count", [0, -2])
def test_less_than_one_process_is_refused(count):
    with pytest.raises(DataError, match="at least one"), opened(count):
        pass


def test_without_dask_a_scheduler_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    needed = r"pip install 'pmmkit\[distributed\]'"
    with pytest.raises(DataError, match=needed), opened("tcp://127.0.0.1:8786"):
        pass


@pytest.mark.parametrize("asked", ["tcp://127.0.0.1:{port}", "nowhere", "http://127.0.0.1:1"])
def test_where_no_scheduler_listens_that_is_told_with_what_to_do(asked):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    threads = threading.active_count()
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        address = asked.format(port=silent.getsockname()[1])
        answers = r"No dask scheduler answers .* dask worker ADDRESS"
        with pytest.raises(DataError, match=answers), opened(address):
            pass
    assert threading.active_count() == threads
