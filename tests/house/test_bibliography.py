"""What the package quotes stands in the bibliography, and nothing else does."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest

import pmmkit as pk
from pmmkit import catalogue
from pmmkit.base import UnknownNameError
from pmmkit.conventions import bibliography, bibtex, cite
from pmmkit.models import estimate, estimated_model, load_model, load_ship, ships
from pmmkit.models.empirical import METHODS, RUDDER_SOURCES

ROOT = Path(__file__).parents[2]
TEXTS = {
    path: path.read_text(encoding="utf-8")
    for folder, endings in (("pmmkit", ("py",)), ("datasets", ("toml", "md")), ("docs", ("md",)))
    for ending in endings
    for path in sorted((ROOT / folder).rglob(f"*.{ending}"))
}
NOT_SOURCES = {"July", "Foundation"}
"""Words before a year that are no author."""
YEAR = r"(?:19|20)\d\d"
QUOTATION = re.compile(rf"([A-ZÅØÖ][\w-]*[a-z])(?:'s)?(?: et al\.?)?,?\s+\(?({YEAR})(?![-\d])\)?")


def one_line(text: str) -> str:
    """A text without its line breaks, those of comments and of joined strings too."""
    return re.sub(r"\s+(#\s*)?", " ", re.sub(r'"\s*\n\s*f?"', "", text))


def quotations(text: str) -> set[tuple[str, str]]:
    """Last name and year of what a text quotes."""
    joined = one_line(text)
    return {(name, year) for name, year in QUOTATION.findall(joined) if name not in NOT_SOURCES}


def last_names(key: str) -> set[tuple[str, str]]:
    entry = bibliography()[key]
    return {(family.split()[-1], str(entry.year)) for family in entry.families}


LINES = " ".join(map(one_line, TEXTS.values()))
QUOTED = {found for text in TEXTS.values() for found in quotations(text)}


@pytest.mark.parametrize("key", bibliography())
def test_an_entry_is_whole(key):
    entry = bibliography()[key]
    assert entry.known in {"read", "quoted", "unseen"}
    assert entry.kind in {"article", "book", "inproceedings", "misc", "phdthesis", "techreport"}
    assert entry.title or entry.note
    assert not entry.doi or re.fullmatch(r"10\.\d{4,9}/[-._;()/:A-Za-z0-9]+", entry.doi)
    assert not entry.url or entry.url.startswith("https://")
    assert not entry.pages or re.fullmatch(r"\d+(--\d+)?", entry.pages)
    assert entry.short or (entry.author and entry.year)
    if not entry.short:
        assert key == expected_key(key)


def expected_key(key: str) -> str:
    families = [name for name in bibliography()[key].families if name != "others"]
    several = len(families) > 3
    names = "_".join(families[:1] if several else families)
    plain = unicodedata.normalize("NFKD", names.replace("ø", "o")).encode("ascii", "ignore")
    return re.sub(r"[^a-z]+", "_", f"{plain.decode().lower()}") + f"_{bibliography()[key].year}"


@pytest.mark.parametrize("key", [key for key in bibliography() if key != "pmmkit"])
def test_every_entry_is_quoted(key):
    told = (f'"{key}"', bibliography()[key].cited)
    assert last_names(key) & QUOTED or any(word in LINES for word in told)


@pytest.mark.parametrize(
    "path", [path for path in TEXTS if quotations(TEXTS[path])], ids=lambda path: path.name
)
def test_every_quotation_has_its_entry(path):
    known = {pair for key in bibliography() for pair in last_names(key)}
    assert quotations(TEXTS[path]) <= known


def test_quotations_are_found():
    text = (
        "Hirano et al. 1985, Clarke, Gedling and Hine\n    (1983); Kijima's (1990) n; in July 2001"
    )
    assert quotations(text) == {("Hirano", "1985"), ("Hine", "1983"), ("Kijima", "1990")}


def test_bibtex_parses():
    entry = re.compile(r"@(\w+)\{([^,\s]+),\n((?:  \w+ = \{.*\},\n)*)\}\n")
    text = bibtex(bibliography())
    assert entry.sub("", text) == ""
    found = {key: body for _, key, body in entry.findall(text)}
    assert list(found) == list(bibliography())
    for body in found.values():
        for line in body.splitlines():
            assert line.count("{") == line.count("}")
            assert not re.search(r"(?<!\\)[&%#]", line)
    fields = dict(re.findall(r"  (\w+) = \{(.*)\},", found["son_nomoto_1981"]))
    assert fields["author"] == "Son, K. H. and Nomoto, K."
    assert fields["volume"] == "150"


def test_an_entry_comes_once_in_the_order_asked():
    text = bibtex(["yoon_2009", "msc137", "yoon_2009"])
    assert re.findall(r"@\w+\{(.*),", text) == ["yoon_2009", "msc137"]


def test_pmmkit_is_cited_as_its_own_file_asks():
    stated = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    entry = bibliography()["pmmkit"]
    assert f'title: "{entry.title}"' in stated
    assert f"version: {entry.note.removeprefix('Version ')}" in stated
    assert all(f"name: {family}" in stated for family in entry.families)


def test_an_unknown_key_says_what_there_is():
    with pytest.raises(UnknownNameError, match="abkowitz_1964"):
        cite("abkowitz64")


@pytest.mark.parametrize("ship", ships())
def test_every_part_of_a_library_ship_has_its_source_by_key(ship):
    for part in load_model(ship).parts.values():
        if not part.source.startswith("empirical: "):
            assert part.source.startswith(f"library: {cite(part.references[0])}")
        assert all(key in bibliography() for key in part.references)


def test_estimates_have_their_sources_by_key():
    for name in METHODS:
        found = estimate(load_ship("kcs"), name)
        assert found.source.startswith(cite(found.sources[0]))
    assert all(key in bibliography() for key in RUDDER_SOURCES)
    model = estimated_model(
        load_ship("kcs"), "kijima", speed=10.0, propeller_diameter=7.9, rudder_area=55.0
    )
    assert {key for part in model.parts.values() for key in part.references} == {
        "kijima_1990",
        "yoshimura_masumoto_2012",
        "zhou_1983",
        "ittc_1957",
        *RUDDER_SOURCES,
    }


@pytest.mark.parametrize("name", catalogue())
def test_every_effect_has_its_sources_by_key(name):
    effect = catalogue()[name]
    assert effect.sources or effect.remark
    assert all(key in bibliography() for key in effect.sources)
    assert not quotations(effect.remark)


def keys_of(text: str) -> list[str]:
    return re.findall(r"^@\w+\{(.*),$", text, re.M)


def test_a_model_cites_what_it_uses_and_nothing_else():
    model = load_model("kcs")
    values = [key for part in model.parts.values() for key in part.references]
    forms = [key for name in model.parts for key in catalogue()[name].sources]
    assert keys_of(pk.citation(model)) == list(dict.fromkeys(["pmmkit", *values, *forms]))
    assert "simman_2008" in values
    assert "kijima_1990" not in keys_of(pk.citation("kcs"))
    deep = pk.with_effect(model, "memory", value=0.3)
    assert set(keys_of(pk.citation(deep))) - set(keys_of(pk.citation(model))) == {
        *catalogue()["memory"].sources
    }


def test_a_table_cites_its_structure():
    table = pk.hull_table("s175-3dof")
    assert keys_of(pk.citation(table)) == ["pmmkit"]
    reduced = replace(table, provenance={"structure": "modulus"})
    assert keys_of(pk.citation(reduced)) == ["pmmkit", "fedyaevsky_sobolev_1964", "norrbin_1971"]


def test_a_source_that_is_not_known_is_said():
    model = load_model("kcs")
    odd = replace(model.parts["propeller"], references=("nobody_1900",))
    strange = replace(model, parts=MappingProxyType({**model.parts, "propeller": odd}))
    with pytest.raises(UnknownNameError, match="nobody_1900"):
        pk.citation(strange)
