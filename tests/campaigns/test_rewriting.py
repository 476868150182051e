"""A campaign file is changed in one place; its comments and all else stay to the letter."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pmmkit.base import DataError
from pmmkit.campaigns import CampaignFile

FILE = """\
# of May, gauge 7  # "odd" [[runs]]
[campaign]
title = "a # in a title"
closed = true

[columns]          # our name = theirs
Y = "Fy # 2 (N)"   # checked by hand
# N = "Mz"

[[corrections]]    # why not
runs = ["a"]
action = "exclude"
reason = "copy"

# the first run
[[runs]]
id = "a"
file = "a.csv"     # on the old disk

[end]
# nothing more
"""
WINDOW = {"runs": ["b"], "action": "window", "t_start": 1.0, "t_end": 2.0, "reason": "calm"}


@example(start=0.0, reason="copy")
@given(
    start=st.floats(-1e6, 1e6),
    reason=st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1, max_size=40),
)
def test_a_correction_comes_and_goes_without_a_trace(start, reason):
    entry = {**WINDOW, "t_start": start, "reason": reason}
    once = CampaignFile(FILE).with_correction(entry)
    assert tomllib.loads(once)["corrections"][1] == entry
    assert tomllib.loads(once).keys() == tomllib.loads(FILE).keys()
    assert CampaignFile(once).without_correction(WINDOW) == FILE
    # All lines in their order, whatever stands between them: an entry may repeat one of them.
    left = iter(once.splitlines())
    assert all(line in left for line in FILE.splitlines() if line)


@pytest.mark.parametrize(
    "file",
    [
        FILE.replace("\n", "\r\n"),
        FILE.replace("title =", "title = 'a\u2028b'\nby ="),
        FILE.removesuffix("\n"),
        FILE + "\n\n",
    ],
)
def test_line_ends_stay_and_so_do_breaks_within_a_text(file):
    changed = CampaignFile(CampaignFile(file).with_columns({"Y": "Fz # 2"})).with_correction(WINDOW)
    assert tomllib.loads(changed)["corrections"][1] == WINDOW
    assert CampaignFile(CampaignFile(changed).with_columns({"Y": "Fy # 2 (N)"})).without_correction(
        WINDOW
    ) == file.replace("   # checked", " # checked")


def test_the_same_runs_and_action_are_stated_once():
    first = (
        CampaignFile(FILE)
        .with_correction(WINDOW)
        .replace("t_end = 2.0", "t_end = 2.0  # by the film")
    )
    again = CampaignFile(first).with_correction({**WINDOW, "t_end": 3.5})
    assert again == first.replace("t_end = 2.0  # by the film", "t_end = 3.5 # by the film")
    assert (
        len(
            tomllib.loads(CampaignFile(again).with_correction({**WINDOW, "runs": ["c"]}))[
                "corrections"
            ]
        )
        == 3
    )


def test_a_column_changes_in_its_line():
    found = CampaignFile(FILE).with_columns({"Y": {"name": "Fy # 2 (N)", "scale": -1.0}, "N": "Mz"})
    assert 'Y = { name = "Fy # 2 (N)", scale = -1.0 } # checked by hand\n' in found
    assert tomllib.loads(found)["columns"]["N"] == "Mz"
    gone = CampaignFile(FILE).with_columns({"Y": None})
    assert "columns" in tomllib.loads(gone)
    assert '# Y = "Fy # 2 (N)"' in gone


@pytest.mark.parametrize(
    "text",
    [
        'columns = { Y = "Fy" }\n[campaign]\n',
        '[columns]\nY = """\nFy"""\n',
        "[campaign\n",
        'corrections = []\n[campaign]\ntitle = "x"\n',
    ],
)
def test_a_file_written_otherwise_is_left_to_its_author(text):
    with pytest.raises(DataError, match="by hand"):
        CampaignFile(CampaignFile(text).with_columns({"Y": "Fz"})).with_correction(WINDOW)
