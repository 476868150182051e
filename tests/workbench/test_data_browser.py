"""Files are dropped, a guess is corrected and a window is drawn in a real Chromium, by keyboard."""

from __future__ import annotations

import pytest
from chromium import chromium, found
from served import served
from strange_tank import ANSWERS, write_files

from pmmkit import open_campaign
from pmmkit.actions import action
from pmmkit.workbench import Desk

pytestmark = pytest.mark.slow
SIGN = "select[name='sign run001.csv 4']"


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    named = tmp_path_factory.mktemp("named")
    own = Desk(named / "workbench", [named], action)
    # What other places look at first is not asked here.
    own.warm = lambda: None
    yield own
    own.close()


@pytest.fixture(scope="module")
def page(tmp_path_factory, desk):
    path = found()
    if path is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    with chromium(path, tmp_path_factory.mktemp("profile")) as own, served(desk) as address:
        own.size(1440, 900)
        own.open(address)
        own.wait("!!document.querySelector('.drop')")
        yield own


def button(text):
    return f"[...document.querySelectorAll('button')].find(x => x.textContent === '{text}')"


def typed(page, name, text):
    page.run(
        f"(() => {{ const x = document.getElementsByName('answer {name}')[0]; x.value = '{text}'; "
        "x.dispatchEvent(new Event('input')); })()"
    )


def test_from_a_strangers_files_to_a_window_with_its_reason(page, desk, tmp_path):
    page.choose("#files", write_files(tmp_path / "<b>tank</b>"))
    page.wait("document.querySelectorAll('.channel path').length === 6")
    page.run(
        f"(() => {{ const x = document.querySelector(\"{SIGN}\"); x.focus(); x.value = '-1'; "
        "x.dispatchEvent(new Event('change')); })()"
    )
    page.wait("document.querySelector('pre').textContent.includes('scale = -1.0')")
    assert page.run("document.activeElement.name") == "sign run001.csv 4", "the focus stays"
    page.run(
        f"(() => {{ const x = document.querySelector(\"{SIGN}\"); x.value = '1'; "
        "x.dispatchEvent(new Event('change')); })()"
    )
    page.wait("!document.querySelector('pre').textContent.includes('scale = -1.0')")
    for name, text in {**ANSWERS, "ship.d": "deep"}.items():
        typed(page, name, text)
    fault = "document.getElementById('answer ship.d said').textContent"
    assert "number" in page.wait(f"{fault}.includes('number') && {fault}")
    assert page.run("document.getElementsByName('answer ship.d')[0].ariaInvalid") == "true"
    typed(page, "ship.d", ANSWERS["ship.d"])
    page.wait(f"!{button('Write the campaign file')}.disabled")
    page.run(f"{button('Write the campaign file')}.click()")
    page.wait("!!document.querySelector('select[name=base]')")
    assert page.complaints == []
    place = desk.folder / "dropped"
    assert len(open_campaign(place)) == 3
    page.run("document.querySelector('select[name=base]').value = 's175-3dof'")
    page.run("document.querySelector('select[name=base]').dispatchEvent(new Event('change'))")
    page.run(
        "document.querySelector('section[aria-label=\"The campaign file\"] .line .primary').click()"
    )
    page.wait("document.querySelectorAll('nav a').length")
    page.run("location.hash = 'data'")
    page.wait("document.querySelectorAll('.card .small-button').length === 3")
    page.run("document.querySelector('.card .small-button').focus()")
    page.key("Enter", "\r")
    page.wait("document.querySelectorAll('dialog svg.draggable').length")
    page.run("document.querySelector('dialog input[type=range]').focus()")
    before = page.run("Number(document.activeElement.value)")
    page.key("PageUp")
    assert page.run("Number(document.activeElement.value)") > before
    assert page.run(f"{button('Write the window')}.disabled") is True, "no reason yet"
    page.run(
        "(() => { const x = document.querySelector('dialog input[type=text]'); "
        "x.value = 'it shook'; x.dispatchEvent(new Event('input')); })()"
    )
    page.run(f"{button('Write the window')}.click()")
    page.wait("!document.querySelector('dialog') && !!document.querySelector('.message.old')")
    (stated,) = open_campaign(place)["run001"].corrections
    assert (stated.action, stated.reason) == ("window", "it shook")
    page.run("location.hash = 'where'; location.hash = 'data'")
    assert page.wait(f"!!{button('Do it anew')}")
    assert page.run("document.documentElement.scrollWidth <= innerWidth")
    assert page.complaints == []


def test_a_folder_is_dropped_with_those_inside(page, tmp_path):
    folder = tmp_path / "Tank 7"
    write_files(folder / "drift")
    (folder / ".git").mkdir()
    (folder / ".git" / "config").write_text("[core]")
    (folder / "read me.txt").write_text("Breadth at the waterline 0.7 m")
    own = Desk(tmp_path / "workbench", [tmp_path], action)
    with served(own) as address:
        page.open(address)
        page.wait("!!document.querySelector('.drop')")
        page.drop("document.querySelector('.drop')", [folder])
        page.wait("document.querySelectorAll('.channel path').length === 6")
        title = "document.getElementsByName('answer campaign.title')[0].value"
        assert page.run(title) == "Tank 7"
        assert page.complaints == []
    own.close()
    place = own.folder / "dropped"
    kept = {x.relative_to(place).as_posix() for x in place.rglob("*") if x.is_file()}
    assert kept == {"read me.txt", *(f"drift/run00{n}.csv" for n in (1, 2, 3))}
