"""Campaigns and runs behind URLs: what is read, what is refused, and what a network does."""

from __future__ import annotations

import hashlib
import sys
import zipfile
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import pytest
from web import served_web

import pmmkit as pk
from pmmkit.base import CampaignError, DataError
from pmmkit.cli import main
from pmmkit.files import Origin, Url
from pmmkit.files.remote import copies, objects
from pmmkit.files.remote.copies import SHEET
from pmmkit.files.remote.objects import is_absent, told
from pmmkit.reduction.reading import all_runs
from scripts.datasets.make_large import make
from scripts.studies.cluster import everything
from scripts.studies.damage import CAMPAIGN

pytest.importorskip("fsspec", reason="pmmkit[remote] is not installed")
pytest.importorskip("aiohttp", reason="pmmkit[remote] is not installed")

ROWS = "t,X,Y,N\n" + "".join(f"{k / 10},{-20 - k / 7},{k / 3},0.5\n" for k in range(60))
OTHER = ROWS.replace("0.5\n", "0.7\n")
NAMES = ("t", "X", "Y", "N")


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A cache of its own, no waiting before the next attempt, and no proxy to this machine."""
    monkeypatch.setenv("PMMKIT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    monkeypatch.delenv("PMMKIT_DATA", raising=False)
    monkeypatch.setattr(copies, "WAITS", (0.0, 0.0))
    return tmp_path / "cache" / "remote"


@pytest.fixture
def memory(monkeypatch):
    """fsspec's store in memory, as if it were one of the protocols."""
    import fsspec

    packages = MappingProxyType({**objects.PACKAGES, "memory": "fsspec"})
    monkeypatch.setattr(objects, "PACKAGES", packages)
    monkeypatch.setattr(objects, "PACKAGES", packages)
    store = fsspec.filesystem("memory")
    yield store
    store.store.clear()


def naming(file: str, head: str = "") -> str:
    return CAMPAIGN.replace("[campaign]\n", f"[campaign]\n{head}") + f"file = {file!r}\n"


def local(folder, files: Mapping[str, str]):
    for name, content in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
    return folder


FILES = MappingProxyType({"campaign.toml": naming("runs/SD 1.csv"), "runs/SD 1.csv": ROWS})


@pytest.mark.parametrize("named", ["kcs", "kcs/", "kcs/campaign.toml"])
def test_a_campaign_opens_by_url_as_it_does_from_its_folder(named, tmp_path):
    here = pk.open_campaign(local(tmp_path / "kcs", FILES))
    with served_web({f"kcs/{name}": text for name, text in FILES.items()}) as web:
        there = pk.open_campaign(f"{web.url}/{named}")
        assert there.ship == here.ship
        assert there["SD"].settings == here["SD"].settings
        for name in NAMES:
            assert np.array_equal(there["SD"].data[name], here["SD"].data[name])
        assert there.file_hashes() == here.file_hashes()
        assert there.provenance["url"] == f"{web.url}/kcs/campaign.toml"
        assert there.provenance["sha256"] == here.provenance["sha256"]
        assert web.asked["GET", "/kcs/runs/SD 1.csv"] == 1


def test_nothing_is_fetched_before_it_is_read_and_nothing_twice(cache):
    with served_web(FILES) as web:
        campaign = pk.open_campaign(web.url)
        assert web.asked["GET", "/runs/SD 1.csv"] == 0
        campaign["SD"].data.load()
        pk.open_campaign(web.url)["SD"].data.load()
        assert web.asked["GET", "/runs/SD 1.csv"] == 1
        (copy,) = cache.rglob("SD 1.csv")
        copy.write_text(OTHER, encoding="utf-8")
        assert float(campaign["SD"].data["N"][0]) == 0.5
        assert web.asked["GET", "/runs/SD 1.csv"] == 2


def test_another_state_is_fetched_anew_and_the_old_copy_goes(cache):
    with served_web(FILES) as web:
        before = pk.open_campaign(web.url)
        assert float(before["SD"].data["N"][0]) == 0.5
        web.files["/runs/SD 1.csv"] = OTHER.encode()
        assert float(before["SD"].data["N"][0]) == 0.5
        assert float(pk.open_campaign(web.url)["SD"].data["N"][0]) == 0.7
        assert len(list(cache.rglob("SD 1.csv"))) == 1
        with pytest.raises(CampaignError, match="run SD: it has changed since"):
            before["SD"].data.load()


def test_a_server_that_states_no_state_is_believed_for_one_opening():
    with served_web(FILES) as web:
        web.tagged = False
        campaign = pk.open_campaign(web.url)
        assert float(campaign["SD"].data["N"][0]) == 0.5
        web.files["/runs/SD 1.csv"] = OTHER.encode()
        assert float(campaign["SD"].data["N"][0]) == 0.5
        assert float(pk.open_campaign(web.url)["SD"].data["N"][0]) == 0.7


def test_a_store_of_objects_and_measurements_elsewhere(memory, tmp_path):
    memory.pipe({"/tank/campaign.toml": naming("SD.csv", 'data_folder = "may"\n').encode()})
    memory.pipe({"/data/may/SD.csv": ROWS.encode()})
    with pytest.raises(CampaignError, match=r"'SD\.csv' is not there.*memory://tank/SD\.csv"):
        pk.open_campaign("memory://tank")
    assert pk.open_campaign("memory://tank", data="memory://data")["SD"].data.sizes["t"] == 60
    folder = local(tmp_path / "here", {"campaign.toml": naming("SD.csv", 'data_folder = "may"\n')})
    assert pk.open_campaign(folder, data="memory://data")["SD"].data.sizes["t"] == 60
    stated = local(tmp_path / "a", {"campaign.toml": naming("memory://data/may/SD.csv")})
    campaign = pk.open_campaign(stated)
    digest = hashlib.sha256(ROWS.encode()).hexdigest()
    assert campaign.file_hashes() == {"memory://data/may/SD.csv": digest}
    text = naming("SD.csv", 'data_folder = "memory://data/may"\n')
    assert len(pk.open_campaign(local(tmp_path / "b", {"campaign.toml": text}))) == 1
    near = local(tmp_path / "data", {"may/SD.csv": OTHER})
    assert float(pk.open_campaign("memory://tank", data=near)["SD"].data["N"][0]) == 0.7


def test_saved_and_packed_campaigns(memory, tmp_path):
    folder = local(tmp_path / "kcs", FILES)
    with zipfile.ZipFile(tmp_path / "kcs.zip", "w") as archive:
        for name, text in FILES.items():
            archive.writestr(name, text)
    pk.save_campaign(pk.open_campaign(folder), tmp_path / "kcs.h5")
    for name in ("kcs.zip", "kcs.h5"):
        memory.pipe({f"/b/{name}": (tmp_path / name).read_bytes()})
        campaign = pk.open_campaign(f"memory://b/{name}")
        assert campaign.provenance["url"] == f"memory://b/{name}"
        assert campaign["SD"].data.sizes["t"] == 60


def test_an_archive_names_no_url(tmp_path):
    with served_web({"SD.csv": ROWS}) as web, zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("campaign.toml", naming("SD.csv", f"data_folder = {web.url!r}\n"))
        archive.close()
        with pytest.raises(CampaignError, match="has no file"):
            pk.open_campaign(tmp_path / "a.zip")["SD"].data.load()
        assert not web.asked


def test_tables_and_the_curve_of_the_propeller(memory):
    text = CAMPAIGN.split("[[runs]]")[0] + (
        '[propeller]\nD = 0.2\nopen_water = "curve.csv"\n'
        '[[tables]]\nid = "SD_{beta}"\ntest = "static_drift"\nspeed = 1.5\nfile = "means.csv"\n'
        'columns = { drift_deg = "beta" }\n'
    )
    means = "beta,X,Y,N\n4,-21.0,35.5,60.2\n8,-22.0,72.5,121.0\n"
    memory.pipe({"/b/campaign.toml": text.encode(), "/b/means.csv": means.encode()})
    with pytest.raises(CampaignError, match=r"curve\.csv' is not there"):
        pk.open_campaign("memory://b")
    memory.pipe({"/b/curve.csv": b"J,KT,KQ\n0,0.3,0.035\n0.5,0.15,0.02\n"})
    tests = pk.open_campaign("memory://b")
    assert [float(run.data["Y"]) for run in tests] == [35.5, 72.5]
    assert tests.propeller["open_water"]["KT"] == [0.3, 0.15]


@pytest.mark.parametrize(
    "file",
    [
        "../secret.csv",
        "runs/../../secret.csv",
        "/etc/passwd",
        "C:\\secret.csv",
        "..\\secret.csv",
        "file:///etc/passwd",
        "local:///etc/passwd",
        "simplecache::file:///etc/passwd",
        "reference://x",
        "https://example.org/other.csv",
        "memory://kcs/../secret/x.csv",
        "memory://secret/x.csv",
    ],
)
def test_a_campaign_behind_a_url_names_nothing_outside(file, memory):
    memory.pipe({"/secret/x.csv": ROWS.encode(), "/secret.csv": ROWS.encode()})
    memory.pipe({"/kcs/campaign.toml": naming(file).encode()})
    with pytest.raises(CampaignError) as told:
        pk.open_campaign("memory://kcs")
    (problem,) = told.value.problems
    assert problem.remedy
    memory.pipe({"/kcs/campaign.toml": naming("x.csv", f"data_folder = {file!r}\n").encode()})
    with pytest.raises(CampaignError):
        pk.open_campaign("memory://kcs")
    with pytest.raises(CampaignError):
        pk.open_campaign("memory://kcs", data="memory://data")
    curve = CAMPAIGN.replace("[[runs]]", f"[propeller]\nopen_water = {file!r}\n[[runs]]")
    memory.pipe({"/kcs/campaign.toml": (curve + 'file = "x.csv"\n').encode()})
    memory.pipe({"/kcs/x.csv": ROWS.encode()})
    with pytest.raises(CampaignError, match="open_water"):
        pk.open_campaign("memory://kcs")


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("file:///etc/passwd", "file:// is not read"),
        ("reference://x", "reference:// is not read"),
        ("simplecache::https://example.org/x.csv", "chain of protocols"),
        ("https://me:key@example.org/x.csv", "holds a password"),
        ("https://", "no host"),
    ],
)
def test_urls_that_are_not_read(url, told, tmp_path):
    with pytest.raises(DataError, match=told) as error:
        pk.open_campaign(url)
    assert "key" not in str(error.value)
    with pytest.raises(CampaignError, match=told):
        pk.open_campaign(local(tmp_path, {"campaign.toml": naming(url)}))


def test_what_a_file_named_freely_holds_is_not_told(tmp_path):
    secret = "aws_secret_access_key wJalrXUtnFEMI\nregion eu\n"
    with served_web({"meta-data": secret, "run.csv": ROWS.replace("20", "x")}) as web:
        for name, shown in (("meta-data", False), ("run.csv", True)):
            folder = local(tmp_path / name, {"campaign.toml": naming(f"{web.url}/{name}")})
            with pytest.raises(CampaignError) as told:
                pk.open_campaign(folder)["SD"].data.load()
            assert ("-x" in str(told.value)) == shown
            assert "secret" not in str(told.value)
            assert "region" not in str(told.value)


def test_a_key_in_a_query_is_used_and_not_named(tmp_path, cache):
    with served_web({"SD.csv": ROWS}) as web:
        text = naming(f"{web.url}/SD.csv?signature=1b2c")
        campaign = pk.open_campaign(local(tmp_path / "kcs", {"campaign.toml": text}))
        assert "1b2c" not in str(campaign.file_hashes()) + str(campaign["SD"].data.attrs)
        assert not any("1b2c" in file.read_text() for file in cache.rglob(SHEET))
        web.states["/SD.csv"] = 403
        with pytest.raises(CampaignError, match="no permission") as told:
            pk.open_campaign(tmp_path / "kcs")
        assert "1b2c" not in str(told.value)


@pytest.mark.parametrize(
    "target", ["http://127.0.0.1:{port}/b.csv", "http://localhost:{here}/b.csv"]
)
def test_a_redirect_to_another_host_or_port_is_refused_and_gets_no_key(
    target, tmp_path, monkeypatch
):
    (tmp_path / ".netrc").write_text(
        "machine 127.0.0.1 login me password secret\nmachine localhost login me password secret\n",
        encoding="utf-8",
    )
    (tmp_path / ".netrc").chmod(0o600)
    monkeypatch.setenv("NETRC", str(tmp_path / ".netrc"))
    with served_web({"b.csv": ROWS}) as other, served_web({"b.csv": ROWS}) as web:
        port, here = (int(one.url.rpartition(":")[2]) for one in (other, web))
        web.moved["/a.csv"] = target.format(port=port, here=here)
        with pytest.raises(DataError) as raised:
            Origin.of(Url(f"{web.url}/a.csv"))
        assert f"leads to {target.format(port=port, here=here)}" in str(raised.value)
        assert not other.asked
        assert not web.asked["HEAD", "/b.csv"] + web.asked["GET", "/b.csv"]


@pytest.mark.parametrize("target", ["file:///etc/passwd", "data:,x", "http://[x", "ftp://other/x"])
def test_a_redirect_to_what_is_no_web_server_names_it(target):
    with served_web({}) as web:
        web.moved["/a.csv"] = target
        with pytest.raises(DataError, match="another place is not followed") as raised:
            Origin.of(Url(f"{web.url}/a.csv"))
    assert f"leads to {target}," in str(raised.value)


def test_a_redirect_in_a_circle_is_not_asked_for_again():
    with served_web({}) as web:
        web.moved |= {"/a.csv": "/b.csv", "/b.csv": "/a.csv"}
        with pytest.raises(DataError, match="never to a file") as raised:
            Origin.of(Url(f"{web.url}/a.csv"))
    assert "Try again" not in str(raised.value)
    assert sum(web.asked.values()) < 30


def test_a_redirect_within_a_server_is_followed():
    with served_web({"b.csv": ROWS}) as web:
        web.moved["/a.csv"] = "/b.csv"
        found = Origin.of(Url(f"{web.url}/a.csv"))
    assert found is not None
    assert found.size == len(ROWS)


def test_an_answer_that_breaks_off_is_asked_for_again():
    with served_web(FILES) as web:
        web.cut["/runs/SD 1.csv"] = 2
        assert pk.open_campaign(web.url)["SD"].data.sizes["t"] == 60
        assert web.asked["GET", "/runs/SD 1.csv"] == 3


def test_a_network_that_goes_is_told_with_the_run_and_nothing_half_is_left(cache):
    with served_web(FILES) as web:
        campaign = pk.open_campaign(web.url)
        web.cut["/runs/SD 1.csv"] = 9
        with pytest.raises(CampaignError, match=r"run SD: 127\.0\.0\.1:.* broke off") as told:
            campaign["SD"].data.load()
        assert "what was read is kept" in str(told.value)
        assert [item.name for item in cache.rglob("*.*") if item.suffix != ".json"] == [
            "campaign.toml"
        ]
        web.cut.clear()
        web.files.pop("/runs/SD 1.csv")
        with pytest.raises(CampaignError, match="it is gone"):
            campaign["SD"].data.load()
    with pytest.raises(DataError, match="cannot be reached"):
        pk.open_campaign(web.url)


@pytest.mark.parametrize(("state", "told"), [(404, "nothing behind"), (403, "no permission")])
def test_what_is_not_there_and_what_is_not_allowed(state, told):
    with served_web(FILES) as web:
        web.states["/campaign.toml"] = state
        with pytest.raises(DataError, match=told):
            pk.open_campaign(web.url)


def test_all_files_that_are_not_there_are_told_at_once():
    two = naming("a.csv") + CAMPAIGN[CAMPAIGN.index("[[runs]]") :].replace("SD", "SE")
    with (
        served_web({"campaign.toml": two + 'file = "b.csv"\n'}) as web,
        pytest.raises(CampaignError) as told,
    ):
        pk.open_campaign(web.url)
    assert [problem.message.split("'")[1] for problem in told.value.problems] == ["a.csv", "b.csv"]


def test_packages_that_are_not_there_are_named(monkeypatch):
    with pytest.raises(DataError, match=r"pip install 'pmmkit\[remote\]' gcsfs"):
        Origin.of(Url("gs://bucket/campaign.toml"))
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(DataError, match=r"pip install 'pmmkit\[remote\]',"):
        Origin.of(Url("https://example.org/campaign.toml"))


class FromStore(Exception):
    """An error as botocore, adlfs and gcsfs raise it."""


@pytest.mark.parametrize(
    ("said", "state", "absent"),
    [
        ({"response": {"ResponseMetadata": {"HTTPStatusCode": 404}}}, 404, True),
        ({"status_code": 404}, 404, True),
        ({"code": 403}, 403, False),
        ({}, None, False),
    ],
)
def test_what_stores_answer_is_understood(said, state, absent):
    cause = FromStore("no")
    for name, value in said.items():
        setattr(cause, name, value)
    error = FileNotFoundError("it")
    error.__cause__ = cause
    assert is_absent(error) == absent
    message = str(told(Url("s3://bucket/x"), error))
    assert ("gives no permission" in message) == (state == 403)
    assert is_absent(FileNotFoundError("it"))


def test_more_than_was_stated_is_not_taken(memory, monkeypatch):
    memory.pipe({"/kcs/a.csv": ROWS.encode()})
    origin = Origin.of(Url("memory://kcs/a.csv"))
    assert origin is not None
    memory.pipe({"/kcs/a.csv": (ROWS * 2).encode()})
    with pytest.raises(DataError, match=f"more than {len(ROWS)} bytes come"):
        copies.local_copy(origin)


def test_urls_survive_paths_and_names_survive_urls(tmp_path):
    assert Url.of(tmp_path) is None
    assert Url.of("datasets/s175") is None
    assert Url("https://h/a?key=1").joined("x #1?.csv") == "https://h/a/x%20%231%3F.csv"
    assert Url("https://h/a").joined("%2e%2e/x.csv") == "https://h/a/%252e%252e/x.csv"


@pytest.mark.slow
def test_a_reduction_by_url_is_that_of_the_folder_to_the_bit_also_after_the_network_went(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(all_runs, "PATIENCE", 0.0)
    make(tmp_path / "large", runs=10, mb=0.02)
    files = {
        item.relative_to(tmp_path).as_posix(): item.read_bytes()
        for item in tmp_path.rglob("*.*")
        if item.is_file()
    }
    near = reduced(tmp_path / "large")
    told: list[str] = []
    with served_web(files) as web:
        lost = next(name for name in web.files if "_0009.csv" in name)
        web.cut[lost] = 99
        with pytest.raises(CampaignError, match=r"_0009: .*broke off"):
            reduced(f"{web.url}/large", resume=tmp_path / "kept")
        web.cut.clear()
        far = reduced(
            f"{web.url}/large",
            resume=tmp_path / "kept",
            progress=lambda done, total, what: told.append(what),
        )
        assert {count for (how, _), count in web.asked.items() if how == "GET"} == {1, 7}
    assert "resumed: 9 of 10 runs were read before" in told
    assert everything(far) == everything(near)
    assert far.table.provenance["files"] == near.table.provenance["files"]


def reduced(place, **options):
    return pk.reduce_campaign(pk.open_campaign(place), structure="cubic", executor=1, **options)


@pytest.mark.slow
def test_commands_take_a_url_where_they_take_a_folder(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with served_web(FILES) as web:
        assert main(["export", web.url, "--to", "csv", "-o", "copy"]) == 0
        assert main(["check", f"{web.url}/campaign.toml"]) == 0
        assert main(["inspect", web.url]) == 1
    assert "Copy them to a folder" in capsys.readouterr().err
    there = pk.open_campaign(tmp_path / "copy")["SD"].data
    assert np.array_equal(there["Y"], [k / 3 for k in range(60)])


def test_a_path_of_this_machine_asks_for_no_package(tmp_path, monkeypatch):
    for name in ("fsspec", "aiohttp"):
        monkeypatch.setitem(sys.modules, name, None)
    campaign = pk.open_campaign(local(tmp_path / "kcs", FILES))
    assert campaign["SD"].data.sizes["t"] == 60
