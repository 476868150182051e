"""Each reader against a few damaged files of each kind; scripts.studies.damage tries thousands."""

from __future__ import annotations

import signal

import pytest

from scripts.studies import damage

pytestmark = pytest.mark.skipif(
    not hasattr(signal, "SIGALRM"), reason="the time limit of a version needs SIGALRM"
)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(damage.FORMATS))
def test_the_right_numbers_or_an_error_that_says_so(name):
    for kind in damage.kinds_of(damage.FORMATS[name]):
        found = damage.tried(name, kind, range(2))
        assert not set(found) & set(damage.BAD), f"{kind}: {found}"


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("columns moved", {"right"}), ("text", {"refused"}), ("empty", {"refused"})],
)
def test_the_harness_tells_outcomes_apart(kind, expected):
    assert set(damage.tried("csv", kind, range(3))) == expected


def test_rows_that_vanish_count_as_lost(tmp_path):
    form = damage.FORMATS["csv"]
    damage.good_folder(form, tmp_path)
    file = tmp_path / form.file
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(lines[:100] + lines[150:]), encoding="utf-8")
    assert damage.outcome(form, tmp_path, "bytes flipped") == "lost"
