"""What a campaign file may make pmmkit say of files that lie elsewhere."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.readers import READERS

SECRET = "root:x:0:0:root:/root:/bin/sh\ntoken = hunter2,abc;def 99\nuser pass\n"
WORDS = ("root", "hunter2", "token", "99", "pass")
DATA = "t,X,Y,force of the mount\n" + "".join(f"{0.1 * i:.1f},1.5,2.5,3.5\n" for i in range(40))
CAMPAIGN = """[campaign]
title = "elsewhere"
[ship]
name = "kvlcc2-l7"
[water]
rho = 1000.0
[[runs]]
id = "A"
test = "static_drift"
speed = 1.0
drift_deg = 4.0
file = '{file}'
"""


def refusal(folder: Path, file: str, more: str = "", **options) -> str:
    folder.mkdir(exist_ok=True)
    text = CAMPAIGN.format(file=file) + more
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CampaignError) as caught:
        open_campaign(folder, **options).runs[0].data.load()
    return str(caught.value)


@pytest.fixture
def secret(tmp_path) -> Path:
    (tmp_path / "secret.txt").write_text(SECRET, encoding="utf-8")
    return tmp_path / "secret.txt"


@pytest.mark.parametrize("name", [None, *READERS])
@pytest.mark.parametrize("absolute", [False, True])
def test_nothing_of_a_file_elsewhere_is_quoted(name, absolute, secret, tmp_path):
    source = f'source.format = "{name}"\n' if name else ""
    said = refusal(tmp_path / "c", str(secret) if absolute else "../secret.txt", source)
    told = said.replace(str(tmp_path), "")
    assert not [word for word in WORDS if word in told]
    assert "secret.txt" in said
    assert len(said.splitlines()) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_link_does_not_bring_it_inside(secret, tmp_path):
    (tmp_path / "c").mkdir()
    os.symlink(secret, tmp_path / "c" / "run.csv")
    said = refusal(tmp_path / "c", "run.csv")
    assert "lies outside the folder of the campaign" in said
    assert "hunter2" not in said


def test_inside_the_folder_or_where_the_user_points_it_is_told(secret, tmp_path):
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "run.csv").write_text(SECRET, encoding="utf-8")
    assert "root:x" in refusal(tmp_path / "c", "run.csv")
    assert "root:x" in refusal(tmp_path / "c", "secret.txt", data=tmp_path)


def test_measurements_elsewhere_are_told_in_full(tmp_path):
    (tmp_path / "run.csv").write_text(DATA, encoding="utf-8")
    said = refusal(tmp_path / "c", "../run.csv")
    assert "'force of the mount'" in said


def test_the_error_in_python_has_no_other_behind_it_that_tells(secret, tmp_path):
    folder = tmp_path / "c"
    folder.mkdir()
    text = CAMPAIGN.format(file="../secret.txt")
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CampaignError) as caught:
        open_campaign(folder).runs[0].data.load()
    error: BaseException | None = caught.value
    while error is not None:
        assert "hunter2" not in str(error)
        error = error.__cause__ or error.__context__
