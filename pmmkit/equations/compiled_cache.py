"""Compiled functions kept on disk by numba, each file sealed: what is damaged is compiled again."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile

_SEAL_LENGTH = hashlib.sha256().digest_size


def kept(function: Any) -> Any:
    """A compiled function whose machine code stays beside the file that defines it."""
    found = not_kept(function)
    if hasattr(found, "enable_caching"):
        found._cache = _Cache(function)
    return found


def not_kept(function: Any) -> Any:
    """A compiled function that the next session compiles again."""
    return numba.njit(function, nogil=True, error_model="numpy")


class _Cache(FunctionCache):
    """A cache that never fails: without an entry that can be used numba compiles."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_path = str(Path(function.__code__.co_filename).parent)
        self._cache_file = _SealedFile(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError:
            return
        except RuntimeError as error:
            # LLVM hands its code to a callback; Ctrl-C within it is lost there, and the code too.
            raise KeyboardInterrupt from error


class _SealedFile(IndexDataCacheFile):
    """Index and data with the SHA-256 of the content behind it, which pickle passes over."""

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
        buffer = io.BytesIO()
        yield buffer
        content = buffer.getvalue()
        with super()._open_for_write(filepath) as file:
            file.write(content + hashlib.sha256(content).digest())

    def _load_index(self) -> Any:
        return super()._load_index() if _whole(self._index_path) else {}

    def _load_data(self, name: str) -> Any:
        path = self._data_path(name)
        if not _whole(path):
            raise OSError(f"{path} is damaged")
        return super()._load_data(name)


def _whole(path: str) -> bool:
    try:
        content = Path(path).read_bytes()
    except OSError:
        return False
    body, seal = content[:-_SEAL_LENGTH], content[-_SEAL_LENGTH:]
    return hashlib.sha256(body).digest() == seal
