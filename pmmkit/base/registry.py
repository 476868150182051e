"""Registries: entries by name, pmmkit's own, those of installed packages, those of this session."""

from __future__ import annotations

import importlib
import pkgutil
import warnings
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from pmmkit.base.errors import ModelError, UnknownNameError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


class HasName(Protocol):
    """An entry of a registry."""

    @property
    def name(self) -> str:
        """Its name, once in the registry."""


Entry = TypeVar("Entry", bound=HasName)
Made = TypeVar("Made")


class Registry(Mapping[str, Entry], Generic[Entry]):
    """Entries by name, in order: pmmkit's own, then those of installed packages, then the user's.

    Nothing is imported before it is asked for, and other packages only where a name is not one of
    pmmkit's own, or where all entries are asked for: their import may take long.

    Parameters
    ----------
    kind : type
        What an entry is.
    own : callable
        Gives pmmkit's own entries.
    what : str
        What an entry is called.
    listed : str
        A package whose modules list further ones of pmmkit's, those of packages inside it too, and
        the name under which they do, with a colon between.
    first : sequence of str
        Modules whose entries come first, in this order; the others follow by their names.
    group : str
        Entry points under which installed packages bring entries: an entry, several in a list or
        tuple, or a class that makes one without arguments. Empty where only pmmkit has entries.
    unknown : str
        What is said of a name that there is not, with ``{name!r}``, ``{guess}`` (the end of the
        sentence) and ``{names}``.
    contract : str
        Module and function that say whether an entry holds what all do, with a colon between.

    Examples
    --------
    >>> from pmmkit.conventions import Ship
    >>> hull = Ship(name="hull", L=5.0, B=0.7, d=0.25, volume=0.5, mass=500.0, Izz=800.0)
    >>> hulls = Registry(Ship, lambda: [hull], what="hull")
    >>> list(hulls), hulls["hull"].L, "hall" in hulls
    (['hull'], 5.0, False)
    >>> hulls["hall"]
    Traceback (most recent call last):
    pmmkit.base.errors.UnknownNameError: There is no hull 'hall'; did you mean 'hull'? There ...
    """

    def __init__(
        self,
        kind: type[Entry],
        own: Callable[[], Iterable[Entry]] = tuple,
        *,
        what: str,
        listed: str = "",
        first: Sequence[str] = (),
        group: str = "",
        unknown: str = "",
        contract: str = "",
    ) -> None:
        self.kind, self.what, self.group, self.contract = kind, what, group, contract
        self._entries, self._listed, self._first = own, listed, first
        self._unknown = unknown or f"There is no {what} {{name!r}}{{guess}} There are: {{names}}."
        self._registered: dict[str, Entry] = {}
        self._editions: dict[str, int] = {}
        self.reload()

    def reload(self) -> None:
        """Look anew for entries, pmmkit's and those of packages, when next asked."""
        self._own: Mapping[str, Entry] | None = None
        self._installed: Mapping[str, Entry] | None = None
        self._derived: dict[Callable[..., Any], Any] = {}

    @property
    def own(self) -> Mapping[str, Entry]:
        """Pmmkit's own entries."""
        if self._own is None:
            entries = (*self._entries(), *self._listed_ones())
            self._own = MappingProxyType({entry.name: entry for entry in entries})
        return self._own

    @property
    def installed(self) -> Mapping[str, Entry]:
        """Pmmkit's own entries and those of installed packages."""
        if self._installed is None:
            own = self.own
            brought = offered(self.group, self.kind, own) if self.group else {}
            self._installed = MappingProxyType({**own, **brought}) if brought else own
        return self._installed

    def __getitem__(self, name: str) -> Entry:
        found = self._found(name)
        if found is None:
            raise UnknownNameError(self.unknown(name))
        return found

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._found(name) is not None

    def __iter__(self) -> Iterator[str]:
        return iter({**self.installed, **self._registered})

    def __len__(self) -> int:
        return len({*self.installed, *self._registered})

    def __repr__(self) -> str:
        return f"<Registry of {len(self)}: {', '.join(self)}>"

    def get(self, name: str) -> Entry | None:  # type: ignore[override]  # no other default
        """The entry of a name; None where there is none."""
        return self._found(name)

    def unknown(self, name: str) -> str:
        """What is wrong with a name that there is not."""
        guess = did_you_mean(name, self) or "."
        return self._unknown.format(name=name, guess=guess, names=", ".join(self))

    def title_of(self, name: str) -> str:
        """What figures call an entry: its ``title``; of any other name that with blanks."""
        return getattr(self.get(name), "title", "") or name.replace("_", " ")

    @property
    def titles(self) -> Mapping[str, str]:
        """What figures call each entry."""
        return {name: self.title_of(name) for name in self}

    def derived(self, make: Callable[[Iterable[Entry]], Made]) -> Made:
        """What a function makes of all entries, made once as long as they stay the same."""
        if make not in self._derived:
            self._derived[make] = make(self.values())
        made: Made = self._derived[make]
        return made

    def ordered(self, *first: str) -> tuple[Entry, ...]:
        """All entries, those of some names first."""
        return tuple(self[name] for name in dict.fromkeys((*first, *self)))

    def register(self, entry: Entry) -> None:
        """Let an entry take part for this session; under its name again it replaces the last."""
        name = entry.name
        if name in self.installed:
            what = f"{'an' if self.what[0] in 'aeiou' else 'a'} {self.what}"
            raise ModelError(f"There is {what} {name!r} already: choose another name.")
        if not name.isidentifier():
            raise ModelError(f"{name!r} is no name: take letters, digits and _.")
        if self._registered.get(name) is not entry:
            self._editions[name] = self.edition(name) + 1
        self._registered[name] = entry
        self._derived.clear()

    def forget(self, name: str) -> None:
        """Take a registered entry out again; nothing where there is none."""
        if self._registered.pop(name, None) is not None:
            self._editions[name] = self.edition(name) + 1  # a package's of that name is another
            self._derived.clear()

    def edition(self, name: str) -> int:
        """How often a name was registered or forgotten in this session."""
        return self._editions.get(name, 0)

    def check(self, entry: Entry, *given: Any, **settings: Any) -> None:
        """Whether an entry holds the contract; an AssertionError says all that does not."""
        module, _, function = self.contract.partition(":")
        getattr(importlib.import_module(module), function)(entry, *given, **settings)

    def _found(self, name: str) -> Entry | None:
        if name in self._registered:
            return self._registered[name]
        own = self.own
        return own[name] if name in own else self.installed.get(name)

    def _listed_ones(self) -> Iterator[Entry]:
        """The entries that the modules of the package list."""
        package, _, attribute = self._listed.partition(":")
        places = importlib.import_module(package).__path__ if package else ()
        modules = [item.name for item in pkgutil.walk_packages(places, f"{package}.")]
        order = {f"{package}.{name}": number for number, name in enumerate(self._first)}
        for name in sorted(modules, key=lambda name: (order.get(name, len(order)), name)):
            listed = getattr(importlib.import_module(name), attribute, ())
            if not isinstance(listed, Registry):  # the registry itself may bear the name
                yield from listed


def offered(group: str, kind: type[Entry], taken: Container[str] = ()) -> dict[str, Entry]:
    """What installed packages bring to a registry, by name.

    What cannot be used is left out with a warning: a package of somebody else must not stop pmmkit.

    Examples
    --------
    >>> from pmmkit.conventions import Ship
    >>> offered("pmmkit.nothing", Ship)
    {}
    """
    from importlib.metadata import entry_points  # here: it takes 40 ms

    found: dict[str, Entry] = {}
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        try:
            for item in _loaded(point, kind):
                if item.name in taken or item.name in found:
                    raise ValueError(f"the name {item.name!r} is taken")
                found[item.name] = item
        except Exception as error:
            package = "a package" if point.dist is None else point.dist.name
            warnings.warn(f"{group} {point.name!r} of {package} is left out: {error}", stacklevel=2)
    return found


def _loaded(point: EntryPoint, kind: type[Entry]) -> tuple[Entry, ...]:
    """What an entry point names, made where it is a class."""
    given = point.load()
    if isinstance(given, type):
        given = given()
    items = (given,) if isinstance(given, kind) else tuple(given)
    for item in items:
        if not isinstance(item, kind):
            raise TypeError(f"{item!r:.60} is no {kind.__name__}")
    return items


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``; did you mean 'x'?`` with the nearest known name, or nothing.

    Parameters
    ----------
    name : str
        What was asked for.
    known : iterable of str
        The names that there are.

    Returns
    -------
    str

    Examples
    --------
    >>> did_you_mean("drift_dge", ["drift_deg", "speed"]), did_you_mean("KVLCC", ["kvlcc2"])
    ("; did you mean 'drift_deg'?", "; did you mean 'kvlcc2'?")
    """
    import difflib

    listed = list(known)
    folded = {item.lower(): item for item in listed}
    if name.lower() in folded:
        return f"; did you mean {folded[name.lower()]!r}?"
    near = difflib.get_close_matches(name, listed, n=1, cutoff=0.6) or [
        folded[item] for item in difflib.get_close_matches(name.lower(), folded, n=1, cutoff=0.6)
    ]
    return f"; did you mean {near[0]!r}?" if near else ""
