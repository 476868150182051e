"""Large campaigns: several processes, interruption, going on; the same result to the bit."""

from __future__ import annotations

import random
import shutil
import signal
import subprocess
import sys
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.readers import Options, Request
from pmmkit.readers.text import csv as csv_reader
from pmmkit.readers.text import splitting as text
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.reading import all_runs, resume
from scripts.datasets.make_large import make
from scripts.studies.kill_test import content, examine

RUNS = 16


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("campaign")
    make(place, runs=RUNS, mb=0.03)
    return place


@pytest.fixture(scope="module")
def undisturbed(folder):
    return everything(reduced(folder, executor=1))


@pytest.fixture
def at_once(monkeypatch):
    """Results are kept and processes started from the first run on."""
    monkeypatch.setattr(all_runs, "PATIENCE", 0.0)
    monkeypatch.setattr(all_runs, "PAYS", 0.0)


def reduced(folder, **options):
    return reduce_campaign(pk.open_campaign(folder), structure="cubic", **options)


def everything(found):
    """All numbers of a reduction, to the bit."""
    tables = [found.table, *found.families.values(), *found.single_runs.values()]
    numbers = [part.tobytes() for item in tables for part in (item.value, item.covariance)]
    return numbers, found.runs_to_pandas().to_csv(), [str(item) for item in found.findings]


class Stop(Exception):
    """Stands for Ctrl-C."""


def stopped_after(folder, kept, runs):
    """Reduce and stop when so many runs are read."""

    def progress(done, total, what):
        if done == runs:
            raise Stop

    with pytest.raises(Stop):
        reduced(folder, executor=1, resume=kept, progress=progress)


@pytest.mark.slow
@pytest.mark.parametrize("threads", [2, 4])
def test_several_threads_of_the_linear_algebra_give_the_same_to_the_bit(
    folder, undisturbed, threads
):
    with threadpool_limits(threads):
        assert everything(reduced(folder, executor=1)) == undisturbed


def test_several_processes_give_the_same_to_the_bit(folder, undisturbed, at_once, monkeypatch):
    read = []
    read_run = all_runs.read_run
    monkeypatch.setattr(
        all_runs, "_result", lambda run, settings: read.append(run) or read_run(run, settings)
    )
    assert everything(reduced(folder, executor=2)) == undisturbed
    assert len(read) == 1


@pytest.mark.slow
def test_problems_of_all_runs_come_back_from_the_workers(folder, tmp_path, at_once):
    """They are packed for threads as they are for processes."""
    place = shutil.copytree(folder, tmp_path / "damaged")
    for number in (2, 7):
        file = next((place / "runs").glob(f"*_{number:04d}.csv"))
        file.write_bytes(file.read_bytes()[:-300] + b"1,2,x,4,5,6,7,8,9\n")
    with ThreadPoolExecutor(2) as threads, pytest.raises(CampaignError) as caught:
        reduced(place, executor=threads)
    found = [problem.run for problem in caught.value.problems]
    assert found == ["static_drift_0002", "pure_sway_0007"]


@pytest.mark.slow
def test_runs_that_live_in_memory_only_are_read_as_well(folder, undisturbed, at_once):
    campaign = pk.open_campaign(folder)
    runs = tuple(run.with_(loader=lambda data=run.data: data) for run in campaign.runs)
    assert (
        everything(reduce_campaign(campaign.with_(runs=runs), structure="cubic"))[0]
        == undisturbed[0]
    )


@pytest.mark.slow
def test_an_interrupted_reduction_goes_on(folder, undisturbed, at_once, tmp_path, monkeypatch):
    kept = tmp_path / "kept"
    stopped_after(folder, kept, 10)
    assert len(list(kept.iterdir())) == 10
    told, read = [], []
    read_run = all_runs.read_run
    monkeypatch.setattr(
        all_runs, "read_run", lambda run, settings: read.append(run) or read_run(run, settings)
    )
    found = reduced(folder, executor=1, resume=kept, progress=lambda *said: told.append(said))
    assert told[0] == (10, RUNS, "resumed: 10 of 16 runs were read before")
    assert len(read) == RUNS - 10
    assert everything(found) == undisturbed
    assert everything(reduced(folder, executor=1, resume=kept)) == undisturbed


@pytest.mark.slow
def test_damaged_results_and_those_of_other_content_are_read_anew(
    folder, undisturbed, at_once, tmp_path
):
    place = shutil.copytree(folder, tmp_path / "campaign")
    kept = tmp_path / "kept"
    stopped_after(place, kept, 1)
    first = set(kept.iterdir())
    stopped_after(place, kept, 8)
    files = sorted(set(kept.iterdir()) - first)
    files[0].write_bytes(b"")
    files[1].write_bytes(files[1].read_bytes()[:-100])
    files[2].write_bytes(files[3].read_bytes())
    files[4].write_bytes(files[4].read_bytes().replace(b'"samples":', b'"sampled":'))
    changed = place / "runs/static_drift_0000.csv"
    raw = changed.read_bytes()
    changed.write_bytes(raw[: len(raw) // 2].rsplit(b"\n", 1)[0] + b"\n")
    told = []
    found = reduced(place, executor=1, resume=kept, progress=lambda *said: told.append(said))
    assert told[0][0] == 8 - 5
    assert found.runs[0].samples != reduced(folder, executor=1).runs[0].samples
    changed.write_bytes(raw)
    assert everything(reduced(place, executor=1, resume=kept)) == undisturbed


@pytest.mark.slow
def test_another_request_takes_nothing_up(folder, at_once, tmp_path):
    stopped_after(folder, tmp_path / "kept", 5)
    told = []
    reduced(
        folder,
        executor=1,
        resume=tmp_path / "kept",
        carriage_speed=True,
        progress=lambda *said: told.append(said),
    )
    assert told[0][0] == 1


@pytest.mark.slow
def test_a_small_campaign_leaves_nothing_and_starts_nothing(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(all_runs, "PATIENCE", 60.0)
    monkeypatch.setattr("pmmkit.base.executors.board.processes", None)
    reduced(folder, resume=tmp_path / "kept")
    assert not (tmp_path / "kept").exists()


SLOWLY = """
import os
import sys
from pathlib import Path

import pmmkit as pk
from pmmkit.base.executors import places
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.reading import all_runs

all_runs.PATIENCE = all_runs.PAYS = 0.0
starts = places.starts


def tell(made):
    begun = starts(made)
    print(*made._processes, flush=True)
    return begun


places.starts = tell
kept = Path(sys.argv[2])
reduce_campaign(pk.open_campaign(sys.argv[1]), structure="cubic", executor=2, resume=kept)
"""
"""Reads with two processes and tells which they are."""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_a_killed_command_leaves_no_process_and_goes_on(folder, tmp_path, undisturbed):
    kept = tmp_path / "kept"
    command = [sys.executable, "-c", SLOWLY, str(folder), str(kept)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        pids = process.stdout.readline().split()
        until(lambda: len(list(kept.glob("*.json"))) > 3)
        process.kill()
    until(lambda: not any(_lives(pid) for pid in pids))
    assert everything(reduced(folder, executor=1, resume=kept)) == undisturbed


def _lives(pid):
    stat = Path(f"/proc/{pid}/stat")
    try:
        return stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def until(true, seconds=20.0):
    """Wait for something, not for ever."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


SAVING = """
import sys
import pmmkit as pk
from pmmkit.campaigns import save_campaign

for place in sys.argv[2:]:
    print(flush=True)
    save_campaign(pk.open_campaign(sys.argv[1]), place)
"""
"""Tells when it begins to save, the second time with all that it needs at hand."""


@pytest.mark.slow
def test_a_file_is_there_whole_or_not_at_all_however_saving_is_killed(tmp_path):
    make(tmp_path / "campaign", runs=4, mb=0.5)
    target = tmp_path / "work" / "saved.h5"
    target.parent.mkdir()

    def save():
        pk.save_campaign(pk.open_campaign(tmp_path / "campaign"), target)

    save()
    started = time.monotonic()
    save()
    usual = time.monotonic() - started
    new = content(target.parent)
    places = [tmp_path / "campaign", tmp_path / "first.h5", target]
    command = [sys.executable, "-c", SAVING, *map(str, places)]
    for share in (0.4, 0.8):
        target.unlink(missing_ok=True)
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            process.stdout.readline()
            process.stdout.readline()
            time.sleep(share * usual)
            process.kill()
        state, strange = examine(content(target.parent), {}, new)
        assert state in ("old", "new")
        assert not strange
    save()
    assert content(target.parent) == new


@pytest.mark.slow
def test_the_command_keeps_beside_its_output_and_clears_away(
    folder, tmp_path, at_once, capsys, monkeypatch
):
    from pmmkit.cli import main

    out = tmp_path / "out"
    kept = resume.resume_folder(out)
    written = []

    def write(found, *_, **__):
        assert len(list(kept.iterdir())) == RUNS
        written.append(found)
        return []

    monkeypatch.setattr("pmmkit.views.report.build.write_reduction", write)
    reduced(folder, executor=1, resume=kept)
    arguments = ["reduce", str(folder), "--structure", "cubic", "--out", str(out), "--jobs", "1"]
    assert main(arguments) == 0
    assert f"resumed: {RUNS} of {RUNS} runs were read before" in capsys.readouterr().err
    assert len(written) == 1
    assert not list(tmp_path.iterdir())


def columns(path, options):
    try:
        read = csv_reader.columns(
            Request(path=path, shown="f.csv", options=options), lambda _, width: range(width)
        )
    except CampaignError as error:
        return sorted(map(str, error.problems))
    return read.headers, read.dropped, [values.tobytes() for values in read.values]


@pytest.mark.slow
def test_a_file_in_pieces_is_the_file_whole(tmp_path):
    """Same numbers, same faults with the same rows, wherever a piece ends."""
    assert [seed for seed in range(60) if not same_in_pieces(tmp_path / "f.csv", seed)] == []


def same_in_pieces(path, seed):
    """Whether a file that a seed makes reads alike whole and in small pieces."""
    rng = random.Random(seed)
    sep, width = rng.choice(",;\t "), rng.randint(2, 5)
    lines = [
        sep.join(f"{rng.uniform(-9, 9):.{rng.randint(1, 6)}f}" for _ in range(width))
        for _ in range(rng.randint(150, 400))
    ]
    if rng.random() < 0.6:
        lines.insert(0, sep.join("abcde"[:width]))
    for _ in range(rng.choice([0, 0, 1, 2])):
        place = rng.randrange(1, len(lines))
        line = lines[place]
        lines[place] = rng.choice(
            ["", line + sep + "1", line[:-3], line.replace(".", "x"), line + "\0", line + "ü"]
        )
    end = rng.choice(["\n", "\r\n", "\r"])
    path.write_bytes(
        (end.join(lines) + rng.choice(["", end, end * 3, end + "  "])).encode("cp1252")
    )
    options = Options(missing=rng.choice(["error", "drop"]), encoding=rng.choice([None, "cp1252"]))
    whole = columns(path, options)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(text, "BLOCK", rng.choice([1500, 2000, 3000]))
        return columns(path, options) == whole


@pytest.mark.slow
def test_a_large_file_is_never_in_memory_whole(tmp_path):
    block = ",".join(["1.234567"] * 40) + "\n"
    path = tmp_path / "wide.csv"
    path.write_text(block * 100_000)
    tracemalloc.start()
    try:
        read = csv_reader.columns(Request(path=path, shown="wide.csv"), lambda *_: [0, 7])
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(read.values[0]) == 100_000
    assert np.all(read.values[1] == 1.234567)
    assert peak < 6 * text.BLOCK < path.stat().st_size


def test_files_side_by_side_need_no_more_than_one(folder, tmp_path):
    make(tmp_path / "flat", runs=1, mb=2.0, form="foam-flat")
    make(tmp_path / "single", runs=1, mb=1.0, width=9)
    flat = pk.open_campaign(tmp_path / "flat").runs[0]
    assert all_runs.size_of(flat) == pytest.approx(1.0e6, rel=0.4)
    alone = all_runs.memory_of(pk.open_campaign(folder).runs[0])
    assert 0.1 < alone < 2.0
    assert all_runs.memory_of(flat) < 12.0


@pytest.mark.slow
def test_histories_are_kept_as_well(folder, at_once, tmp_path):
    kept = tmp_path / "kept"
    first = reduced(folder, executor=1, resume=kept, method="ekf")
    told = []
    second = reduced(
        folder, executor=1, resume=kept, method="ekf", progress=lambda *said: told.append(said)
    )
    assert told[0] == (RUNS, RUNS, f"resumed: {RUNS} of {RUNS} runs were read before")
    assert everything(first) == everything(second)
    assert str(first.estimates["ekf"]) == str(second.estimates["ekf"])
