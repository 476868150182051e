"""Files appear whole or not at all."""

from __future__ import annotations

import hashlib
import json
import os
import sys
import threading
import time
from pathlib import Path

import pandas as pd
import pytest

from pmmkit.base import DataError, FileExists
from pmmkit.files import (
    atomic_folder,
    atomic_path,
    datasets_folder,
    sha256,
    write_results,
    write_text,
)


def test_the_file_appears_only_when_the_block_has_ended(tmp_path: Path) -> None:
    target = tmp_path / "new" / "folder" / "a.csv"
    with atomic_path(target) as part:
        part.write_text("half")
        assert not target.exists()
        assert part.suffix == ".csv"
        part.write_text("whole")
    assert target.read_text() == "whole"
    assert os.listdir(target.parent) == ["a.csv"]


@pytest.mark.parametrize("fault", [ValueError, KeyboardInterrupt, SystemExit])
def test_an_interrupted_block_leaves_the_old_file_and_nothing_else(tmp_path: Path, fault) -> None:
    target = tmp_path / "a.csv"
    target.write_text("old")
    with pytest.raises(fault), atomic_path(target) as part:  # noqa: PT012
        part.write_text("half of the n")
        raise fault
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.csv"]


def test_a_block_that_writes_nothing_makes_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "a.csv"):
        pass
    assert os.listdir(tmp_path) == []


def test_a_reader_sees_one_content_or_the_other(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    contents = {"a" * 200_000, "b" * 200_000}
    write_text(target, "a" * 200_000)
    done = threading.Event()

    def write() -> None:
        for number in range(60):
            write_text(target, "ab"[number % 2] * 200_000)
        done.set()

    writer = threading.Thread(target=write)
    writer.start()
    seen = set()
    while not done.is_set():
        seen.add(target.read_text())
    writer.join()
    assert seen <= contents


def test_several_writers_of_one_file_do_not_meet(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    texts = [str(number) * 50_000 for number in range(8)]
    writers = [threading.Thread(target=write_text, args=(target, text)) for text in texts]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert target.read_text() in texts
    assert os.listdir(tmp_path) == ["a.txt"]


def test_names_as_long_as_the_file_system_allows(tmp_path: Path) -> None:
    target = tmp_path / ("n" * 251 + ".csv")
    write_text(target, "x")
    assert target.read_text() == "x"


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights on Windows")
def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link = tmp_path / "link.txt"
    link.symlink_to(tmp_path / "there" / "a.txt")
    write_text(link, "x")
    assert link.is_symlink()
    assert (tmp_path / "there" / "a.txt").read_text() == "x"


def test_text_is_utf8_with_unix_line_ends(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "ψ\n½\n")
    assert (tmp_path / "a.txt").read_bytes() == b"\xcf\x88\n\xc2\xbd\n"


def test_hash_of_a_file_is_the_published_one(tmp_path: Path) -> None:
    """FIPS 180-2, appendix B.1: the hash of ``abc``."""
    (tmp_path / "a").write_bytes(b"abc")
    expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert sha256(tmp_path / "a") == expected
    (tmp_path / "b").write_bytes(b"x" * 3_000_001)
    assert sha256(tmp_path / "b") == hashlib.sha256(b"x" * 3_000_001).hexdigest()


def test_a_folder_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "results"
    with atomic_folder(target) as part:
        (part / "a.csv").write_text("a")
        (part / "b.csv").write_text("b")
        assert not target.exists()
    assert sorted(os.listdir(target)) == ["a.csv", "b.csv"]
    assert os.listdir(tmp_path) == ["results"]


def test_a_folder_that_fails_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), atomic_folder(tmp_path / "results") as part:  # noqa: PT012
        (part / "a.csv").write_text("a")
        raise KeyboardInterrupt
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("atomic", [atomic_folder, atomic_path])
def test_an_error_names_what_was_to_be_written_and_no_hidden_place(atomic, tmp_path: Path) -> None:
    target = tmp_path / "results"
    with pytest.raises(OSError, match="No space") as plain, atomic(target) as part:
        raise OSError(28, "No space left on device", str(part / "a.csv"))
    assert plain.value.filename == str(target / "a.csv")
    with pytest.raises(DataError) as told, atomic(target) as part:
        raise DataError("cannot be written.", file=str(part / "a.csv"))
    assert str(told.value) == f"{target / 'a.csv'}: cannot be written."


def test_results_join_a_folder_and_leave_its_other_files(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "a.csv").write_text("old")
    with atomic_folder(tmp_path) as part:
        (part / "a.csv").write_text("new")
    assert (tmp_path / "a.csv").read_text() == "new"
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_what_a_stopped_program_left_a_week_ago_goes_and_nothing_else(tmp_path: Path) -> None:
    old = time.time() - 8 * 86400
    left = [tmp_path / ".results-0123456789ab.part", tmp_path / ".0123456789ab.part.toml"]
    kept = [tmp_path / name for name in (".notes.part", ".results-0123456789ab.parts", "a.part")]
    fresh = tmp_path / ".results-ba9876543210.part"
    for folder in (left[0], fresh):
        folder.mkdir()
        (folder / "half.csv").write_text("t,")
    for file in (left[1], *kept):
        file.write_text("half")
    for path in (*left, *kept):
        os.utime(path, (old, old))
    with atomic_folder(tmp_path / "results") as part:
        (part / "note.txt").write_text("all of it")
    assert sorted(tmp_path.iterdir()) == sorted([*kept, fresh, tmp_path / "results"])


def test_results_are_written_by_what_they_are(tmp_path: Path) -> None:
    results = [
        ("table.csv", pd.DataFrame({"a": [1.5], "b": ["x"]}, index=[7])),
        ("text.csv", "t,x\r\n"),
        ("numbers.json", {"nothing": float("nan"), "both": (1, 2)}),
        ("own.bin", lambda path: path.write_bytes(b"\x00")),
    ]
    names = write_results(tmp_path / "out", results)
    assert names == ["numbers.json", "own.bin", "table.csv", "text.csv"]
    found = {name: (tmp_path / "out" / name).read_bytes() for name in names}
    assert found["table.csv"].split() == [b"a,b", b"1.5,x"]
    assert found["text.csv"] == b"t,x\r\n"
    assert json.loads(found["numbers.json"]) == {"nothing": None, "both": [1, 2]}
    assert found["own.bin"] == b"\x00"


def test_results_that_cannot_be_made_leave_nothing(tmp_path: Path) -> None:
    def results():
        yield "first.txt", "whole"
        raise ValueError("the second cannot be made")

    with pytest.raises(ValueError, match="second"):
        write_results(tmp_path / "out", results())
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("in the way")
    with pytest.raises(FileExists, match="results"), atomic_folder(tmp_path / "results"):
        raise AssertionError
    assert (tmp_path / "results").read_text() == "in the way"


def test_the_datasets_are_where_the_package_says() -> None:
    assert datasets_folder().name == "datasets"
