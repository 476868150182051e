"""What a session is about: tests and a base, and what is asked of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.together.result import Together
from pmmkit.effects.effect import Effect
from pmmkit.errors import DataError
from pmmkit.models import Model
from pmmkit.models.step import Step
from pmmkit.presentation import Grid

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

BASE: Final = "base"
"""First line of an error fall: the model before any step."""
Said_co = TypeVar("Said_co", bound=Diagnosis | Together, covariant=True)
"""What a diagnosis is, of one campaign or of several."""
FALLS: Final = 0.995
"""A step whose held-out error is above this share of the one before does not lower it."""


class Fall(Protocol):
    """How the error of what is left out falls with each step."""

    @property
    def steps(self) -> tuple[str, ...]:
        """``base``, then the effects in the order in which they were added."""

    @property
    def errors(self) -> tuple[Any, ...]:
        """After each."""

    @property
    def totals(self) -> tuple[float, ...]:
        """The one number of each step [`unit`]."""

    @property
    def unit(self) -> str:
        """Of `totals`."""

    @property
    def of(self) -> str:
        """What `totals` are errors of."""

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps that do not lower the error."""

    @property
    def how(self) -> str:
        """What was left out, and what the numbers are, in a sentence."""

    def table(self) -> Grid:
        """A row per step."""

    def remarks(self) -> list[str]:
        """What is to be said of the steps."""

    def plot(self) -> Figure:
        """Errors after each step."""

    def to_pandas(self) -> pd.DataFrame:
        """The errors as data."""


class Evidence(Protocol[Said_co]):
    """Tests, a base, and all that may be missing of it.

    What takes long is worked out once, when it is first needed.
    """

    @property
    def title(self) -> str:
        """Of the tests."""

    @property
    def base(self) -> str:
        """The base in words."""

    @property
    def about(self) -> str:
        """The tests in words."""

    @property
    def floor(self) -> float:
        """What is too small to matter, over the rms force of a channel."""

    @property
    def begun(self) -> tuple[str, ...]:
        """Effects that the base has from the beginning."""

    @property
    def kinds(self) -> Mapping[str, str]:
        """Who takes part: ``physics`` or ``fault`` by name."""

    @property
    def own(self) -> tuple[Effect, ...]:
        """Effects of the user."""

    def named(self, effect: str, campaign: str) -> str:
        """The campaign that a step is about: empty where it is about all there are.

        Raises
        ------
        DataError
            If there is no such campaign, or it has to be said.
        """

    def diagnose(self, steps: Sequence[Step], seed: int) -> Said_co:
        """What the base still lacks with some steps."""

    def fall(self, steps: Sequence[Step]) -> Fall:
        """Errors of what is left out, of the base and after each step."""

    def held_out_errors(self, steps: Sequence[Step]) -> Mapping[str, Mapping[str, float]]:
        """Errors of records that are held out, before and after; empty where there are none."""

    def model(self, steps: Sequence[Step]) -> Model:
        """Base and effects fitted together, with a step per effect."""

    def rival(self, steps: Sequence[Step], names: Sequence[str]) -> Model:
        """The ship that a set named by `diagnose` says, with its uncertainty and without steps."""


def only_campaign(title: str, effect: str, campaign: str) -> str:
    """`Evidence.named` where there is one campaign alone: nothing has to be said.

    Parameters
    ----------
    title : str
        Of the campaign.
    effect, campaign : str
        As for `Evidence.named`.

    Raises
    ------
    DataError
        If another one is named.
    """
    if campaign not in ("", title):
        raise DataError(f"{effect}: there is no campaign {campaign!r}, but {title!r}.")
    return ""
