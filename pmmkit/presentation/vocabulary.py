"""Words of laboratories in other languages, for channels, settings and kinds of test."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Final, Literal, get_args

Subject = Literal["channel", "setting", "test", "statistic", "doubt"]
_SUBJECTS: Final[tuple[Subject, ...]] = get_args(Subject)
_UMLAUTS: Final = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue"})
_LATIN: Final = re.compile(r"[a-z]")


@cache
def vocabulary() -> Mapping[Subject, Mapping[str, tuple[str, ...]]]:
    """Words by our names, as they are written, for each subject.

    Examples
    --------
    >>> vocabulary()["channel"]["Y"][:3]
    ('querkraft', 'seitenkraft', '横力')
    """
    text = files(__package__).joinpath("vocabulary.toml").read_text(encoding="utf-8")
    found = tomllib.loads(text)
    return MappingProxyType(
        {
            subject: MappingProxyType(
                {name: tuple(words) for name, words in found[subject].items()}
            )
            for subject in _SUBJECTS
        }
    )


@cache
def letters() -> frozenset[str]:
    """Letters beyond ASCII of all words."""
    return frozenset(
        letter
        for listed in vocabulary().values()
        for words in listed.values()
        for word in words
        for letter in word
        if not letter.isascii()
    )


def meanings(
    subject: Subject, text: str, also: Mapping[str, tuple[str, ...]] | None = None
) -> tuple[tuple[str, str, bool], ...]:
    """Our names for what a text says, each with the word it was told by, the longest first.

    Beside them stands whether that word is all of the text.

    Parameters
    ----------
    subject : {"channel", "setting", "test", "statistic", "doubt"}
        What is asked for.
    text : str
        A header or the name of a file.
    also : mapping of str to tuple of str, optional
        More names with their words.

    Examples
    --------
    >>> meanings("channel", "Laengskraft"), meanings("channel", "横力")
    ((('X', 'längskraft', True),), (('Y', '横力', True),))
    >>> meanings("test", "Schraeg_beta+04")
    (('static_drift', 'schräg', False),)
    >>> meanings("setting", "Amplitude")
    (('amplitude_m', 'amplitude', True), ('yaw_amplitude_deg', 'amplitude', True))
    """
    plain = _folded(text)
    patterns = (*_patterns(subject), *_compiled(subject, also or {}))
    found = [
        (name, word, pattern.fullmatch(plain.strip()) is not None)
        for name, word, pattern in patterns
        if pattern.search(plain)
    ]
    return tuple(sorted(found, key=lambda item: -len(item[1])))


@cache
def _patterns(subject: Subject) -> tuple[tuple[str, str, re.Pattern[str]], ...]:
    return _compiled(subject, vocabulary()[subject])


def _compiled(
    subject: Subject, names: Mapping[str, tuple[str, ...]]
) -> tuple[tuple[str, str, re.Pattern[str]], ...]:
    return tuple(
        (name, word, _pattern(word, whole=subject != "test"))
        for name, words in names.items()
        for word in words
    )


def _pattern(word: str, *, whole: bool) -> re.Pattern[str]:
    """A word with or without accents; one of Latin letters begins, or is, a word of the text."""
    spellings = {_folded(word), _folded(word.translate(_UMLAUTS))}
    either = "|".join(re.escape(spelling) for spelling in sorted(spellings))
    if _LATIN.search(_folded(word)) is None:
        return re.compile(either)
    return re.compile(rf"(?<![a-z])(?:{either})" + ("(?![a-z])" if whole else ""))


def _folded(text: str) -> str:
    """In small letters without accents; letters of full width as plain ones, blanks for lines."""
    wide = unicodedata.normalize("NFKC", text).casefold().replace("_", " ")
    apart = unicodedata.normalize("NFD", wide)
    plain = "".join(letter for letter in apart if not "\u0300" <= letter <= "\u036f")
    return unicodedata.normalize("NFC", plain)
