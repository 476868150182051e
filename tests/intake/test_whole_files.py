"""Files that lost their end: what pmmkit wrote is refused, what others wrote is warned of."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit import open_campaign
from pmmkit.base import CampaignError, DataError
from pmmkit.cli import main
from pmmkit.intake import Summary
from pmmkit.intake.checks.whole_files import examine_ends


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> Path:
    return write_campaign(tmp_path_factory.mktemp("whole") / "small")


@pytest.fixture
def copied(small, tmp_path) -> Path:
    return Path(shutil.copytree(small, tmp_path / "copied"))


def content(campaign: pk.Campaign) -> list[object]:
    every = [*campaign.runs, *(run for run, _ in campaign.excluded)]
    return [(run.id, run.test, run.settings) for run in every] + [campaign.ship, campaign.title]


def outcomes(folder: Path, cuts) -> dict[str, list[int]]:
    """What comes of a campaign file that ends at each of some bytes."""
    file = folder / "campaign.toml"
    whole, reference = file.read_bytes(), content(open_campaign(folder))
    found: dict[str, list[int]] = {"refused": [], "same": [], "told": [], "silent": []}
    for cut in cuts(whole):
        file.write_bytes(whole[:cut])
        try:
            campaign = open_campaign(folder)
        except DataError:
            found["refused"].append(cut)
            continue
        told = [item.severity for item in examine_ends(campaign, [])]
        same = content(campaign) == reference
        found["same" if same else "told" if told else "silent"].append(cut)
    file.write_bytes(whole)
    return found


def sampled(whole: bytes) -> list[int]:
    """Every 41st byte, and before and behind every second line end of the last runs."""
    ends = [at for at in range(len(whole) // 2, len(whole)) if whole[at : at + 1] == b"\n"][::2]
    return sorted({*range(0, len(whole), 41), *ends, *(at + 1 for at in ends[:-1])})


@pytest.mark.slow
def test_a_campaign_file_that_pmmkit_wrote_is_whole_or_refused(small, tmp_path):
    pk.export(small, tmp_path / "out")
    found = outcomes(tmp_path / "out", sampled)
    assert found["told"] == found["silent"] == []
    assert len(found["same"]) == 1
    assert found["refused"]


@pytest.mark.slow
def test_a_draft_is_whole_or_refused(copied, capsys):
    (copied / "campaign.toml").unlink()
    for file in (copied / "runs").glob("[PY][YD]*.csv"):
        file.unlink()
    assert main(["new-campaign", str(copied), "--ship", "s175"]) == 0
    file = copied / "campaign.toml"
    draft = file.read_text(encoding="utf-8").replace("rho = 999.1", "rho = 1000.0 #")
    file.write_text(draft, encoding="utf-8")
    assert "closed = true" in draft
    found = outcomes(copied, lambda whole: sampled(whole)[::5])
    assert found["told"] == found["silent"] == []


@pytest.mark.slow
def test_a_campaign_file_by_hand_is_told_where_anything_tells(copied):
    """Only a cut behind a whole line, with one file or none left in use, shows no sign."""
    found = outcomes(copied, sampled)
    assert len(found["told"]) > 20
    text = (copied / "campaign.toml").read_text(encoding="utf-8")
    second = [at for at in range(len(text)) if text.startswith("[[runs]]", at)][2]
    assert all(cut <= second for cut in found["silent"])


def test_nothing_is_said_of_a_file_by_hand_that_is_whole(small):
    assert list(examine_ends(open_campaign(small), [])) == []


def test_the_error_says_what_to_do(copied):
    file = copied / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    closed = text.replace('kind = "captive"', 'kind = "captive"\nclosed = true')
    file.write_text(closed, encoding="utf-8")
    with pytest.raises(CampaignError, match=r"cut off.*\[end\] is missing.*write \[end\]"):
        open_campaign(copied)
    file.write_text(f"{closed}\n[end]", encoding="utf-8")
    assert list(examine_ends(open_campaign(copied), [])) == []


def test_an_exported_history_that_lost_rows_is_refused(small, tmp_path):
    campaign = pk.open_campaign(small)
    pk.export(campaign.with_(runs=campaign.runs[:1]), tmp_path / "out")
    (file,) = (tmp_path / "out").glob("*.csv")
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join(lines[:-3]))
    with pytest.raises(CampaignError, match="rows of numbers; the campaign file says"):
        open_campaign(tmp_path / "out").runs[0].data.load()


@pytest.mark.slow
def test_every_cut_of_an_exported_history_is_refused_or_warned_of(small, tmp_path):
    campaign = pk.open_campaign(small)
    pk.export(campaign.with_(runs=campaign.runs[:1]), tmp_path / "out")
    (file,) = (tmp_path / "out").glob("*.csv")
    whole = file.read_bytes()
    reference = open_campaign(tmp_path / "out").runs[0].data.load()
    silent = []
    for cut in range(len(whole) - 110, len(whole)):
        file.write_bytes(whole[:cut])
        campaign = open_campaign(tmp_path / "out")
        try:
            data = campaign.runs[0].data.load()
        except DataError:
            continue
        if not data.equals(reference) and not list(examine_ends(campaign, [])):
            silent.append(cut)
    assert silent == []


def test_a_file_without_a_last_line_end_among_others_is_named(copied):
    files = sorted((copied / "runs").glob("*.csv"))
    files[2].write_bytes(files[2].read_bytes().rstrip(b"\n"))
    (found,) = examine_ends(open_campaign(copied), [])
    assert found.severity == "warning"
    assert files[2].name in found.message
    assert len(found.runs) == 1


def test_a_habit_of_the_writer_is_no_sign(copied):
    for file in (copied / "runs").glob("*.csv"):
        file.write_bytes(file.read_bytes().rstrip(b"\n"))
    assert list(examine_ends(open_campaign(copied), [])) == []


def test_a_file_that_no_run_names_is_worth_knowing(copied):
    shutil.copy(next((copied / "runs").glob("*.csv")), copied / "runs" / "forgotten.csv")
    (found,) = examine_ends(open_campaign(copied), [])
    assert found.severity == "info"
    assert "forgotten.csv" in found.message


def test_a_record_shorter_than_all_its_sisters_is_named(small):
    runs = [run for run in open_campaign(small).runs if run.test == "static_drift"][:6]
    assert len(runs) == 6
    lengths = np.full(6, 800.0)

    def found(lengths):
        items = [
            Summary(run=run, facts={"samples": count})
            for run, count in zip(runs, lengths, strict=True)
        ]
        return [item.runs for item in examine_ends(open_campaign(small), items)]

    assert found(lengths) == []
    assert found([*lengths[:3], 790.0, *lengths[4:]]) == [(runs[3].id,)]
    assert found([*lengths[:3], 790.0, 810.0, 800.0]) == []
    assert found([*lengths[:3], 810.0, *lengths[4:]]) == []
