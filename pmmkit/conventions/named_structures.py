"""Structures: the lists of terms that a mathematical model gives to each channel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

from pmmkit.base import Registry, UnknownNameError, did_you_mean
from pmmkit.conventions.derivatives import CHANNELS, parse_derivative
from pmmkit.conventions.sources import cite

GROUP: Final = "pmmkit.structures"
"""Entry point group by which other packages bring structures."""


@dataclass(frozen=True, kw_only=True)
class Structure:
    """A named list of derivatives.

    Parameters
    ----------
    name : str
        Name of the structure.
    derivatives : tuple of str
        Canonical names.
    system : {"prime", "prime-d"}
        The non-dimensional system in which it is usually written.
    surge : {"u", "delta-u"}
        What factors u mean (see `conventions.Convention`).
    sources : tuple of str
        Where the form comes from, as keys of the bibliography.
    remark : str
        What of the last source was left out.
    """

    name: str
    derivatives: tuple[str, ...]
    system: Literal["prime", "prime-d"] = "prime"
    surge: Literal["u", "delta-u"] = "u"
    sources: tuple[str, ...] = ()
    remark: str = ""

    @staticmethod
    def meant_by(choice: str | Iterable[str] | Structure) -> Structure:
        """A structure by name, or from a list of derivatives.

        Parameters
        ----------
        choice : str, iterable of str or Structure
            A name (``abkowitz3``), derivatives in one text separated by commas or blanks
            (``"Yv Yr Nv Nr"``), or a list of them.

        Raises
        ------
        UnknownNameError
            If neither a structure nor derivatives are meant.

        Examples
        --------
        >>> Structure.meant_by("linear").of("Y")
        ('Yv', 'Yr', 'Yvdot', 'Yrdot')
        >>> Structure.meant_by("Yv, Yv|v|, Nv").derivatives
        ('Yv', 'Yv|v|', 'Nv')
        """
        if isinstance(choice, Structure):
            return choice
        if isinstance(choice, str) and choice in STRUCTURES:
            return STRUCTURES[choice]
        names = choice.replace(",", " ").split() if isinstance(choice, str) else list(choice)
        try:
            if not names:
                raise UnknownNameError("the list is empty.")
            return Structure(name="custom", derivatives=_ordered(names))
        except UnknownNameError as error:
            known = ", ".join(STRUCTURES)
            guess = did_you_mean(choice, STRUCTURES) if isinstance(choice, str) else ""
            raise UnknownNameError(
                f"{choice!r} is neither a structure ({known}) nor a list of "
                f"derivatives{guess or ':'} {error}"
            ) from error

    @property
    def source(self) -> str:
        """Where the form comes from, in words."""
        return " ".join(filter(None, (cite(*self.sources), self.remark)))

    def of(self, channel: str) -> tuple[str, ...]:
        """The derivatives of one channel."""
        return tuple(name for name in self.derivatives if name[0] == channel)

    def with_(self, *names: str) -> Structure:
        """A copy with more derivatives (those already there are left as they are)."""
        added = [
            name
            for name in (parse_derivative(name).name for name in names)
            if name not in self.derivatives
        ]
        return replace(self, derivatives=_ordered((*self.derivatives, *added)))


def _ordered(names: Iterable[str]) -> tuple[str, ...]:
    unique = dict.fromkeys(parse_derivative(name).name for name in names)
    return tuple(sorted(unique, key=lambda name: CHANNELS.index(name[0])))


def _named(terms: Mapping[str, str]) -> tuple[str, ...]:
    return _ordered(
        channel + term
        for channels, listed in terms.items()
        for channel in channels
        for term in listed.split()
    )


_LINEAR: Final = {"X": "udot uu vv rr vr", "YN": "v r vdot rdot"}
_CUBIC: Final = {**_LINEAR, "YN": "v r vvv rrr vdot rdot"}

_OURS: Final = (
    Structure(name="linear", derivatives=_named(_LINEAR)),
    Structure(name="cubic", derivatives=_named(_CUBIC), sources=("abkowitz_1964",)),
    Structure(
        name="abkowitz3",
        derivatives=_named({**_LINEAR, "YN": "v r vvv rrr vvr vrr vdot rdot"}),
        sources=("abkowitz_1964", "son_nomoto_1981"),
        remark="without heel",
    ),
    Structure(
        name="modulus",
        derivatives=_named({**_LINEAR, "YN": "v r v|v| r|r| vvr vrr vdot rdot"}),
        sources=("fedyaevsky_sobolev_1964", "norrbin_1971"),
    ),
    Structure(
        name="mariner",
        derivatives=_named(
            {
                "X": "udot u uu uuu vv rr dd udd vr vd uvd",
                "YN": "vdot rdot v r vvv vvr uv ur d ddd ud uud vdd vvd 0 0u 0uu",
            }
        ),
        surge="delta-u",
        sources=("chislett_strom_tejsen_1965",),
    ),
    Structure(
        name="mmg",
        derivatives=_named({"X": "udot uu vv vr rr vvvv", "YN": "v r vvv vvr vrr rrr vdot rdot"}),
        system="prime-d",
        sources=("yasukawa_yoshimura_2015",),
    ),
    Structure(
        name="son-nomoto",
        derivatives=_named(
            {
                "X": "udot uu vr rr phiphi vv",
                "Y": "v r p phi vvv rrr vvr vrr vvphi vphiphi rrphi rphiphi vdot rdot",
                "N": "v r p phi vvv rrr vvr vrr vvphi vphiphi rrphi rphiphi vdot rdot",
                "K": "v r p phi vvv rrr vvr vrr vvphi vphiphi rrphi rphiphi vdot pdot",
            }
        ),
        sources=("son_nomoto_1981",),
    ),
)


STRUCTURES: Final = Registry(
    Structure,
    lambda: _OURS,
    what="structure",
    group=GROUP,
    contract="pmmkit.testing.structures:check_structure",
)
"""All structures by name: pmmkit's, then those of other installed packages."""
