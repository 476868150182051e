"""What a column of a foreign file probably is, by its name, its unit and its numbers.

A suggestion is for a person to confirm: nothing is read by it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import RUN_SETTINGS, RunSetting, unit_of
from pmmkit.conventions import (
    CHANNEL_UNITS,
    DEGREE_CHANNELS,
    channel_of,
    harmonic_part,
    split_unit,
    unit_factor,
)
from pmmkit.numerics import Array, even_clock
from pmmkit.presentation import meanings

Certainty = Literal["surely", "probably", "perhaps"]


@dataclass(frozen=True, kw_only=True)
class Suggestion:
    """What a column probably is.

    `name`: our name of it: a channel, and in a table a setting or a part of a harmonic.
    `certainty`: by its exact name; by a usual name; by its unit or its numbers. `unit`: unit
    that must be stated because the header does not say it and the numbers do. `scale`: factor
    that must be stated, -1 for a drag. `of_period`: of a time, whether it counts in periods, which
    each run has of its own.
    """

    name: str
    certainty: Certainty
    reason: str
    unit: str | None = None
    scale: float = 1.0
    of_period: bool = False


def suggest(
    headers: Sequence[str],
    units: Sequence[str | None],
    values: Mapping[int, Array],
    *,
    table: bool = False,
    usual: Mapping[str, str] | None = None,
) -> tuple[Suggestion | None, ...]:
    """What each column probably is; no name is given to two columns.

    Examples
    --------
    >>> found = suggest(["Time", "Fx", "Drift"], ["s", "kN", "deg"], {})
    >>> [(item.name, item.certainty) if item else None for item in found]
    [('t', 'probably'), ('X', 'probably'), None]
    """
    places = {header: name for name, header in (usual or {}).items()}
    found = [
        _by_name(header, unit, table=table, usual=places)
        for header, unit in zip(headers, units, strict=True)
    ]
    found = _with_components(found, headers, units) if table else _towed(found, headers, values)
    known = {item.name for item in found if item}
    for position, (header, unit) in enumerate(zip(headers, units, strict=True)):
        numbers = values.get(position)
        if found[position] is None and not table:
            found[position] = _by_unit(header, unit, known)
        if found[position] is None and not table and "t" not in known and numbers is not None:
            found[position] = _by_shape(header, unit, numbers, position)
        item = found[position]
        if item is not None:
            known.add(item.name)
            if numbers is not None and unit is None and item.unit is None:
                size = float(np.max(np.abs(numbers[np.isfinite(numbers)]), initial=0.0))
                found[position] = by_size(item, size)
    return _each_once(found, table=table)


def wrong_unit(header: str, unit: str | None, *, table: bool = False) -> str:
    """What is said of a column whose name is usual and whose unit measures something else.

    Examples
    --------
    >>> wrong_unit("roll", "Nm")
    "'roll' is a usual name of phi, which is not measured in Nm: a wrong unit, or something else"
    >>> wrong_unit("Fx", "N"), wrong_unit("gauge 7", "mV")
    ('', '')
    """
    if not unit or _by_name(header, unit, table=table, usual={}) is not None:
        return ""
    item = _by_name(header, None, table=table, usual={})
    if item is None or item.certainty == "perhaps":
        return ""
    return (
        f"{header!r} is a usual name of {item.name}, which is not measured in {unit}: a wrong "
        "unit, or something else"
    )


_RANK: Final = {"surely": 0, "probably": 1, "perhaps": 2}


def _each_once(found: Sequence[Suggestion | None], *, table: bool) -> tuple[Suggestion | None, ...]:
    """The best claim on each name; the first of several that are as good."""
    best: dict[str, int] = {}
    for position, item in enumerate(found):
        if item is None:
            continue
        # what a table says was set stands beside what was measured
        name = item.name if table and item.name in RUN_SETTINGS.units else channel_of(item.name)
        holder = found[best[name]] if name in best else None
        if holder is None or _RANK[item.certainty] < _RANK[holder.certainty]:
            best[name] = position
    kept = set(best.values())
    return tuple(item if position in kept else None for position, item in enumerate(found))


def _with_components(
    found: Sequence[Suggestion | None], headers: Sequence[str], units: Sequence[str | None]
) -> list[Suggestion | None]:
    """In a table u and v in m/s are the motion of the hull, and tell its speed."""
    own = {
        header.strip(): place
        for place, (header, unit) in enumerate(zip(headers, units, strict=True))
        if header.strip() in ("u", "v") and unit is not None and _dimension(unit) == "m/s"
    }
    if len(own) < 2:
        return list(found)
    kept = [None if item and item.name in ("speed", "v_amplitude") else item for item in found]
    for name, place in own.items():
        kept[place] = Suggestion(name=name, certainty="surely", reason="its exact name")
    return kept


_TOWED: Final = 0.4
"""Share of the samples at which a carriage is at its speed, at least."""
_HELD: Final = 0.03
"""Share of its speed within which it is then."""


def _towed(
    found: Sequence[Suggestion | None], headers: Sequence[str], values: Mapping[int, Array]
) -> list[Suggestion | None]:
    """A capital U or V that stands alone and stays at one value is the speed of the carriage."""
    names = [item.name for item in found if item is not None]
    out = list(found)
    if {"U_carriage", "speed"} & {*names} or {"u", "v"} <= {*names}:
        return out
    for position, item in enumerate(found):
        numbers = np.abs(values.get(position, np.zeros(0)))
        numbers = numbers[np.isfinite(numbers)]
        if (
            item is None
            or item.name not in ("u", "v")
            or headers[position].strip() not in ("U", "V", "Um", "Vm")
        ):
            continue
        level = float(np.median(numbers[numbers >= 0.5 * numbers.max()])) if numbers.size else 0.0
        if level > 0.0 and np.mean(np.abs(numbers - level) <= _HELD * level) >= _TOWED:
            why = f"{headers[position].strip()!r} stays at {level:.3g}"
            out[position] = replace(item, name="U_carriage", certainty="probably", reason=why)
    return out


def _by_name(
    header: str, unit: str | None, *, table: bool, usual: Mapping[str, str]
) -> Suggestion | None:
    plain = header.strip()
    if not plain:
        return None
    if plain in usual and _fits(usual[plain], unit, table=table):
        return Suggestion(name=usual[plain], certainty="surely", reason="its name in this format")
    rate = _RATE.fullmatch(plain)
    if rate is not None and unit and _fits(f"{rate[1]}dot", unit, table=False):
        why = f"{plain!r} in {unit}"
        return Suggestion(name=f"{rate[1]}dot", certainty="probably", reason=why)
    if not table and _OF_PERIOD.fullmatch(plain) and unit in WITHOUT:
        why = f"{plain!r} is time over the period"
        return Suggestion(name="t", certainty="probably", reason=why, unit="s", of_period=True)
    exact = re.sub(r"'(?=$|_)", "", plain)
    told = coefficient(plain) if unit in WITHOUT else None
    if told is not None and not (table and exact == told[0]):
        why = f"{plain!r}, without dimension"
        return Suggestion(name=told[0], certainty="probably", reason=why, scale=told[1])
    if not table and exact != plain and unit in WITHOUT:
        return None  # a motion without dimension: in a record its length and speed are not known
    if _known(exact, table=table) and _fits(exact, unit, table=table):
        return Suggestion(name=exact, certainty="surely", reason="its exact name")
    part = _HARMONIC.fullmatch(plain) if table else None
    if part is not None:
        channel = _RUDDER_FORCES.get(part["channel"].upper(), part["channel"])
        name = f"{channel}_{part['part']}{part['order'] or ('' if part['mean'] else '1')}"
        if harmonic_part(name):
            return Suggestion(name=name, certainty="probably", reason=f"{plain!r} by its form")
    words = re.findall(r"[^\W_]+", re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", " ", plain))
    own = _SUFFIX_UNITS.get(words[-1]) if unit is None and len(words) > 1 else None
    folded = " ".join(words[:-1] if own else words).lower()
    unit = unit or own
    elsewhere = _of_a_part(header)
    for name, pattern in (*(RUN_SETTINGS.derived(_table_names) if table else ()), *_NAMES):
        found = pattern.fullmatch(folded) or pattern.search(folded)
        if not found or name in elsewhere or not _fits(name, unit, table=table):
            continue
        whole = found[0] == folded
        if len(found[0]) == 1 and not whole:
            continue
        drag = found[0] == "drag"
        return Suggestion(
            name=name,
            certainty="probably" if (whole or unit is not None) and not drag else "perhaps",
            reason=f"{plain!r} is a usual name of it" + (", positive aft" if drag else ""),
            unit=own,
            scale=-1.0 if drag else 1.0,
        )
    return _in_other_words(plain, unit, table=table)


def _in_other_words(header: str, unit: str | None, *, table: bool) -> Suggestion | None:
    """By a word of another language; surer where it is all of the header."""
    more = {item.in_file: item.words for item in RUN_SETTINGS.brought if item.words}
    found = [*meanings("setting", header, more)] if table else []
    for channel, word, alone in meanings("channel", header):
        held = _SETTINGS_OF.get(channel) if table else None
        found.append((held or channel, word, alone))
    for name, word, alone in found:
        told = unit is not None or name != "yaw_rate"
        if _known(name, table=table) and _fits(name, unit, table=table) and told:
            return Suggestion(
                name=name,
                certainty="probably" if alone else "perhaps",
                reason=f"{word!r} is a word for it",
            )
    return None


def _of_a_part(header: str) -> set[str]:
    """Forces and moments that a header has of something else: about a rudder's stock there is no
    yaw, and a fan is no propeller."""
    folded = header.replace("_", " ").lower()
    return {*("XYNK" if _PARTS.search(folded) else ""), *("TQ" if _FAN.search(folded) else "")}


def _known(name: str, *, table: bool) -> bool:
    """Whether it is a name of ours that a file of that kind is read by without being mapped."""
    if table:
        return unit_of(name, table=True, unasked=True) is not None
    return name in CHANNEL_UNITS or name in DEGREE_CHANNELS


def _by_unit(header: str, unit: str | None, known: set[str]) -> Suggestion | None:
    """By the unit, and a letter of the name that says which axis."""
    dimension = _dimension(unit)
    axis = re.search(r"(?:^|[^a-zA-Z])[fFmM]?([xyzXYZ])(?:$|[^a-zA-Z])", header)
    if axis is None or dimension not in ("N", "N m"):
        return None
    named = {("N", "x"): "X", ("N", "y"): "Y", ("N m", "z"): "N", ("N m", "x"): "K"}
    name = named.get((dimension, axis[1].lower()))
    if name is None or name in known or name in _of_a_part(header):
        return None
    return Suggestion(
        name=name, certainty="perhaps", reason=f"a unit of {dimension}, and {axis[1]} in the name"
    )


def _by_shape(header: str, unit: str | None, numbers: Array, position: int) -> Suggestion | None:
    if len(numbers) < 20 or _dimension(unit) not in (None, "s") or len(header) > 24:
        return None
    if header.strip() and COUNTED.fullmatch(header.strip()):
        return None
    # settings of a list stand several times below each other, too, but they have names
    clock = even_clock(numbers) if position == 0 and not header else None
    steps = np.diff(numbers if clock is None else clock)
    middle = float(np.median(steps))
    if not (np.all(np.isfinite(numbers)) and middle > 0 and np.all(steps > 0)):
        return None
    even = float(np.max(np.abs(steps - middle))) < 0.02 * middle
    if not even and unit is None:
        return None
    first = position == 0 and even and not header
    return Suggestion(
        name="t",
        certainty="probably" if first else "perhaps",
        reason=f"increases steadily, by {middle:.6g} a row",
        unit="s" if unit is None else None,
    )


def by_size(item: Suggestion, size: float, *, towed: bool = False) -> Suggestion:
    """With the unit that only the numbers tell, the largest of which is `size`.

    The heading of a model that is `towed` stays within a right angle.
    """
    unit, limit = _TELLING.get(item.name, (None, 0.0))
    if towed and item.name == "psi":
        limit = _RIGHT_ANGLE
    if unit is None or size <= limit:
        return item
    why = f"{item.reason}; {unit}, since numbers reach {size:.3g}"
    return Suggestion(
        name=item.name, certainty=item.certainty, reason=why, unit=unit, scale=item.scale
    )


_TELLING: Final[dict[str, tuple[str, float]]] = {
    "psi": ("deg", 45.0),
    "phi": ("deg", 1.6),
    "delta": ("deg", 1.6),
    "trim": ("deg", 1.6),
    "wind_direction": ("deg", 6.4),
    "n": ("rpm", 60.0),
    "r": ("deg/s", 2.0),
}
"""Unit other than SI, and the number beyond which SI cannot be."""
_RIGHT_ANGLE: Final = 1.6


def _dimension(unit: str | None) -> str | None:
    if unit is None:
        return None
    try:
        return unit_factor(unit)[0]
    except DataError:
        return unit


def _fits(name: str, unit: str | None, *, table: bool) -> bool:
    """Whether the stated unit measures what the name does."""
    own = unit_of(name, table=table)
    if unit is None or own is None:
        return own is not None
    have, want = _dimension(unit), _dimension(own)
    return have == want or (have == "" and table) or (name == "n" and have == "rad/s")


def bare_header(header: str, unit: str | None = None) -> tuple[str, str | None]:
    """Name and unit of a header, the unit from a line of units where it has none itself."""
    name, own = split_unit(header)
    return (name, own) if own is not None else (header.strip(), unit or None)


_SUFFIX_UNITS: Final = {
    "rpm": "rpm",
    "rps": "rps",
    "deg": "deg",
    "rad": "rad",
    "kN": "kN",
    "N": "N",
    "Nm": "N m",
    "mm": "mm",
    "m": "m",
    "mps": "m/s",
    "s": "s",
    "sec": "s",
}
"""Last words of a header that are taken for its unit."""


def _pattern(words: str) -> re.Pattern[str]:
    return re.compile(rf"\b(?:{words})\b")


_NAMES: Final = tuple(
    (name, _pattern(words))
    for name, words in {
        "Y_forward": "(?:f ?y|side force|y force|sway force) ?(?:f|fwd|fore|forward|front|bow)|"
        "(?:fwd|fore|forward|front|bow) (?:side force|f ?y|sway force|gauge)",
        "Y_aft": "(?:f ?y|side force|y force|sway force) ?(?:a|aft|rear|stern)|"
        "(?:aft|rear|stern) (?:side force|f ?y|sway force|gauge)",
        "FX_rudder": "(?:f ?)?x ?rud(?:der)?|rudder (?:normal )?f ?x|r ?fx",
        "FY_rudder": "(?:f ?)?y ?rud(?:der)?|rudder f ?y|r ?fy",
        "wind_speed": "wind (?:velo|velocity|speed) relative(?: mid)?|relative wind speed|aws",
        "wind_direction": "wind (?:dir|direction|angle) relative(?: mid)?|awa",
        "udot": "u ?dot|du ?dt|surge acc(?:eleration)?",
        "vdot": "v ?dot|dv ?dt|sway acc(?:eleration)?",
        "rdot": "r ?dot|dr ?dt|yaw acc(?:eleration)?",
        "xdot": "x ?dot|dx0? ?dt|x velocity",
        "ydot": "y ?dot|dy0? ?dt|y velocity",
        "u": "u(?: velo(?:city)?)?|surge (?:velo(?:city)?|speed)",
        "v": "vm?(?: velo(?:city)?)?|sway (?:velo(?:city)?|speed)",
        "r": "gyro ?z|r(?: angvelo| angular velocity)?|yaw ?rate|yaw (?:velo(?:city)?|speed)|"
        "rot|rate of turn|omega ?z",
        "p": "gyro ?x|roll ?rate|roll (?:velo(?:city)?|speed)|omega ?x",
        "X": "f ?x|force ?x|x ?force|surge force|longitudinal force|axial force|total x|drag|x",
        "Y": "f ?y|force ?y|y ?force|(?:sway|side|lateral|transver(?:se|sal)) force|total y|y",
        "N": "m ?z|moment ?z|z ?moment|yaw ?moment|yawing moment|turning moment|n moment|n",
        "K": "m ?x|moment ?x|x ?moment|roll ?moment|heeling moment|k moment|k",
        "psi": "psi(?: hat)?|ψ|heading(?: angle)?|hdg|yaw(?: angle)?|course angle",
        "phi": "phi|φ|roll(?: angle)?|heel(?: angle)?",
        "delta": "delta(?: rudder)?|δ|rudder(?: angle)?|(?:d ?)?rud|helm|ruder(?:winkel)?",
        "n": "n|rps|rpm|revs?|revolutions|n prop(?:eller)?|prop(?:eller)? (?:rev(?:olution)?s?|rps|"
        "rpm|n)|shaft speed",
        "T": "thrust|prop(?:eller)? thrust|t ?p(?:rop)?",
        "Q": "torque|prop(?:eller)? torque|q ?p(?:rop)?",
        "sinkage": "sinkage|heave|squat",
        "trim": "trim(?: angle)?|pitch(?: angle)?",
        "lat": "lat(?:itude)?",
        "lon": "lon(?:g|gitude)?",
        "sog": "sog|speed over ground",
        "cog": "cog|course over ground",
        "x": "x|x ?0|x ?pos(?:ition)?(?: mid)?|pos(?:ition)? ?x|north(?:ing)?",
        "y": "y|sway(?: displacement| position)?|"
        "y ?0|y ?pos(?:ition)?(?: mid)?|pos(?:ition)? ?y|east(?:ing)?",
        "U_carriage": "(?:towing )?carriage(?: speed| velo(?:city)?)?|tow(?:ing)? speed|"
        "[uv] ?(?:carriage|carr?|tow|schlepp|wagen)|(?:schlepp)?wagen|[uv] ?c",
        "y_forward": "y ?(?:forward|fwd|fore)|(?:forward|fore) (?:strut|post|ram)(?: y)?",
        "y_aft": "y ?aft|aft (?:strut|post|ram)(?: y)?",
        "speed": "speed|model speed",
        "t": "t|time(?: s)?|(?:utc|gmt|local|ship) ?time|utc|gmt|time ?stamp|date ?time|"
        "zeitstempel|physical time(?: physical time)?|zeit|temps|tiempo|tijd|时间|時間",
    }.items()
)

_PARTS: Final = re.compile(
    r"\b(?:rudder|ruder|rud|prop(?:eller)?|fan|fin|pod|skeg|stock|hinge|thruster)s?\b"
)
"""What has forces and moments of its own."""
_FAN: Final = re.compile(r"\bfans?\b")
"""What blows a model ahead, for the friction that a ship has not."""
_SEEN: Final = "measured|actual|mean"
_BEFORE: Final = tuple(
    (name, _pattern(words))
    for name, words in {
        "n": f"prop(?:eller)? (?:{_SEEN})",
        "delta": f"rudder (?:{_SEEN})",
        "FX_rudder": "r ?x|rudder x",
        "FY_rudder": "r ?y|rudder y",
        "Q": "prop(?:eller)? q",
    }.items()
)
_AFTER: Final = (("T", _pattern("t ?x|thrust")), ("X", _pattern("resistance(?: n)?")))
_LATE: Final = (
    *("drift", "rudder", "heel", "propeller_rps", "frequency_hz", "period", "yaw_amplitude"),
    *("rudder_amplitude", "amplitude", "vdot_amplitude", "rdot_amplitude", "v_amplitude"),
    *("r_amplitude", "speed"),
)
"""Settings by their headers, the more special ones first; those of single letters last."""


def _table_names(settings: Iterable[RunSetting]) -> tuple[tuple[str, re.Pattern[str]], ...]:
    """Headers of tables whose rows are runs; what kinds of test bring along is the most special."""
    by_name = {item.name: item for item in settings if item.header}
    first = [name for name in by_name if name not in _LATE]
    ordered = [by_name[name] for name in (*first, *_LATE)]
    return (*_BEFORE, *((item.in_file, _pattern(item.header)) for item in ordered), *_AFTER)


_SETTINGS_OF: Final = {
    "U_carriage": "speed",
    "delta": "rudder_deg",
    "phi": "heel_deg",
    "n": "propeller_rps",
    "r": "yaw_rate",
}
"""What a table whose rows are runs holds of a channel."""

_HARMONIC: Final = re.compile(
    r"(?P<channel>[XYNKTQ]|R[XYxy])_?(?P<part>(?P<mean>mean|std)|sin|cos|in|out)_?(?P<order>[1-9]?)'?"
)
_RATE: Final = re.compile(r"([uvrp])'")
_COEFFICIENT: Final = re.compile(
    r"(?:C_?(?P<c>[XYNKxynk]|[Mm][ZzXx])"
    r"|(?P<f>F[XYxy]|M[ZXzx]|[XYNK])_?[Hh]?(?:['′*]|[_ ]?(?:prime|nd|nondim))_?[Hh]?)"
    r"\s*(?:[(\[]\s*-\s*[)\]])?"
    r"\s*(?:[(\[]?\s*[x×*·]\s*(?:10\^?(?P<power>[2-6])|(?P<thousand>1000|1e3|10³))\s*[)\]]?)?"
)


def coefficient(header: str) -> tuple[str, float] | None:
    """Our name of a force without dimension, and the factor that its header takes off.

    Examples
    --------
    >>> coefficient("CY"), coefficient("X'H"), coefficient("N' (x10^3)"), coefficient("X [N]")
    (('Y', 1.0), ('X', 1.0), ('N', 0.001), None)
    """
    found = _COEFFICIENT.fullmatch(header.strip())
    if found is None:
        return None
    letters = (found["c"] or found["f"]).upper()
    name = {"MZ": "N", "MX": "K"}.get(letters, letters[-1])
    power = 3 if found["thousand"] else int(found["power"] or 0)
    return name, 10.0**-power


COUNTED: Final = re.compile(
    r"(?:(?:run|test|case|point|row|versuch|fahrt)[ _]*)?(?:no|nr|num|number|id|#)?\.?",
    re.IGNORECASE,
)
"""A column that numbers the tests."""
_OF_PERIOD: Final = re.compile(r"[tT] ?/ ?T[0pPe]?")
WITHOUT: Final = (None, "", "-", "1")
"""Units of a column that has none."""
"""A rate of change, if its unit is that of one; else a number without dimension."""
_RUDDER_FORCES: Final = {"RX": "FX_rudder", "RY": "FY_rudder"}
