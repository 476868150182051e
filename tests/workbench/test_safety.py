"""The server answers its own page alone; whatever else comes is refused, and nothing breaks."""

from __future__ import annotations

import os
import random
import socket
import stat
import time
from contextlib import closing, suppress

import pytest
from asgi import Browser, ask
from chromium import chromium, found
from served import served

from pmmkit.actions import action
from pmmkit.base import DataError
from pmmkit.workbench import Desk, guard
from pmmkit.workbench import application as serving
from pmmkit.workbench.application import application, forwarding, listening

PORT, TOKEN, KEY = 8175, "the-secret-of-the-cookie", "the-key-of-the-address"
HOST = (b"host", b"127.0.0.1:8175")
ORIGIN = (b"origin", b"http://127.0.0.1:8175")
COOKIE = (b"cookie", b"pmmkit_8175=" + TOKEN.encode())
LENGTH = (b"content-length", b"2")


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    named = tmp_path_factory.mktemp("named")
    own = Desk(tmp_path_factory.mktemp("state") / "workbench", [named], action)
    yield own
    own.close()


@pytest.fixture(scope="module")
def app(desk):
    return application(desk, TOKEN, PORT)


@pytest.fixture(scope="module")
def browser(app):
    return Browser(app, PORT, TOKEN)


def test_the_key_of_the_address_counts_once_and_gives_a_cookie(desk):
    app = application(desk, TOKEN, PORT, once=[KEY])
    answer = ask(app, f"/?token={KEY}", headers=[HOST])
    assert (answer.status, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"]
    assert cookie.startswith(f"pmmkit_8175={TOKEN};")
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    page = ask(app, "/", headers=[HOST, COOKIE])
    assert page.status == 200
    assert TOKEN not in page.text
    again = ask(app, f"/?token={KEY}", headers=[HOST])
    assert (again.status, "counts once" in again.text) == (403, True)
    assert ask(app, f"/?token={KEY}", headers=[HOST, COOKIE]).status == 303


def test_a_page_of_this_machine_leads_to_the_server_but_only_with_a_key(desk):
    app = application(desk, TOKEN, PORT, once=[KEY])
    other = (b"sec-fetch-site", b"cross-site")
    assert ask(app, "/?token=guess", headers=[HOST, COOKIE, other]).status == 403
    assert ask(app, f"/?token={KEY}", headers=[HOST, other], method="POST").status == 403
    assert ask(app, f"/api/state?token={KEY}", headers=[HOST, other]).status == 403
    page = ask(app, f"/?token={KEY}", headers=[HOST, other])
    assert (page.status, 'content="0; url=/"' in page.text) == (200, True)


def test_the_page_that_leads_to_the_server_is_read_by_its_owner_alone_and_goes(tmp_path):
    with forwarding(tmp_path / "bench", f"http://127.0.0.1:8175/?token={KEY}") as file:
        assert KEY in file.read_text()
        assert os.name == "nt" or stat.S_IMODE(file.stat().st_mode) == 0o600
    assert not (tmp_path / "bench").exists()


@pytest.mark.skipif(not found(), reason="no Chromium on this machine")
def test_a_browser_that_opens_the_page_of_the_folder_gets_in(desk, tmp_path):
    with (
        served(desk) as address,
        forwarding(tmp_path, address) as file,
        chromium(found(), tmp_path / "profile") as page,
    ):
        page.open(file.as_uri())
        assert page.wait("document.querySelector('main') && location.search === ''")


def test_half_a_request_is_closed_and_an_upload_that_breaks_off_is_one_line(
    desk, monkeypatch, capfd
):
    for module in (guard, serving):
        monkeypatch.setattr(module, "PATIENCE", 0.3)
    with served(desk) as address:
        port = int(address.rpartition(":")[2].partition("/")[0])
        with socket.create_connection(("127.0.0.1", port)) as half:
            half.sendall(b"GET / HTTP/1.1\r\nHost: ")
            half.settimeout(10)
            with suppress(ConnectionResetError):
                assert half.recv(100) == b""
        begun = (
            f"POST /api/cancel HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
            f"Origin: http://127.0.0.1:{port}\r\nCookie: pmmkit_{port}=secret\r\n"
            "Content-Length: 1000\r\n\r\n{"
        ).encode()
        with socket.create_connection(("127.0.0.1", port)) as late:
            late.sendall(begun)
            late.settimeout(10)
            assert b" 408 " in late.recv(1000)
        with socket.create_connection(("127.0.0.1", port)) as broken:
            broken.sendall(begun)
        said, deadline = "", time.monotonic() + 10
        while said.count("\n") < 2 and time.monotonic() < deadline:
            time.sleep(0.02)
            said += capfd.readouterr().err
    assert said == 2 * "WARNING:  A request broke off; nothing of it was kept.\n"


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ([HOST], 403),
        ([HOST, (b"cookie", b"pmmkit_8175=guess")], 403),
        ([HOST, (b"cookie", b"pmmkit_8176=" + TOKEN.encode())], 403),
        ([HOST, (b"cookie", b"pmmkit_8175=\xff\xfe; =;;\x01")], 403),
        ([COOKIE], 421),
        ([(b"host", b"evil.example:8175"), COOKIE], 421),
        ([(b"host", b"127.0.0.1:9999"), COOKIE], 421),
        ([(b"host", b"127.0.0.1:8175.evil.example"), COOKIE], 421),
        ([HOST, COOKIE, (b"origin", b"http://evil.example")], 403),
        ([HOST, COOKIE, (b"origin", b"null")], 403),
        ([HOST, COOKIE, (b"origin", b"http://127.0.0.1:8176")], 403),
        ([HOST, COOKIE, (b"sec-fetch-site", b"cross-site")], 403),
    ],
)
def test_requests_that_do_not_come_from_the_page_are_refused(app, headers, status):
    for address in ("/", "/api/state", "/static/js/main.js"):
        assert ask(app, address, headers=headers).status == status


def test_what_changes_something_needs_the_origin_of_the_page_and_a_length(app):
    own = [HOST, COOKIE]
    assert ask(app, "/api/cancel", method="POST", headers=[*own, LENGTH], body=b"{}").status == 403
    assert ask(app, "/api/cancel", method="POST", headers=[*own, ORIGIN], body=b"{}").status == 411
    told = [*own, ORIGIN, LENGTH]
    assert ask(app, "/api/cancel", method="POST", headers=told, body=b"{}").status == 200
    long = [*own, ORIGIN, (b"content-length", b"99999999999")]
    assert ask(app, "/api/cancel", method="POST", headers=long).status == 413
    assert ask(app, "/api/cancel", headers=own).status == 405


def test_every_answer_forbids_what_is_not_its_own(app):
    for headers in ([HOST, COOKIE], [HOST], []):
        found = ask(app, "/", headers=headers).headers
        policy = found["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "http" not in policy
        assert found["x-content-type-options"] == "nosniff"
        assert found["referrer-policy"] == "no-referrer"


@pytest.mark.parametrize(
    "path",
    ["/etc", "/etc/passwd", "..", "../..", "~", "", "\0", "a" * 5000, "C:\\Windows", "//server/x"],
)
def test_nothing_outside_the_named_folders_is_opened(browser, desk, path):
    answer = browser.post("/api/open", {"campaign": path})
    assert answer.status == 400
    assert desk.state is None


def test_links_do_not_lead_out_of_a_named_folder(desk, tmp_path):
    link = desk.roots[0] / "inside"
    link.symlink_to(tmp_path, target_is_directory=True)
    with pytest.raises(DataError, match="outside the folders"):
        desk.named(str(link))
    assert desk.named(str(desk.roots[0] / "runs")) == desk.roots[0] / "runs"


def test_a_model_file_must_lie_in_a_named_folder_too(browser, datasets):
    asked = {"campaign": str(datasets / "s175"), "model": "/etc/passwd"}
    assert "outside the folders" in browser.post("/api/open", asked).json["error"]


@pytest.mark.parametrize(
    "path", ["/static/../guard.py", "/static/%2e%2e/guard.py", "/static//etc/passwd", "/static/.."]
)
def test_files_beside_the_page_are_not_served(browser, path):
    assert browser.get(path).status in (400, 404, 405)


def test_markup_in_what_is_asked_comes_back_as_json_alone(browser):
    answer = browser.post("/api/open", {"campaign": "<script>alert(1)</script>"})
    assert answer.headers["content-type"] == "application/json"


def test_malformed_requests_are_refused_and_nothing_breaks(app, browser):
    """Bytes of all kinds in the place of JSON, queries and headers, the same each time."""
    draw = random.Random(15)
    paths = ("open", "add", "undo", "diagnose", "sail", "cancel", "look", "campaign", "window")
    paths += ("unwindow", "again")
    reads = ("state", "misfit", "run", "missing", "fall", "turns", "range", "record", "nothing")
    pieces = (b"{}", b"[]", b"null", b'{"revision":', b"1e999", b'"\\ud800"', b"{" * 3000, b"\xff")
    for number in range(2000):
        body = draw.choice(pieces) + draw.randbytes(draw.randrange(12))
        if number % 2:
            length = (b"content-length", str(len(body)).encode())
            answer = ask(
                app,
                f"/api/{draw.choice(paths)}",
                method="POST",
                headers=[*browser.own, length],
                body=body,
            )
        else:
            query = draw.randbytes(6).hex() if number % 3 else "count=-1&run=%00"
            answer = browser.get(f"/api/{draw.choice(reads)}?{query}")
        assert answer.status in (200, 400, 404, 405, 409), (body, answer.text)
    assert browser.get("/api/state").json["opened"] is False


def test_a_second_server_takes_another_port():
    with closing(listening(None)) as first, closing(listening(None)) as second:
        ports = [channel.getsockname()[1] for channel in (first, second)]
        assert ports[0] != ports[1]
        assert {channel.getsockname()[0] for channel in (first, second)} == {"127.0.0.1"}
        with pytest.raises(DataError, match="--port"):
            listening(ports[0])
    with closing(socket.create_server(("127.0.0.1", 0))) as taken, pytest.raises(DataError):
        listening(taken.getsockname()[1])
