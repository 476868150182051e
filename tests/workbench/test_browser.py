"""The page in a real Chromium: every place, by keyboard, nothing asked of other machines."""

from __future__ import annotations

import importlib.resources
import importlib.util
import json
import shlex
from types import SimpleNamespace

import pytest
from asgi import Browser
from chromium import chromium, found
from commands import said
from long_work import done
from served import served

from pmmkit.actions import action
from pmmkit.campaigns import open_campaign
from pmmkit.cli import main
from pmmkit.effects import CATALOGUE
from pmmkit.files import datasets_folder
from pmmkit.models import load_model
from pmmkit.presentation import Grid, Group, Picture, Section, Symbol
from pmmkit.reduction import reduce_campaign
from pmmkit.views import page_file, page_of
from pmmkit.views.pages.page_file import state_of
from pmmkit.views.pages.sections import told_page
from pmmkit.workbench import Desk, frozen_page
from pmmkit.workbench.application import application

pytestmark = pytest.mark.slow
PLACES = ("data", "derivatives", "where", "missing", "ship")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = found()
    if path is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    with chromium(path, tmp_path_factory.mktemp("profile")) as own:
        own.size(1440, 900)
        yield own


@pytest.fixture(scope="module")
def opened(page, looped, looped_desk):
    with served(looped_desk) as address:
        page.open(address)
        page.wait("document.querySelectorAll('td[role], .map td').length")
        yield page


@pytest.fixture(scope="module")
def asked_desk(place):
    """Asked what is missing, with nothing added yet."""
    desk = Desk(place / "asked", [place], action)
    browser = Browser(application(desk, "key", 8175), 8175, "key")
    done(browser, "open", campaign=str(place / "hidden.h5"), model=str(place / "model.toml"))
    done(browser, "diagnose")
    yield desk
    desk.close()


@pytest.fixture(scope="module")
def axe():
    """The script that looks for broken rules of accessibility."""
    if importlib.util.find_spec("axe_core_python") is None:
        pytest.skip("no axe-core on this machine: pip install axe-core-python")
    return (importlib.resources.files("axe_core_python") / "axe.min.js").read_text("utf-8")


def broken(page, axe):
    """Rules that the page breaks, each with the first place where it does."""
    page.run(f"{axe}; 0")
    found = page.run("axe.run().then(found => JSON.stringify(found.violations))")
    return [(item["id"], item["nodes"][0]["html"]) for item in json.loads(found)]


def settled(page):
    """Waits until nothing is being worked out."""
    page.wait("![...document.querySelectorAll('main [role=status]')].some(x => x.matches('p'))")
    words = "[...document.querySelectorAll('main p')].some(x => x.textContent === 'Computing …')"
    page.wait(f"!{words}")


def focused(page, selector):
    """Keys go to an element, as soon as it is drawn."""
    element = f"document.querySelector({selector!r})"
    page.wait(f"{element} && ({element}.focus(), document.activeElement === {element})")


def test_each_place_shows_itself_and_complains_of_nothing(opened):
    shows = {
        "data": ".card .spark path, .card",
        "derivatives": "main h2",
        "where": ".uplot canvas, .plot svg",
        "missing": "section[aria-label='How the error falls'] rect",
        "ship": ".slider",
    }
    for name in PLACES:
        opened.run(f"location.hash = '{name}'")
        assert opened.wait(f'document.querySelectorAll("{shows[name]}").length'), name
        settled(opened)
        assert opened.run("document.documentElement.scrollWidth <= innerWidth"), name
    assert opened.complaints == []


def test_nothing_is_asked_of_another_machine(opened):
    assert opened.requests
    outside = [x for x in opened.requests if not x.startswith(("http://127.0.0.1:", "data:"))]
    assert outside == []


def test_names_with_markup_are_shown_as_text(opened):
    assert opened.run("document.querySelector('h1').textContent") == "</script><b>hidden</b>"
    assert opened.run("document.querySelectorAll('h1 b').length") == 0


def test_the_map_is_walked_by_arrow_keys(opened):
    opened.key("3", "3")
    opened.wait(
        "location.hash === '#where' && document.querySelector('td[aria-selected=true]')?.title"
    )
    opened.run("document.querySelector('td[aria-selected=true]').focus()")
    before = opened.run("document.activeElement.title")
    opened.key("ArrowDown")
    opened.key("ArrowRight")
    after = opened.run("document.activeElement.title")
    assert after != before
    assert opened.run("document.activeElement.getAttribute('aria-selected')") == "true"
    assert opened.run("document.querySelectorAll('td[aria-selected=true]').length") == 1


def test_a_sentence_leads_to_its_worst_cell_by_enter(opened):
    opened.run("location.hash = 'where'")
    settled(opened)
    opened.run("document.querySelectorAll('.sentences button')[1].focus()")
    opened.key("Enter", "\r")
    marked = "document.querySelectorAll('td.marked').length"
    assert opened.wait(marked)
    assert opened.run(
        "document.activeElement === document.querySelector('td.marked[aria-selected=true]')"
    )
    told = opened.run(
        "document.querySelector('section[aria-label=Runs] [role=status]').textContent"
    )
    assert told == f"runs marked: {opened.run(marked)}"
    opened.run("document.querySelector('.sentences button[aria-pressed=true]').click()")
    assert opened.run(marked) == 0


def test_an_own_effect_is_checked_while_it_is_typed(opened):
    opened.run("location.hash = 'missing'")
    settled(opened)
    assert opened.wait("document.querySelector('textarea') !== null")  # the place is drawn late

    def typed(text):
        opened.run(
            f"(() => {{ const x = document.querySelector('textarea'); x.value = {text!r}; "
            "x.dispatchEvent(new Event('input')); })()"
        )

    typed("Y: v*w")
    assert "character" in opened.wait(
        "document.querySelector('#own-said pre') && document.querySelector('#own-said').textContent"
    )
    assert opened.run("document.querySelector('textarea').ariaInvalid") == "true"
    typed("Y: v*r*r")
    assert opened.wait("document.querySelector('#own-said').textContent.includes('Yvrr ≈')")
    assert opened.run("document.querySelector('textarea').ariaInvalid") == "false"
    assert opened.complaints == []


def test_a_turn_is_seen_in_motion_with_the_forces_of_each_effect(opened, axe):
    """By keys alone; it stays open where another angle is sailed, and plays to its end."""
    opened.run("location.hash = 'ship'")
    settled(opened)
    focused(opened, ".motion summary")
    opened.key("Enter", "\r")
    opened.wait("document.querySelectorAll('.motion .hull').length === 2")
    drawn = "[...document.querySelectorAll('.motion .hull, .motion .force')].map(x => x.outerHTML)"
    before = opened.run(drawn)
    focused(opened, ".motion input")
    for _ in range(20):
        opened.key("ArrowRight")
    after = opened.run(drawn)
    assert [x == y for x, y in zip(before, after, strict=True)] == [
        "hull" in x and place == 1 for place, x in enumerate(before)
    ]
    assert opened.run("document.querySelector('.motion output').textContent").startswith("t ")
    assert broken(opened, axe) == []
    focused(opened, ".motion button")
    opened.key("Enter", "\r")
    opened.wait("document.querySelector('.motion button').textContent === 'Pause'")
    opened.wait("Number(document.querySelector('.motion input').value) > 0")
    focused(opened, ".slider input")
    opened.key("ArrowLeft")
    settled(opened)
    assert opened.run("document.querySelector('.motion').open")
    assert opened.complaints == []


def test_keys_stay_in_the_motion_where_the_ships_around_come_late(opened):
    opened.run("location.hash = 'ship'")
    settled(opened)
    opened.run("window.drawn = document.querySelector('.motion')")
    focused(opened, ".slider input")
    opened.key("ArrowRight")
    focused(opened, ".motion summary")
    opened.wait("!window.drawn.isConnected")
    assert opened.run("document.activeElement === document.querySelector('.motion summary')")


def test_all_that_can_be_clicked_has_a_name_and_a_place_among_the_keys(opened):
    for name in PLACES:
        opened.run(f"location.hash = '{name}'")
        settled(opened)
        nameless = opened.run(
            "[...document.querySelectorAll('button, a, select, input, textarea, [role=img]')]"
            ".filter(x => !(x.textContent.trim() || x.ariaLabel || x.labels?.length))"
            ".map(x => x.outerHTML.slice(0, 90))"
        )
        assert nameless == [], name


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_of_accessibility_is_broken(opened, axe, scheme):
    opened.scheme(scheme)
    try:
        for name in PLACES:
            opened.run(f"location.hash = '{name}'")
            settled(opened)
            assert broken(opened, axe) == [], name
    finally:
        opened.scheme("light")


SIZES = """JSON.stringify([...document.querySelectorAll('.plot svg[viewBox]')].map(
    svg => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width))"""


@pytest.mark.parametrize(
    ("width", "scheme"), [(390, "dark"), (390, "light"), (1024, "light"), (1440, "dark")]
)
def test_places_fit_a_narrow_screen_and_the_dark(opened, width, scheme):
    opened.size(width, 844)
    opened.scheme(scheme)
    try:
        for name in PLACES:
            opened.run(f"location.hash = '{name}'")
            settled(opened)
            assert opened.run("document.documentElement.scrollWidth <= innerWidth"), name
            sizes = json.loads(opened.run(SIZES))
            assert all(0.65 < size < 1.4 for size in sizes), (name, "letters of plots")
        ground = opened.run("getComputedStyle(document.documentElement).backgroundColor")
        assert (ground == "rgb(15, 19, 23)") is (scheme == "dark")
    finally:
        opened.size(1440, 900)
        opened.scheme("light")


def test_the_file_opens_from_disk_with_the_same_plots(page, looped, looped_desk, tmp_path):
    file = tmp_path / "workbench.html"
    file.write_text(frozen_page(looped_desk), encoding="utf-8")
    page.open("about:blank")
    page.wait("location.href === 'about:blank'")
    page.complaints.clear()
    page.requests.clear()
    page.open(file.as_uri())
    page.wait("document.querySelectorAll('.map td').length")
    assert page.wait("document.querySelectorAll('.uplot canvas, .plot svg path').length")
    page.run("location.hash = 'missing'")
    bars = "[aria-label='How the error falls'] rect.bar"
    assert page.wait(f'document.querySelectorAll("{bars}").length') == 3
    assert (
        page.run("[...document.querySelectorAll('button')].some(x => x.textContent === 'Add')")
        is False
    )
    assert page.complaints == []
    assert {x for x in page.requests if not x.startswith(("file:", "data:"))} == set()


@pytest.fixture(scope="module")
def compared_page(page, place, tmp_path_factory):
    """The page of a comparison, opened from disk."""
    out = tmp_path_factory.mktemp("compared") / "out"
    asked = ["compare", str(place / "model.toml"), str(place / "hidden.h5"), "--no-figures"]
    assert main([*asked, "--out", str(out)]) == 0
    page.open("about:blank")
    page.wait("location.href === 'about:blank'")
    page.complaints.clear()
    page.requests.clear()
    page.open((out / "report.html").as_uri())
    page.wait("document.querySelectorAll('.map td').length")
    return page


def test_the_page_of_a_comparison_opens_from_disk_with_what_was_worked_out(compared_page):
    links = "[...document.querySelectorAll('nav a')].map(x => x.hash)"
    assert compared_page.run(links) == ["#data", "#where"]
    assert compared_page.wait("document.querySelectorAll('.uplot canvas').length")
    compared_page.run("document.querySelector('.told').closest('details').open = true")
    assert compared_page.run("document.querySelectorAll('.told table tbody tr').length") > 3
    compared_page.key("1", "1")
    assert compared_page.wait("document.querySelector('main h2')?.textContent").startswith("What")
    assert compared_page.run("getComputedStyle(document.querySelector('.rail')).display") == "none"
    assert compared_page.complaints == []
    assert {x for x in compared_page.requests if not x.startswith(("file:", "data:"))} == set()


def test_on_paper_all_places_stand_one_after_the_other(compared_page):
    compared_page.scheme("dark")
    try:
        compared_page.run("dispatchEvent(new Event('beforeprint'))")
        heads = "[...document.querySelectorAll('.chapter > h1')].map(x => x.textContent)"
        assert compared_page.run(heads) == ["Data", "Where it fails"]
        assert compared_page.wait("document.querySelectorAll('.book .uplot canvas').length")
        assert compared_page.run(
            "[...document.querySelectorAll('.book details')].every(x => x.open)"
        )
        ground = "getComputedStyle(document.querySelector('.book .panel')).backgroundColor"
        assert compared_page.run(ground) == "rgb(255, 255, 255)"
        compared_page.run("dispatchEvent(new Event('afterprint'))")
        assert compared_page.run("document.querySelectorAll('.book').length") == 0
        assert compared_page.run("document.documentElement.dataset.theme ?? ''") == ""
        assert compared_page.complaints == []
    finally:
        compared_page.scheme("light")


def test_what_is_told_is_shown_as_text_and_pictures_that_run_nothing(page, tmp_path):
    evil = "<img src=x onerror=\"document.title='run'\">"
    drawing = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20">{}</svg>'
    script = drawing.format("<script>document.title = 'run'</script><rect width='9' height='9'/>")
    drawn, empty = (SimpleNamespace(svg=lambda _, text=text: text) for text in (script, ""))
    section = Section(
        title=evil,
        paragraphs=[evil],
        findings=[{"severity": "warning", "check": evil, "message": evil}],
        tables=[Grid(head=["", evil], groups=[Group(rows=[[Symbol("N′", "vvr"), None]])])],
        figures=[Picture(figure=drawn, caption="drawn"), Picture(figure=empty, caption="no room")],
    )
    answers = {
        "state": state_of(title="Told", kind="captive", runs=1, model=""),
        "told data": told_page(facts={evil: evil}, before=[section], folded=[section]),
    }
    file = tmp_path / "told.html"
    file.write_text(page_file(answers), encoding="utf-8")
    page.open("about:blank")
    page.wait("location.href === 'about:blank'")
    page.complaints.clear()
    page.open(file.as_uri())
    assert page.wait("document.querySelector('.told img')?.naturalWidth") == 40
    assert page.run("document.querySelectorAll('img').length") == 2
    assert page.run("document.querySelector('.told h2').textContent") == evil
    assert page.run("document.querySelector('.symbol').textContent") == "N′vvr"
    assert page.run("document.querySelectorAll('figure')[1].textContent").startswith("This picture")
    assert page.run("document.title") == "Data · Told"
    assert page.complaints == []


def test_letters_beside_the_derivatives_keep_their_size_and_numbers_are_round(page, tmp_path):
    """Drawn for a panel of another width, they were half as large as those around them."""
    reduction = reduce_campaign(
        open_campaign(datasets_folder() / "s175"), structure="linear", fn="pooled"
    )
    answers = {
        "state": state_of(title="Letters", kind="captive", runs=len(reduction.runs), model=""),
        "derivatives": page_of(reduction),
    }
    file = tmp_path / "letters.html"
    file.write_text(page_file(answers), encoding="utf-8")
    page.open(f"{file.as_uri()}#derivatives")
    assert page.wait("document.querySelectorAll('.plot svg text').length")
    shown = "(svg => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width)"
    assert page.run(f"{shown}(document.querySelector('.plot svg'))") == pytest.approx(1, abs=0.02)
    texts = "[...document.querySelectorAll('.plot svg text')].map(x => x.textContent)"
    told = json.loads(page.run(f"JSON.stringify({texts})"))
    ticks = [x for x in told if x.strip("−.0123456789") == ""]
    assert len(ticks) > 2
    assert all(len(x.strip("−.0").replace(".", "")) < 3 for x in ticks)


def test_two_candidates_stand_side_by_side(page, asked_desk):
    with served(asked_desk) as address:
        page.open(address)
        page.wait("document.querySelectorAll('.map td').length")
        page.run("location.hash = 'missing'")
        page.wait("document.querySelectorAll('.tick input').length > 2")
        settled(page)
        ticked = "[...document.querySelectorAll('.tick input:checked')].map(x => x.value)"
        for number, expected in enumerate((1, 2, 2)):
            page.run(f"document.querySelectorAll('.tick input')[{number}].focus()")
            page.key(" ", " ")
            assert len(page.run(ticked)) == expected
        names = [CATALOGUE.title_of(x) for x in page.run(ticked)]
        heads = "[...document.querySelectorAll('.beside thead th[scope]')].map(x => x.textContent)"
        assert page.run(heads) == names
        assert page.run("document.querySelectorAll('.c-overlay, .c-second').length") == 2
        assert page.run("document.documentElement.scrollWidth <= innerWidth")


FALL = "section[aria-label='How the error falls']"


def errors(page, steps):
    """The errors of the waterfall when it has so many steps."""
    page.wait(f"document.querySelectorAll({FALL!r} + ' rect').length === {steps + 1}")
    settled(page)
    words = f"[...document.querySelectorAll({FALL!r} + ' svg text')].map(x => x.textContent)"
    return [x for x in page.run(words) if x.endswith("%")]


def tabbed(page, words, most=60):
    """Goes on by the tabulator to what has these words."""
    for _ in range(most):
        page.key("Tab")
        if page.run("document.activeElement.textContent") == words:
            return
    raise AssertionError(f"the tabulator does not come to {words}")


def test_the_loop_by_mouse_and_by_keys_alone_and_by_the_command_line(
    page, asked_desk, place, capsys
):
    """Point at a candidate, click it in, take it back, and again by keys: the same errors; the
    command that the page shows gives the same model."""
    with served(asked_desk) as address:
        page.open(address + "#missing")
        page.wait("document.querySelectorAll('.candidates button.primary').length")
        settled(page)
        first = "document.querySelector('.candidates button.primary')"
        name = page.run(f"{first}.closest('li').querySelector('.link').textContent")
        page.point(f"{first}.closest('li').querySelector('.summary')")
        assert page.wait("document.querySelector('.c-overlay')?.parentElement.textContent") == (
            f"with {name}"
        )
        page.point(first, click=True)
        by_mouse = errors(page, 1)
        page.point("document.querySelector('.rail button')", click=True)
        page.wait(f"!document.querySelector({FALL!r})")
        settled(page)
        page.run("document.activeElement.blur()")
        page.key("4", "4")
        tabbed(page, name)
        assert page.wait("document.querySelector('.c-overlay')?.parentElement.textContent") == (
            f"with {name}"
        )
        tabbed(page, "Add")
        page.key("Enter", "\r")
        by_keys = errors(page, 1)
        line = page.run("fetch('api/state').then(x => x.json()).then(x => x.commands.at(-1).line)")
        typed, made = shlex.split(line)[1:], place / "by_command.toml"
        typed[typed.index("replayed.toml")] = str(made)
        assert said(capsys, *typed)[0] == 0
        by_command = load_model(made)
        by_page = load_model(asked_desk.folder / "model_1.toml")
        tabbed(page, "Undo")
        page.key("Enter", "\r")
        page.wait(f"!document.querySelector({FALL!r})")
    assert by_mouse == by_keys
    assert float(by_keys[1].split()[0]) < float(by_keys[0].split()[0])
    for name, part in by_page.parts.items():
        assert by_command.parts[name].values == part.values, name


def test_candidates_break_no_rule_of_accessibility(page, asked_desk, axe):
    """And axe would say so: a picture without a name is found."""
    with served(asked_desk) as address:
        page.open(address + "#missing")
        page.wait("document.querySelectorAll('.tick input').length > 2")
        settled(page)
        page.run("[...document.querySelectorAll('.tick input')].slice(0, 2).map(x => x.click())")
        assert broken(page, axe) == []
        page.run("document.querySelector('main').append(document.createElement('img'))")
        assert [rule for rule, _ in broken(page, axe)] == ["image-alt"]
