"""Compiled equations on disk: what is damaged is made again, what others wrote is not loaded."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.registry import cpu_target

from pmmkit.equations.compilation import compiled
from pmmkit.equations.compiled_cache import kept

SESSION = """
import warnings, numpy as np
from pmmkit.equations import prepare
from pmmkit.equations.compilation import compiled
from pmmkit.equations.compiled_cache import kept
from pmmkit.models import load_model
ready = prepare(load_model('kvlcc2-l7'), 1.179)
out = np.zeros(6)
functions = compiled(ready.structure)
y = np.array([0, 0, 0, 1.0, -0.1, 0.05])
functions.rates(y, 0.2, 10.0, 0.0, np.array(ready.constants), out)
cache = functions.rates.stats if hasattr(functions.rates, 'stats') else None
print(repr(out.tolist()), sum(cache.cache_hits.values()))
"""


def session(folder: Path, **environment: str) -> tuple[str, int, str]:
    """Rates of a ship, how many functions came from the cache, and what was said."""
    done = subprocess.run(
        [sys.executable, "-c", SESSION],
        env={**os.environ, "PMMKIT_CACHE": str(folder), **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    numbers, hits = done.stdout.rsplit(maxsplit=1)
    return numbers, int(hits), done.stderr


@pytest.fixture(scope="module")
def filled(tmp_path_factory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("cache")
    numbers, hits, said = session(folder)
    assert (hits, said) == (0, "")
    return folder, numbers


def files(folder: Path, ending: str) -> list[Path]:
    found = sorted(folder.rglob(f"*{ending}"))
    assert found
    return found


@pytest.mark.slow
def test_the_second_session_finds_it_and_only_the_user_can_write_it(filled):
    folder, numbers = filled
    assert session(folder, NUMBA_CACHE_DIR=str(folder / "elsewhere"))[:2] == (numbers, 1)
    assert not list((folder / "elsewhere").rglob("*.nb?"))
    assert len(files(folder, ".py")) == 1
    assert files(folder, ".nbc")
    if sys.platform != "win32":
        modes = {place.stat().st_mode & 0o777 for place in folder.glob("v*")}
        assert modes == {0o700}


@pytest.mark.slow
def test_empty_files_are_made_again(filled):
    folder, numbers = filled
    for ending in (".nbi", ".nbc", ".py"):
        for file in files(folder, ending):
            file.write_bytes(b"")
    assert session(folder) == (numbers, 0, "")


DAMAGE = {
    "empty": lambda content: b"",
    "cut in half": lambda content: content[: len(content) // 2],
    "last byte lost": lambda content: content[:-1],
    "a bit turned": lambda content: content[:90] + bytes([content[90] ^ 1]) + content[91:],
    "zeros": lambda content: bytes(len(content)),
    "text": lambda content: b"hello",
    "a pickle of another": lambda content: pickle.dumps({}),
}


@pytest.mark.slow
@pytest.mark.parametrize("how", DAMAGE)
@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
def test_a_damaged_entry_is_made_again(how, ending, tmp_path):
    place = tmp_path / "doubled.py"
    place.write_text("def doubled(x):\n    return 2 * x\n")
    known = {"__name__": __name__}  # numba looks the module of a kept function up
    exec(compile(place.read_text(), str(place), "exec"), known)

    def hits():
        function = kept(known["doubled"])
        assert function(21) == 42
        return sum(function.stats.cache_hits.values())

    assert [hits(), hits()] == [0, 1]
    for file in files(tmp_path, ending):
        file.write_bytes(DAMAGE[how](file.read_bytes()))
    assert [hits(), hits()] == [0, 1]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such bits")
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o720])
@pytest.mark.parametrize("inside", [False, True])
def test_what_others_could_have_written_is_not_loaded(mode, inside, tmp_path, monkeypatch):
    monkeypatch.setenv("PMMKIT_CACHE", str(tmp_path / "cache"))
    from pmmkit.base import __version__
    from pmmkit.equations import prepare
    from pmmkit.models import load_model

    place = tmp_path / "cache" / f"v{__version__}"
    place.mkdir(parents=True, mode=0o700)
    (place if inside else place.parent).chmod(mode)
    structure = prepare(load_model("kvlcc2-l7"), 1.179).structure
    with pytest.warns(UserWarning, match=r"not kept.*can be written by other users.*PMMKIT_CACHE"):
        module = compiled.__wrapped__(structure)
    assert "rates" in vars(module)
    assert list(place.iterdir()) == []


@pytest.mark.skipif(
    sys.platform == "win32" or os.getuid() != 0, reason="only root can give files away"
)
def test_the_cache_of_another_user_is_not_loaded(tmp_path, monkeypatch):
    from pmmkit.equations import prepare
    from pmmkit.models import load_model

    (tmp_path / "cache").mkdir(mode=0o700)
    os.chown(tmp_path / "cache", 12345, 12345)
    monkeypatch.setenv("PMMKIT_CACHE", str(tmp_path / "cache"))
    with pytest.warns(UserWarning, match="belongs to another user"):
        compiled.__wrapped__(prepare(load_model("kvlcc2-l7"), 1.179).structure)
    assert list((tmp_path / "cache").rglob("*.py")) == []


def test_an_interrupt_that_took_the_machine_code_with_it_is_an_interrupt(tmp_path, monkeypatch):
    """Ctrl-C while LLVM hands over what it has compiled leaves nothing to be kept."""
    file = tmp_path / "doubled.py"
    file.write_text("def doubled(x):\n    return 2.0 * x\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    from doubled import doubled

    function = kept(doubled)
    engine = cpu_target.target_context.codegen()._engine._ee
    monkeypatch.setattr(engine, "_object_cache_notify", None)
    with pytest.raises(KeyboardInterrupt):
        function(1.5)
    assert not list(tmp_path.rglob("*.nbi"))
