"""Axes and signs proposed from the physics of all runs: right, or left to a person."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit import open_campaign, reduce_campaign
from pmmkit.campaigns import Frame
from pmmkit.cli import main
from pmmkit.intake import examine
from pmmkit.intake.checks.physics import AskedSign, asked_signs
from pmmkit.intake.drafts.conventions import ranked
from pmmkit.intake.drafts.propose import summaries_of
from tests.support.small_campaign import SHIP, write_campaign

ASKED = (
    ("Y", "drift", 1),
    ("N", "drift", 1),
    ("Y", "rudder", -1),
    ("N", "rudder", 1),
    ("Y", "sway", -1),
    ("N", "sway", -1),
    ("N", "yaw", -1),
    ("X", "ahead", -1),
)
FLIPS = ("X", "drift", "rudder", "sway", "yaw")


def seen_by(axes: str, flips: set[str], asked=ASKED, *, uncertain=()) -> list[AskedSign]:
    """The signs of a hull in a source with these axes and directions of counting."""
    frame = Frame(reversed_axes=axes)
    motions = {"sway": frame.sign("y"), "yaw": frame.sign("psi")}
    return [
        AskedSign(
            channel=channel,
            motion=motion,
            words="",
            value=right
            * frame.sign(channel)
            * motions.get(motion, 1)
            * (-1) ** len({channel, motion} & flips),
            std=1.0 if (channel, motion) in uncertain else 0.0,
            right=right,
            runs=("a", "b", "c"),
        )
        for channel, motion, right in asked
    ]


def same_derivatives(one, axes: str, flips: set[str]) -> bool:
    """Whether a proposal turns forces and motions as the truth, or all sideways ones besides."""

    def nets(axes, flips):
        frame = Frame(reversed_axes=axes)
        turned = {name: frame.sign(name) for name in ("Y", "N")}
        turned |= {"sway": frame.sign("y"), "yaw": frame.sign("psi"), "drift": 1, "rudder": 1}
        return [sign * (-1) ** (name in flips) for name, sign in turned.items()]

    sideways = [
        a * b for a, b in zip(nets(one.reversed_axes, one.flips), nets(axes, flips), strict=True)
    ]
    ahead = [("x" in x) ^ ("X" in y) for x, y in ((one.reversed_axes, one.flips), (axes, flips))]
    return len(set(sideways)) == 1 and ahead[0] == ahead[1]


@pytest.mark.slow
@given(
    st.sampled_from(["", "yz", "xz", "xy"]),
    st.sets(st.sampled_from(FLIPS)),
    st.booleans(),
    st.sets(st.sampled_from([(channel, motion) for channel, motion, _ in ASKED])),
)
def test_what_is_proposed_gives_the_derivatives_of_the_truth(axes, flips, computed, uncertain):
    """Whatever a source does, with some of the signs too weak: the same results, or no proposal."""
    flips = flips - {"X"} if "x" in axes else flips
    found = ranked(seen_by(axes, flips, uncertain=uncertain), computed=computed)
    if found.best is not None:
        seen = {sign.motion for sign in found.signs} | {sign.channel for sign in found.signs}
        hidden = {*FLIPS, "X"} - seen
        if not hidden:
            assert same_derivatives(found.best, axes, flips)
        assert not found.contradicted
    if not uncertain:
        assert found.best is not None


def test_nothing_is_proposed_where_a_moment_alone_is_against_physics():
    """Moments about a point far forward turn N over drift and sway, and no axis does so alone."""
    forward = [
        AskedSign(
            channel=sign.channel,
            motion=sign.motion,
            words="",
            value=-sign.value if (sign.channel, sign.motion) in turned else sign.value,
            std=0.0,
            right=sign.right,
            runs=sign.runs,
        )
        for turned in [{("N", "drift"), ("N", "sway")}]
        for sign in seen_by("", set())
    ]
    found = ranked(forward)
    assert found.best is None
    assert found.remaining


def test_nothing_is_proposed_without_certain_side_force_and_moment():
    found = ranked(seen_by("yz", set(), ASKED[:2], uncertain={("N", "drift")}))
    assert found.best is None
    assert not found.remaining


def test_a_contradiction_is_counted_and_not_proposed():
    """Y says that sway is counted the other way, N that it is not."""
    signs = seen_by("", set(), ASKED[:6])
    broken = [*signs[:4], *seen_by("", {"sway"}, ASKED[4:5]), signs[5]]
    found = ranked(broken)
    assert found.best is None
    assert found.remaining
    for item in found.remaining:
        assert not (item.flips <= {"sway"} and not item.reversed_axes) or found.contradicted


LINEAR = ["Xuu", "Xvv", "Yv", "Yvvv", "Yr", "Yvdot", "Yrdot", "Nv", "Nvvv", "Nr", "Nvdot", "Nrdot"]

SOURCES = {
    "as ours": {},
    "port and up": {"Y", "N", "sway", "yaw"},
    "aft and up": {"X", "N", "yaw"},
    "bow to port": {"drift"},
    "resistance": {"X"},
    "begun the other way": {"sway", "yaw"},
}
"""What a source counts the other way; drift angles are those of the ship unless they are named."""


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """Drift, sway and yaw at one speed."""
    folder = write_campaign(tmp_path_factory.mktemp("proposed") / "small", noise=0.3)
    whole = open_campaign(folder)
    kept = [run for run in whole if run.test != "yaw_drift" and run.settings.speed == 1.0]
    return whole.with_(runs=tuple(kept))


@pytest.fixture(scope="module")
def true(ours):
    return reduce_campaign(ours, structure=LINEAR, check=False).table


@pytest.mark.slow
@pytest.mark.parametrize("changed", SOURCES.values(), ids=SOURCES)
def test_the_draft_of_a_folder_gives_the_same_derivatives(ours, true, tmp_path, changed):
    """Names and numbers as a source with other signs would have them; ship and water typed in."""
    folder = tmp_path / "theirs"
    folder.mkdir()
    for run in ours:
        lines = run.loader.path.read_text().splitlines()
        names, rows = lines[0].split(","), [line.split(",") for line in lines[1:]]
        later = {"PS": "sway", "PY": "yaw"}.get(run.id[:2], "") in changed
        turned = [
            [
                f"{(-1) ** (name in changed) * float(cell)}"
                for name, cell in zip(names, row, strict=True)
            ]
            for row in rows
        ]
        name = run.id
        if later:
            half = len(turned) // 8
            turned = [
                [row[0], *other[1:]] for row, other in zip(turned, turned[half:], strict=False)
            ]
        if "drift" in changed:
            name = name.translate(str.maketrans("+-", "-+"))
        name = name.replace("_a", "_T12.5s_a").replace("_p", "_T12.5s_psi")
        text = "\n".join(map(",".join, [["Time [s]", "Fx [N]", "Fy [N]", "Mz [Nm]"], *turned]))
        (folder / f"{name}.csv").write_text(text + "\n")
    assert main(["new-campaign", str(folder)]) == 0
    path = folder / "campaign.toml"
    text = path.read_text()
    head, _, rest = text.partition("[ship]")
    path.write_text(head + SHIP + rest[rest.index("[water]") :])
    campaign = open_campaign(folder)
    assert 'TODO "balance"' not in text, "the runs say that the inertia is not inside"
    assert all(sign.verdict >= 0 for sign in asked_signs(campaign, summaries_of(campaign)))
    assert not [x for x in examine(campaign) if x.severity == "error"]
    found = reduce_campaign(campaign, structure=LINEAR, check=False).table
    for name in LINEAR:
        assert found[name][0] == pytest.approx(true[name][0], rel=0.1, abs=1e-4), name


def test_motions_that_begin_at_another_phase_are_asked_and_not_proposed(ours, tmp_path, capsys):
    """A quarter of a period later, damping shows as inertia and inertia as damping."""
    folder = tmp_path / "later"
    folder.mkdir()
    for run in ours:
        lines = run.loader.path.read_text().splitlines()
        rows = [line.split(",") for line in lines[1:]]
        quarter = 0 if run.id.startswith("SD") else len(rows) // 16
        rows = [[row[0], *other[1:]] for row, other in zip(rows, rows[quarter:], strict=False)]
        name = run.id.replace("_a", "_T12.5s_a").replace("_p", "_T12.5s_psi")
        text = "\n".join(map(",".join, [["Time [s]", "Fx [N]", "Fy [N]", "Mz [Nm]"], *rows]))
        (folder / f"{name}.csv").write_text(text + "\n")
    assert main(["new-campaign", str(folder)]) == 0
    assert "another phase (phase_deg)" in capsys.readouterr().out
    text = (folder / "campaign.toml").read_text()
    assert "phase_deg = 180" not in text.replace("(phase_deg = 180)", "")
    assert "against physics" in text
    told = " ".join(line.lstrip("# ") for line in text.splitlines() if line.startswith("#"))
    number = re.search(r"[YN]' (over the|from) [^;:]*? is -?[\d.]+", told)
    assert number is None, "forces are non-dimensional by a ship that nobody stated"
