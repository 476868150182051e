"""The lists of terms that the literature gives to each channel."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from pmmkit.base import UnknownNameError
from pmmkit.conventions import STRUCTURES, Structure, parse_derivative
from pmmkit.conventions.named_structures import GROUP
from pmmkit.testing.structures import check_structure


def words(text: str) -> set[str]:
    return set(text.split())


@pytest.mark.parametrize("name", STRUCTURES)
def test_every_structure_holds_the_contract(name):
    assert STRUCTURES[name].name == name
    check_structure(STRUCTURES[name])


def changed(**fields):
    return replace(STRUCTURES["cubic"], **fields)


@pytest.mark.parametrize(
    ("structure", "fault"),
    [
        (changed(name="my cubic"), "small letters"),
        (changed(derivatives=("Yvrv",)), "Yvrv is written Yvvr"),
        (changed(derivatives=("Yv", "Ywind")), "Ywind"),
        (changed(derivatives=("Yv", "Yv")), "comes twice"),
        (changed(derivatives=("Nv", "Yv")), "order of the channels"),
        (changed(system="bis"), "system is 'bis'"),
        (changed(sources=("nobody_1900",)), "'nobody_1900' is no key"),
        # instantaneous U: u'² = 1 - v'², so Yv and Yuuv differ by Yvvv
        (changed(derivatives=("Yv", "Yuuv", "Yvvv")), "no motion tells its terms in Y apart"),
    ],
)
def test_what_does_not_hold_is_said(structure, fault):
    with pytest.raises(AssertionError, match=fault):
        check_structure(structure)


def test_another_package_brings_a_structure(monkeypatch):
    mine = Structure(name="mine", derivatives=("Yv", "Nv"))
    other = Structure(name="cubic", derivatives=("Yv",))
    points = [
        SimpleNamespace(name="a", dist=SimpleNamespace(name="theirs"), load=lambda: mine),
        SimpleNamespace(name="b", dist=None, load=lambda: [other]),
        SimpleNamespace(name="c", dist=None, load=lambda: ["no structure"]),
    ]
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda group: points if group == GROUP else []
    )
    STRUCTURES.reload()
    try:
        with pytest.warns(UserWarning, match="is left out") as warned:
            assert STRUCTURES["mine"] is mine
        assert Structure.meant_by("mine").of("Y") == ("Yv",)
        assert STRUCTURES["cubic"].of("Y") != ("Yv",)
        assert [str(item.message) for item in warned] == [
            "pmmkit.structures 'b' of a package is left out: the name 'cubic' is taken",
            "pmmkit.structures 'c' of a package is left out: 'no structure' is no Structure",
        ]
    finally:
        STRUCTURES.reload()


@pytest.mark.parametrize(
    ("name", "count"),
    [("linear", 13), ("cubic", 17), ("abkowitz3", 21), ("modulus", 21), ("mmg", 22)],
)
def test_how_many_derivatives(name, count):
    assert len(STRUCTURES[name].derivatives) == count


def test_the_cubic_hull_of_abkowitz():
    assert set(STRUCTURES["abkowitz3"].of("N")) == words("Nv Nr Nvvv Nrrr Nvvr Nvrr Nvdot Nrdot")
    assert set(STRUCTURES["modulus"].of("Y")) == words("Yv Yr Yv|v| Yr|r| Yvvr Yvrr Yvdot Yrdot")


def test_son_and_nomoto_list_every_published_coefficient():
    published = words(
        "Xuu Xvr Xrr Xphiphi Xvv Yv Yr Yp Yphi Yvvv Yrrr Yvvr Yvrr Yvvphi Yvphiphi Yrrphi "
        "Yrphiphi Nv Nr Np Nphi Nvvv Nrrr Nvvr Nvrr Nvvphi Nvphiphi Nrrphi Nrphiphi Kv Kr Kp Kphi "
        "Kvvv Krrr Kvvr Kvrr Kvvphi Kvphiphi Krrphi Krphiphi"
    )
    assert published <= set(STRUCTURES["son-nomoto"].derivatives)


def test_the_mariner_lists_every_published_coefficient():
    published = words(
        "Xudot Yvdot Nvdot Xu Yrdot Nrdot Xuu Yv Nv Xuuu Yr Nr Xvv Yvvv Nvvv Xrr Yvvr Nvvr Xdd Yvu "
        "Nvu Xudd Yru Nru Xrv Yd Nd Xvd Yddd Nddd Xuvd Yud Nud Yuud Nuud Yvdd Nvdd Yvvd Nvvd Y0 N0 "
        "Y0u N0u Y0uu N0uu"
    )
    mariner = STRUCTURES["mariner"]
    assert {parse_derivative(name).name for name in published} == set(mariner.derivatives)
    assert mariner.surge == "delta-u"


def test_the_mmg_standard_has_the_fourth_order_in_drift_and_the_draught_in_its_unit():
    assert "Xvvvv" in STRUCTURES["mmg"].of("X")
    assert STRUCTURES["mmg"].system == "prime-d"


def test_more_terms_come_into_their_channel_once():
    more = STRUCTURES["linear"].with_("Yd", "Xrv", "Nd", "Yd")
    assert more.of("Y")[-1] == "Yd"
    assert more.of("X") == STRUCTURES["linear"].of("X")
    assert len(more.derivatives) == 15


def test_any_list_of_terms():
    expected = ("Xvr", "Yv|v|", "Nv")
    assert Structure.meant_by("Nv, Y|v|v Xrv,Nv").derivatives == expected
    assert Structure.meant_by(["Nv", "Yv|v|", "Xvr"]).derivatives == expected
    own = Structure(name="own", derivatives=("Yv",))
    assert Structure.meant_by(own) is own


@pytest.mark.parametrize("bad", ["abkowitz", "", " , ", [], ["Yv", "Yw"]])
def test_what_is_no_structure(bad):
    with pytest.raises(UnknownNameError, match="linear, cubic, abkowitz3"):
        Structure.meant_by(bad)
