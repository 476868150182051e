"""Objects tell their own state: a line, a report, HTML that is escaped, figures."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.diagnosis import Fall
from pmmkit.diagnosis.loop.fall import FallRow
from pmmkit.diagnosis.loop.records import TOLD
from pmmkit.effects import CATALOGUE
from pmmkit.identification import Trial
from pmmkit.identification.trials.table import Wind
from pmmkit.models import Part, Step
from pmmkit.plotting import Figure
from pmmkit.presentation import Described
from pmmkit.reduction import Parts
from pmmkit.seakeeping import Loading, Operability, RollDamping, superposed
from pmmkit.seakeeping.explanation import explained
from pmmkit.seakeeping.measured import MeasuredTransfer, beside
from pmmkit.simulation import Track
from pmmkit.views import form_of_model
from pmmkit.views.report.captive.document import Chapter, Document, Item

ROOT = Path(__file__).parents[2]
EVIL = '<script>alert("x")</script> & two\nlines\x1b[31m'
SHIP = "s175-3dof"
pytestmark = pytest.mark.xdist_group("objects")  # one worker makes each of them once


@cache
def track():
    return replace(pk.simulate(SHIP, speed=9.0, compiled=False), notes=("mind the gap",))


@cache
def card():
    whole = pk.Card.of(SHIP, 9.0)
    return replace(whole, tests=whole.tests[:1])


@cache
def ensemble():
    return pk.monte_carlo(SHIP, speed=9.0, n=20, spread=0.05)


@cache
def session():
    runs = pk.open_campaign(ROOT / "datasets" / "s175").select("static_drift", "pure_yaw")
    return pk.begin("linear", replace(runs, title=f"{runs.title} <tank>"))


@cache
def diagnosis():
    return session().diagnose()


@cache
def added():
    return session().add(diagnosis().findings[0], "it is large")


def document():
    item = Item(what="Customer", value=None, table="report", key="customer")
    chapter = Chapter(title="Ship model", items=[item])
    basis = ["It is structured after a procedure."]
    return Document(title="Tests", subtitle="Report", items=[], basis=basis, chapters=[chapter])


@cache
def reduction():
    runs = pk.open_campaign(ROOT / "datasets" / "s175")
    left = replace(runs, excluded=((runs.runs[0], "wet <gauge>"),))
    return pk.reduce_campaign(left, structure="cubic")


def grid_study():
    """Of one derivative that converges, and one that oscillates."""
    water = pk.Water()
    values = [{"Yv": -0.01 - 0.001 * h**2, "Nv": 0.01 * (h % 4)} for h in (1.0, 2.0, 4.0)]
    tables = [pk.from_values(x, ship=pk.load_ship(SHIP), water=water) for x in values]
    return pk.grid_study(tables, (1.0, 2.0, 4.0))


@cache
def model():
    return pk.to_model(reduction().table, parts=SHIP)


@cache
def identified():
    truth = pk.load_model("kvlcc2-l7")
    sailed = pk.simulate(truth, "zigzag", speed=1.179, rudder_deg=20, switch_deg=20, dt=0.5)
    measured = {name: getattr(sailed, name) for name in ("x", "y", "psi")}
    record = pk.FreeRecord(
        name="z", t=sailed.t, delta=sailed.delta, turns=sailed.n, speed=1.179, measured=measured
    )
    start = truth.with_values("hull_polynomial", Nv=-0.12, Nr=-0.055)
    sensors = {"x": 0.01, "y": 0.01, "psi": 0.001}
    return pk.compare_methods(
        start, [record], ["Nv", "Nr", "Yrrr"], methods=("ekf", "regression"), sensors=sensors
    )


@cache
def trial():
    path = np.arange(5.0)
    return Trial(
        run="T1",
        manoeuvre="turning",
        Fn=0.142,
        name="tanker",
        L=320.0,
        speed=7.97,
        speed_std=0.02,
        heading_deg=31.0,
        rudder_deg=35.0,
        order=1120.0,
        orders=(1120.0,),
        metrics={
            "advance": 1040.0,
            "advance_L": 3.25,
            "transfer_L": 1.5,
            "tactical_diameter_L": math.nan,
        },
        std={
            "advance": 8.0,
            "advance_L": 0.025,
            "transfer_L": 0.02,
            "tactical_diameter_L": math.nan,
        },
        verdicts=(pk.imo_turning(track())[0],),
        wind=Wind(speed=5.0, direction_deg=270.0, spread=1.2),
        notes=("fixes jump",),
        **dict.fromkeys(("t", *Track.CHANNELS, "x_ground", "y_ground"), path),
    )


@cache
def hull():
    return pk.hull_from_particulars(name="ship", L=100.0, B=18.0, d=6.0, block=0.7)


@cache
def waved():
    return pk.rao(hull(), speeds=[0.0, 5.0], omega=np.linspace(0.3, 2.0, 30))


def heave_of(size):
    """A tank that measured so many times the heave that was computed."""
    heave = np.abs(waved().mode("heave")[1, 0])
    encounter = waved().encounter[1, 0]
    return MeasuredTransfer(
        encounter=encounter, transfer=size * heave + 0j, std=0.01 * heave + 1e-12
    )


@cache
def beaten():
    return beside(heave_of(1.02), waved(), "heave", speed=5.0)


@cache
def accounted():
    return explained({"heave": heave_of(1.3)}, waved(), speed=5.0)


@cache
def judged():
    return Operability.of(waved(), pk.sea("bretschneider", Hs=3.0, Tp=8.0))


@cache
def damped():
    ship = pk.hull_from_particulars(name="ship", L=175.0, B=25.4, d=9.5, block=0.57, midship=0.966)
    return RollDamping.of(ship, Loading.of(ship, GM=1.0))


@cache
def answered():
    bow = pk.Place(name="bow", x=45.0, freeboard=5.0, draught=6.0)
    waves = pk.sea("bretschneider", Hs=3.0, Tp=8.0)
    return pk.response(waved(), waves, speed=5.0, places=[bow])


@cache
def swaying():
    waves = pk.sea("bretschneider", Hs=3.0, Tp=8.0)
    found = pk.rao(hull(), speeds=9.0, headings_deg=[0.0, 90.0, 180.0], sea=waves)
    return superposed(track(), found, waves, seed=5)


@cache
def parts():
    screw = Part(effect="propeller", values={"D": 0.2, "wp": 0.35}, source="measured: tank <2>")
    blade = Part(effect="rudder_mmg", values={"area": 0.05}, source="library: a ship")
    return Parts(
        propeller=screw, rudder=blade, std={"wp": 0.01}, notes=("C1 is assumed",), runs={"wake": 7}
    )


def joint_fall():
    """Of captive tests and of records, a fault of the records among the steps."""
    steps = (
        Step(action="effect_added", effect="asymmetry"),
        Step(action="fault_corrected", effect="current", campaign="sea <2>"),
    )
    tank = added().fall()
    names = {step.effect: steps[0].effect for step in tank.added}
    before = {"position": (0.3, "m"), "heading": (2.0, "deg"), "yaw_rate": (0.2, "deg/s")}
    sea = [
        FallRow(
            step=step,
            campaign="sea <2>",
            group="all",
            quantity=quantity,
            error=error * factor,
            level=0.1,
            unit=unit,
        )
        for step, factor in (("base", 1.0), ("asymmetry", 0.5), ("current", 0.5))
        for quantity, (error, unit) in before.items()
    ]
    rows = (replace(x, step=names.get(x.step, x.step), campaign="tank <1>") for x in tank.rows)
    return Fall(
        added=steps,
        rows=(*rows, *sea),
        told={"tank <1>": tank.told[tank.campaigns[0]], "sea <2>": TOLD},
    )


MADE = {
    "Effect": lambda: CATALOGUE["crossflow_drag"],
    "Trial": trial,
    "Parts": parts,
    "DerivativeTable": cache(lambda: reduction().table),
    "Reduction": reduction,
    "Document": document,
    "Estimate": cache(lambda: reduction().estimates["regression"]),
    "Budget": cache(lambda: pk.derivative_budget(reduction())),
    "GridUncertainty": lambda: pk.grid_uncertainty([0.9705, 0.96854, 0.96178], [1, 2, 4]),
    "GridStudy": grid_study,
    "Campaign": cache(lambda: reduction().campaign),
    "Run": cache(lambda: reduction().campaign.runs[-1]),
    "Model": model,
    "Comparison": cache(lambda: pk.compare(model(), reduction().campaign)),
    "JointComparison": cache(
        lambda: pk.compare(model(), {EVIL: reduction().campaign, "sea": reduction().campaign})
    ),
    "MethodComparison": identified,
    "Identified": cache(lambda: identified().found["ekf"]),
    "Session": added,
    "Fall": joint_fall,
    "Diagnosis": diagnosis,
    "Together": cache(
        lambda: pk.begin(
            pk.load_model("s175-3dof"), {"tank <1>": session().evidence.campaign}
        ).diagnose()
    ),
    "Finding": cache(lambda: diagnosis().findings[0]),
    "Track": track,
    "Ensemble": ensemble,
    "Sensitivities": cache(lambda: pk.sensitivities(SHIP, speed=9.0, spread=0.05)),
    "SobolIndices": cache(lambda: pk.sobol(SHIP, speed=9.0, spread=0.05, n=4)),
    "Stability": cache(lambda: pk.stability(SHIP, 9.0)),
    "SpiralCurve": cache(lambda: pk.spiral_curve("kvlcc2", 7.97)),
    "Verdict": cache(lambda: pk.imo_turning(track())[0]),
    "ImoForm": cache(lambda: form_of_model(model(), [pk.imo_turning(track())[0]], speed=9.0)),
    "Card": card,
    "CardFit": cache(lambda: pk.ship_from_card(card(), ships=20)),
    "Hull": hull,
    "Rao": waved,
    "Response": answered,
    "RollDamping": damped,
    "Operability": judged,
    "RaoComparison": beaten,
    "Explained": accounted,
    "AddedResistance": lambda: pk.added_resistance(waved()),
    "MotionInWaves": swaying,
    "Sea": lambda: pk.sea("ittc", Hs=4.0, T1=8.0),
    "FroudeRange": cache(
        lambda: pk.simulate(model(), speed=9.0, fn="instant", compiled=False).tested
    ),
}
LONG = (
    "CardFit",
    "Comparison",
    "JointComparison",
    "MethodComparison",
    "Identified",
    "SobolIndices",
)
EACH = [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in MADE]
SAID = {
    "Effect": ("Hooft", "free running", "CD", "required", "0.55", "To be sure"),
    "Trial": ("T1", "1040.0 m", "3.25 L", "4.5 L", "met", "5.0 m/s from 270°", "fixes jump"),
    "Parts": ("0.350 ± 0.020", "tank <2>", "7 runs", "C1 is assumed"),
    "DerivativeTable": ("Fn 0.217", "10³", "±", "½ρL²U²", "midship", "Yaw moment N", "regression"),
    "Document": ("structured after", "1 Ship model", "2 What was not", "[report] customer"),
    "Estimate": ("by global regression", "±", "Derivatives"),
    "Reduction": ("63 runs", "wet <gauge>", "±", "Checks", "static drift"),
    "Budget": ("12 sources", "Fn 0.217", "gauge of X: zero", "noise", "Not stated", "scale effect"),
    "GridUncertainty": ("0.9705 ± 0.001", "1.79", "1.25", "0.9713"),
    "GridStudy": ("1 derivative, 1 refused", "Yv", "95 %", "oscillate"),
    "Campaign": ("static drift", "27", "0.145, 0.217, 0.290", "wet <gauge>", "999.1", "Y_gauge"),
    "Run": ("yaw with drift", "m/s", "T ", "runs.h5"),
    "Model": ("measured: S175", "library: Son", "±", "D = 6.533 m", "joined", "6.00 to 12.00 m/s"),
    "Comparison": ("over measured", "[N m]", "k = 2", "27 of 27", "stands out"),
    "JointComparison": ("over uncertainty", "every run", "all", "18 of 18", "sea: Root mean"),
    "MethodComparison": ("prior", "ekf", "regression", "±", "Notes"),
    "Identified": ("prior", "ekf", "±", "passes"),
    "Session": ("<tank>", "Steps", "evidence", "it is large", "0.5 %"),
    "Fall": (
        *("tank <1>: force [%]", "sea <2>: heading [deg]", "+ current (sea <2>)"),
        *("base", "noise alone", "-50 %", "better in"),
    ),
    "Together": ("Verdict: ", "tank <1>", "price off", "odds of 1 to 80"),
    "Diagnosis": ("Verdict: An effect is missing.", "±", "usual size", "could not show", "hide"),
    "Finding": ("Evidence", "±", "usual size", "Error of what was left out"),
    "Track": ("35.0°", "601.9", "3.439 L", "mind the gap", "rad/s", "self-propulsion"),
    "Ensemble": ("20 ships", "5 %", "seed 0", "tactical_diameter_L", "97.5 %"),
    "Sensitivities": ("tactical_diameter_L", "Nr", "share of the variance", "first 10 of 21"),
    "SobolIndices": ("Nr", "alone", "with all others"),
    "Stability": ("stable", "lever_yaw", "Eigenvalues"),
    "SpiralCurve": ("0.39°", "rudder [deg]", "no"),
    "Verdict": ("advance", "3.44 L", "4.5 L", "met", "MSC.137", "both sides"),
    "ImoForm": ("predicted", "not supplied", "draughts", "3.44 L", "MSC/Circ.1053", "none, as sim"),
    "Card": ("advance", "3.44 ± 0.34 L", "turning 35°, to starboard", "block coefficient"),
    "CardFit": ("missed", "before", "cannot tell", "It tells most of", "20/20, to port"),
    "Hull": ("41 stations", "block coefficient", "metacentre", "not the ship's"),
    "Rao": ("30 frequencies", "heave [m/m]", "180°", "GM is assumed"),
    "Response": ("heave [m]", "bow", "ISO 2631-1", "an hour", "energy of the sea"),
    "RaoComparison": ("heave of ship", "measured", "+2.0"),
    "Explained": ("radius of gyration in pitch", "Misfit as given", "best", "25"),
    "Operability": ("roll_deg", "Allowed", "180°", "Hs 3 m"),
    "RollDamping": ("of critical", "eddies", "lift", "roll_quadratic"),
    "AddedResistance": ("SNNM", "leaves out", "reflection", "180°"),
    "MotionInWaves": ("from 0°", "seed 5", "heave", "2σ", "bow down"),
    "Sea": ("ittc", "Hs 4 m", "10.4", "T1 [s]", "rough"),
    "FroudeRange": ("Fn 0.145 to 0.290", "% of", "below", "held at Fn 0.145"),
}
DRAWN = (
    "Trial",
    "Budget",
    "Run",
    "Campaign",
    "Reduction",
    "DerivativeTable",
    "Fall",
    "Diagnosis",
    "Track",
    "Ensemble",
    "Sensitivities",
    "SpiralCurve",
)


def spoiled(thing):
    """The same with a hostile text in each of its texts."""
    assert is_dataclass(thing)
    texts = {
        field.name: EVIL
        for field in fields(thing)
        if field.name in ("name", "title", "scale", "origin", "campaign", "effect", "summary", "id")
        and isinstance(getattr(thing, field.name), str)
    }
    notes = {"notes": (EVIL,)} if hasattr(thing, "notes") else {}
    if isinstance(thing, pk.Model):
        notes["steps"] = (Step(action="noted", note=EVIL),)
    return replace(thing, **texts, **notes)


def every_class(kind=Described):
    for below in kind.__subclasses__():
        yield below
        yield from every_class(below)


def test_every_public_object_that_tells_its_state_is_tried_here():
    for name in pk.__all__:
        getattr(pk, name)
    named = {kind.__name__ for kind in every_class() if kind.__module__.startswith("pmmkit.")}
    assert named == set(MADE) == set(SAID)


@pytest.mark.parametrize("name", EACH)
def test_repr_is_one_short_line(name):
    for thing in (MADE[name](), spoiled(MADE[name]())):
        text = repr(thing)
        assert text.startswith(f"<{name} ")
        assert text.endswith(">")
        assert text.isprintable()
        assert len(text) < 120


@pytest.mark.parametrize("name", EACH)
def test_str_says_what_a_reader_must_know(name):
    text = str(MADE[name]())
    assert [word for word in SAID[name] if word not in text] == []
    assert len(text.splitlines()) < 120


@pytest.mark.parametrize("name", EACH)
def test_html_is_well_formed_and_escaped(name):
    """It holds what the text holds, and nothing of a name from a file becomes an element."""
    thing = spoiled(MADE[name]())
    tree = ElementTree.fromstring(thing._repr_html_())
    known = {"div", "style", "h3", "p", "ul", "li", "table", "caption"}
    known |= {"thead", "tbody", "tr", "th", "td"}
    assert {element.tag for element in tree.iter()} <= known
    assert len(tree.findall(".//style")) == 1
    told = " ".join("".join(tree.itertext()).split())
    for words in str(thing).split():
        assert words in told or words == "-"
    assert "\x1b" not in str(thing)


def test_a_track_of_ones_own_is_told_as_well():
    own = replace(track(), manoeuvre="my own", metrics={"swing": 3.0})
    assert "swing" in str(own)
    assert set(own.figures()) == {"path", "histories"}


def test_an_effect_that_was_not_asked_has_no_evidence():
    """The runs lack what it needs: it is covered, and in no set that was looked at."""
    found = diagnosis()
    table = replace(found, entries=found.entries[:1]).to_pandas()
    assert len(table) == len(found.covered)
    assert table["log_evidence"].isna().sum() >= len(found.covered) - 1


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_plot_gives_a_figure(name):
    figure = MADE[name]().plot()
    assert isinstance(figure, Figure)
    assert figure.axes


@pytest.mark.slow
def test_plots_need_no_matplotlib_and_pictures_leave_its_settings_alone(tmp_path):
    code = f"""
import sys, pmmkit
figure = pmmkit.simulate({SHIP!r}, speed=9.0, compiled=False).plot()
assert figure._repr_svg_()
assert "matplotlib" not in sys.modules
import matplotlib
def looks():
    return {{name: matplotlib.rcParams[name] for name in matplotlib.rcParams if name != "backend"}}
before = looks()
figure.save({str(tmp_path / "turn.png")!r})
assert looks() == before
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("manoeuvre", ["turning", "zigzag", "spiral", "stopping", "pull_out"])
def test_every_manoeuvre_has_its_figures(manoeuvre):
    found = pk.simulate(SHIP, manoeuvre, speed=9.0, compiled=False).figures()
    assert found
    assert all(isinstance(figure, Figure) for figure in found.values())
