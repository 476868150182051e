"""What the tests of containers share: reading a file whole, damaging it, a campaign around it."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pmmkit import open_campaign
from pmmkit.base import PmmkitError
from pmmkit.readers import Columns, Options, Request, reader_for
from scripts.datasets.campaign_text import S175

CHANNELS = ("t", "X", "Y", "N")


def request_of(path: Path, **options: Any) -> Request:
    return Request(path=path, shown=path.name, options=Options(**options))


def read(path: Path, *wanted: str, **options: Any) -> Columns:
    """Columns by their headers, all of them if none is named."""
    request = request_of(path, **options)

    def choose(headers: tuple[str, ...], count: int) -> list[int]:
        if set(wanted) - set(headers):
            raise request.error(f"not all of {wanted} are among {headers}")
        return [headers.index(name) for name in wanted or headers]

    return reader_for(request).columns(request, choose)


def values(path: Path, *wanted: str, **options: Any) -> dict[str, np.ndarray]:
    found = read(path, *wanted, **options)
    return dict(zip((found.headers[place] for place in found.positions), found.values, strict=True))


def headers(path: Path, **options: Any) -> tuple[str, ...]:
    request = request_of(path, **options)
    return reader_for(request).names(request)


def cells(path: Path, **options: Any):
    request = request_of(path, **options)
    return reader_for(request).cells(request)


def series(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Time every 20 ms and three random forces."""
    rng = np.random.default_rng(seed)
    return {"t": np.arange(count) * 0.02, **{name: rng.normal(size=count) for name in "XYN"}}


def damaged_versions(whole: bytes, count: int, seed: int) -> Iterator[bytes]:
    """Cut anywhere, a bit flipped, some bytes at random, a stretch of zeros or ones."""
    rng = np.random.default_rng(seed)
    for kind in rng.integers(0, 4, count):
        data = bytearray(whole)
        place = int(rng.integers(0, len(data)))
        if kind == 0:
            yield bytes(data[:place])
            continue
        if kind == 1:
            data[place] ^= 1 << int(rng.integers(0, 8))
        elif kind == 2:
            for each in rng.integers(0, len(data), 4):
                data[each] = int(rng.integers(0, 256))
        else:
            end = min(len(data), place + int(rng.choice([4, 8, 16])))
            data[place:end] = bytes([int(rng.choice([0, 255]))]) * (end - place)
        yield bytes(data)


def check_damage(path: Path, wanted: tuple[str, ...], count: int, seed: int = 0) -> int:
    """Read damaged versions of a file: an error of ours, or columns of the right shape.

    At most 16 values may be others than before: a damage of up to 16 bytes in plain numbers cannot
    be noticed. Returns how many versions were refused.
    """
    whole = path.read_bytes()
    right = values(path, *wanted)
    refused = 0
    for data in damaged_versions(whole, count, seed):
        path.write_bytes(data)
        try:
            found = values(path, *wanted)
        except PmmkitError:
            refused += 1
            continue
        changed = 0
        for name in wanted:
            assert found[name].shape == right[name].shape
            changed += int(np.sum(found[name] != right[name]))
        assert changed <= 16
    path.write_bytes(whole)
    return refused


@contextmanager
def little_memory(most: int = 32_000_000) -> Iterator[None]:
    """Fail if Python allocates more than so many bytes at once inside."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


def as_matlab(path: Path, write: Callable[[h5py.File], None]) -> Path:
    """An HDF5 file as MATLAB 7.3 writes them: a block of 512 bytes before it."""
    with h5py.File(path, "w", userblock_size=512, libver="earliest") as file:
        write(file)
    with path.open("r+b") as stream:
        text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024"
        stream.write(text.ljust(116) + bytes(8) + b"\x00\x02IM")
    return path


def matlab_dataset(group: h5py.Group, name: str, array: Any, kind: str = "double", **how: Any):
    """A variable as MATLAB lays it out: transposed, with its class."""
    dataset = group.create_dataset(name, data=np.asarray(array).T, **how)
    dataset.attrs["MATLAB_class"] = np.bytes_(kind)
    return dataset


def matlab_text(group: h5py.Group, name: str, text: str) -> h5py.Dataset:
    letters = np.array([[ord(letter) for letter in text]], dtype=np.uint16)
    dataset = matlab_dataset(group, name, letters, "char")
    dataset.attrs["MATLAB_int_decode"] = np.int32(2)
    return dataset


def matlab_cell(file: h5py.File, group: h5py.Group, name: str, texts: list[str]) -> None:
    store = file.require_group("#refs#")
    references = [
        matlab_text(store, f"{name}{place}", text).ref for place, text in enumerate(texts)
    ]
    dataset = group.create_dataset(
        name, data=np.array([references], dtype=h5py.ref_dtype), dtype=h5py.ref_dtype
    )
    dataset.attrs["MATLAB_class"] = np.bytes_("cell")


TOML = (
    """[campaign]
title = "container"
kind = "captive"
"""
    + S175
)
RUN = """[[runs]]
id = "SD"
test = "static_drift"
file = "{file}"
speed = 1.5
drift_deg = 8.0
"""


def run_of(path: Path, top: str = "", toml: str = RUN):
    """The data of the one run of a campaign around a file."""
    text = TOML + top + toml.format(file=path.name)
    (path.parent / "campaign.toml").write_text(text, encoding="utf-8")
    (run,) = open_campaign(path.parent).runs
    return run.data
