"""The lists of terms that the literature gives to each channel."""

from __future__ import annotations

import pytest

from pmmkit.conventions import canonical
from pmmkit.errors import UnknownNameError
from pmmkit.structures import STRUCTURES, Structure, structure_of, terms


def words(text: str) -> set[str]:
    return set(text.split())


@pytest.mark.parametrize("name", STRUCTURES)
def test_names_are_canonical_each_once_and_grouped_by_channel(name):
    derivatives = STRUCTURES[name].derivatives
    assert list(derivatives) == [canonical(item) for item in derivatives]
    assert len(set(derivatives)) == len(derivatives)
    channels = [item[0] for item in derivatives]
    assert channels == sorted(channels, key="XYNK".index)


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
    assert {canonical(name) for name in published} == set(mariner.derivatives)
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
    assert structure_of("Nv, Y|v|v Xrv,Nv").derivatives == expected
    assert structure_of(["Nv", "Yv|v|", "Xvr"]).derivatives == expected
    own = Structure(name="own", derivatives=("Yv",))
    assert structure_of(own) is own
    assert terms(["Yvvr", "Y0"]) == (("v", "v", "r"), ("0",))


@pytest.mark.parametrize("bad", ["abkowitz", "", " , ", [], ["Yv", "Yw"]])
def test_what_is_no_structure(bad):
    with pytest.raises(UnknownNameError, match="linear, cubic, abkowitz3"):
        structure_of(bad)
