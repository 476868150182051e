"""A campaign inside a zip archive: opened as it is, and nothing outside of it is touched."""

from __future__ import annotations

import io
import struct
import zipfile

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.cli import main
from pmmkit.testing.readers import check_reader
from scripts.studies import damage

ROWS = "t,X,Y,N\n" + "".join(f"{k / 10},{-20 - k / 7},{k / 3},0.5\n" for k in range(60))
FILE = 'file = "runs/SD.csv"\n'


def packed(path, files, how=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", how) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def campaign(files=None, text=damage.CAMPAIGN + FILE):
    return {"tests/campaign.toml": text, "tests/runs/SD.csv": ROWS} | (files or {})


def refused(path, match):
    with pytest.raises(CampaignError, match=match):
        pk.open_campaign(path)["SD"].data.load()


@pytest.mark.parametrize("how", [zipfile.ZIP_DEFLATED, zipfile.ZIP_STORED])
def test_an_archive_opens_as_its_folder_does(how, tmp_path, capsys):
    files = campaign()
    archive = packed(tmp_path / "all.zip", files, how)
    for name, content in files.items():
        file = tmp_path / "folder" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
    one, two = pk.open_campaign(archive), pk.open_campaign(tmp_path / "folder" / "tests")
    assert one.ship == two.ship
    assert one["SD"].settings == two["SD"].settings
    for name in ("t", "X", "Y", "N"):
        assert np.array_equal(one["SD"].data[name], two["SD"].data[name])
    assert len(pk.open_campaign(archive, runs=False)) == 0
    assert main(["inspect", str(archive)]) == 0
    assert "1 runs (1 static_drift)" in capsys.readouterr().out
    assert sorted(item.name for item in tmp_path.iterdir()) == ["all.zip", "folder"]


def test_folders_of_windows_are_folders(tmp_path):
    files = {name.replace("/", "\\"): content for name, content in campaign().items()}
    text = damage.CAMPAIGN + "file = 'runs\\SD.csv'\n"
    archive = packed(tmp_path / "a.zip", {**files, "tests\\campaign.toml": text})
    assert pk.open_campaign(archive)["SD"].data.sizes["t"] == 60


def test_a_table_and_an_open_water_curve_inside(tmp_path):
    text = damage.CAMPAIGN.split("[[runs]]")[0] + (
        '[propeller]\nD = 0.2\nopen_water = "curve.csv"\n'
        '[[tables]]\nid = "SD_{beta}"\ntest = "static_drift"\nspeed = 1.5\nfile = "means.csv"\n'
        'columns = { drift_deg = "beta" }\n'
    )
    means = "beta,X,Y,N\n4,-21.0,35.5,60.2\n8,-22.0,72.5,121.0\n"
    curve = "J,KT,10KQ\n0,0.3,0.35\n0.5,0.15,0.2\n"
    files = {"campaign.toml": text, "means.csv": means, "curve.csv": curve}
    tests = pk.open_campaign(packed(tmp_path / "a.zip", files))
    assert [float(run.data["Y"]) for run in tests] == [35.5, 72.5]

    J, KT, KQ = tests.open_water
    assert (J[1], KT[1], KQ[1]) == pytest.approx((0.5, 0.15, 0.02))


def test_a_foreign_archive_is_described_from_outside(tmp_path):
    """A laboratory's archive in a layout of its own: a campaign file names what it holds."""
    packed(tmp_path / "lab.zip", {"README": "ours", "pmm/run 7.txt": ROWS.replace(",", "  ")})
    refused(tmp_path / "lab.zip", "holds no campaign.toml; it has README, pmm/run 7.txt")
    text = 'file = "lab.zip"\nsource = { group = "pmm/run 7.txt" }\n'
    (tmp_path / "campaign.toml").write_text(damage.CAMPAIGN + text, encoding="utf-8")
    assert pk.open_campaign(tmp_path)["SD"].data["Y"].values[3] == 1.0
    (tmp_path / "campaign.toml").write_text(damage.CAMPAIGN + text.replace("7", "8"))
    refused(tmp_path, "no file 'pmm/run 8.txt'; did you mean|no file 'pmm/run 8.txt'")


@pytest.mark.parametrize("outside", ["../../secret.csv", "../secret.csv", "{folder}/secret.csv"])
def test_a_path_that_leads_out_leads_nowhere(outside, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "secret.csv").write_text(ROWS)
    (tmp_path / "in" / "secret.csv").write_text(ROWS)
    file = outside.format(folder=tmp_path.as_posix())
    text = f'{damage.CAMPAIGN}file = "{file}"\n'
    refused(packed(tmp_path / "in" / "a.zip", campaign(text=text)), "the archive has no file")


def test_names_that_lead_out_are_never_written(tmp_path):
    files = campaign({"../../evil.csv": ROWS, "/evil.csv": ROWS, "C:\\evil.csv": ROWS})
    (tmp_path / "in").mkdir()
    tests = pk.open_campaign(packed(tmp_path / "in" / "a.zip", files))
    assert tests["SD"].data.sizes["t"] == 60
    assert [item.name for item in tmp_path.rglob("*evil*")] == []


@pytest.mark.parametrize(
    ("files", "why"),
    [
        ({"a.csv": ROWS}, "holds no campaign.toml"),
        (campaign({"campaign.toml": damage.CAMPAIGN + FILE}), "2 files campaign.toml, not one"),
        (campaign(text=damage.CAMPAIGN + 'file = "x.csv"\n'), "no file 'tests/x.csv'"),
        (campaign(text=damage.CAMPAIGN + FILE + 'motion = "m.csv"\n'), "file of the motion"),
        (campaign(text=damage.CAMPAIGN + FILE + '[[matrix]]\nfile = "m.csv"\n'), "of a matrix"),
        (
            campaign(text=damage.CAMPAIGN + FILE + 'source = { format = "hdf5" }\n'),
            "format 'hdf5' are not read out of an archive",
        ),
        (campaign(text="[campaign\n"), "not valid TOML"),
        (campaign(text=damage.CAMPAIGN + FILE + "rows = 59\n"), "60 rows of numbers"),
        (campaign({"tests/runs/SD.csv": ROWS + "6,x,1,1\n"}), "'x' is not a number"),
    ],
)
def test_what_is_wrong_is_said(files, why, tmp_path):
    refused(packed(tmp_path / "a.zip", files), why)


def test_an_archive_that_grows_without_end_is_refused(tmp_path):
    """A milliard of bytes declared, and 64 MB that the directory gives as 100."""
    path = packed(tmp_path / "a.zip", campaign({"blanks": b" " * 1000}))
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, data.rindex(b"PK\x01\x02") + 24, 3_000_000_000)
    path.write_bytes(data)
    refused(path, "3,000,00[0-9,]+ bytes, the file has")
    packed(path, campaign({"tests/runs/SD.csv": b"1,1,1,1\n" * 2_000_000}))
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, data.rindex(b"PK\x01\x02") + 24, 100)
    path.write_bytes(data)
    refused(path, "is not as long as it says")


def test_links_and_locked_files_are_refused(tmp_path):
    path = packed(tmp_path / "a.zip", campaign())
    link = zipfile.ZipInfo("tests/link.csv")
    link.external_attr = 0o120777 << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(link, "/etc/hostname")
    refused(path, "is a link or encrypted")
    data = bytearray(packed(path, campaign()).read_bytes())
    struct.pack_into("<H", data, data.index(b"PK\x01\x02") + 8, 1)
    path.write_bytes(data)
    refused(path, "is a link or encrypted")


@pytest.mark.parametrize("how", [zipfile.ZIP_DEFLATED, zipfile.ZIP_STORED])
def test_a_damaged_archive_never_gives_other_numbers(how, tmp_path):
    """Cut short or with a byte flipped: refused, or read as it was."""
    good = packed(tmp_path / "a.zip", campaign(), how).read_bytes()
    truth = pk.open_campaign(tmp_path / "a.zip")["SD"].data["Y"].values
    generator = np.random.default_rng(0)
    flips = [(int(place), None) for place in generator.integers(0, len(good), 40)]
    read = 0
    for place, cut in [*flips, *((0, size) for size in range(0, len(good), len(good) // 12))]:
        data = bytearray(good)
        data[place] ^= 0 if cut is not None else 0x41
        (tmp_path / "a.zip").write_bytes(data[:cut])
        try:
            found = pk.open_campaign(tmp_path / "a.zip")["SD"].data["Y"].values
        except CampaignError:
            continue
        assert np.array_equal(found, truth)
        read += 1
    assert read < len(flips)


def test_the_reader_of_archives_keeps_its_word(tmp_path):
    room = io.StringIO()
    np.savetxt(
        room,
        np.stack(list(damage.truth().values()), axis=1),
        fmt="%.6f",
        delimiter=",",
        header=",".join(damage.truth()),
        comments="",
    )
    path = packed(tmp_path / "one.zip", {"pmm/run.csv": room.getvalue()})
    check_reader(pk.readers.READERS["zip"], path, damage.truth())
