"""What every format says of itself and is asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Literal

from pmmkit.numerics import Array
from pmmkit.readers.base import Cells, Choose, Columns, Request


class Reader(ABC):
    """A format of measured files.

    A subclass says below what the format is and reads it with `columns`; the other methods have
    defaults that do for a format of histories in single files. It is made without arguments, holds
    nothing between two calls, and imports what is heavy inside its methods.
    `pmmkit.testing.readers.check_reader` tries whether it keeps its word.

    Attributes
    ----------
    name : str
        What ``format`` in ``[source]`` calls it.
    words : str
        What a file of it is called in a report, e.g. ``workbook``.
    reads : str
        What it reads, in a sentence.
    suffixes : tuple of str
        Ends of the names of such files, in lower case, with the dot.
    container : bool
        Whether those ends only say how a file is packed, so that its content counts before them.
    general : bool
        Whether other formats are special cases of it: it is asked after them.
    fallback : {"file", "folder"} or None
        What it reads if nothing tells the format.
    binary : bool
        Whether its files are not text.
    computed : bool
        Whether its files come from a computation and not from a tank.
    campaign : bool
        Whether a file of it is a campaign of its own, with ship and runs.
    keys : tuple of str
        Keys of ``[source]`` that change what it reads; the others leave it as it is.

    Examples
    --------
    >>> class Counter(Reader):
    ...     name, words, reads = "counter", "counter", "Numbers in a row."
    ...
    ...     def columns(self, request, choose):
    ...         return Columns(headers=("n",), positions=tuple(choose(("n",), 1)), values=())
    >>> Counter().names(Request(path=Path("run.cnt"), shown="run.cnt"))
    ('n',)
    """

    name: ClassVar[str]
    words: ClassVar[str]
    reads: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]] = ()
    container: ClassVar[bool] = False
    general: ClassVar[bool] = False
    fallback: ClassVar[Literal["file", "folder"] | None] = None
    binary: ClassVar[bool] = False
    computed: ClassVar[bool] = False
    campaign: ClassVar[bool] = False
    keys: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns of a history as numbers.

        Parameters
        ----------
        request : Request
            The file.
        choose : callable
            Given the headers and the number of columns: the positions that are wanted.

        Raises
        ------
        CampaignError
            With everything that keeps the file from being read; never a part of it in silence.
        """

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the file, empty strings where it has none."""
        return self.columns(request, lambda *_: ()).headers

    def cells(self, request: Request) -> Cells:
        """A small file whole, as text and numbers: tables whose rows are runs."""
        raise request.error(f"a file of the format {self.name!r} is a history, not a table of rows")

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is of the format, or a folder, whose `head` is empty.

        Parameters
        ----------
        path : Path
            Where it lies.
        head : bytes
            The first bytes of a file.

        Returns
        -------
        bool
            Told by the content, soon, without raising anything.
        """
        return False

    def usual(self, headers: Sequence[str]) -> Mapping[str, str]:  # noqa: ARG002
        """Our channels and the headers, without unit, that they usually stand under."""
        return MappingProxyType({})

    def files(self, request: Request) -> Sequence[Path]:
        """The files that are read: those of a folder, those that fit a pattern."""
        return (request.path,)

    def sheets(self, request: Request) -> tuple[str, ...]:  # noqa: ARG002
        """Names of the sheets among which the key ``sheet`` chooses."""
        return ()

    def computation(self, request: Request) -> Mapping[str, Any]:  # noqa: ARG002
        """What lies beside the files of a computation and says what ``[cfd]`` asks, by its keys."""
        return MappingProxyType({})

    def prescribed(
        self,
        request: Request,  # noqa: ARG002
    ) -> tuple[Mapping[str, Array], tuple[str, ...]]:
        """The path that the hull was told to follow, where it lies beside the files.

        Returns
        -------
        path : mapping of str to array (n,)
            ``t`` [s], ``x``, ``y`` [m] and ``psi`` [rad] along the axes of the source, or nothing.
        notes : tuple of str
            What of it was not followed.
        """
        return MappingProxyType({}), ()

    @property
    def of_moving_mesh(self) -> Mapping[str, Any]:
        """What the format says of forces on a hull that moves, by the keys of ``[cfd]``."""
        return MappingProxyType({})

    def is_one_run(self, folder: Path) -> bool:  # noqa: ARG002
        """Whether a folder of the format is one measurement, and not one measurement a file."""
        return True
