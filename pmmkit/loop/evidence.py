"""What a session is about: tests and a base, and what is asked of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, TypeVar

from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.together.result import Together
from pmmkit.effects.effect import Effect
from pmmkit.errors import DataError
from pmmkit.loop.fall import Fall
from pmmkit.models import Model
from pmmkit.models.step import Step

Said_co = TypeVar("Said_co", bound=Diagnosis | Together, covariant=True)
"""What a diagnosis is, of one campaign or of several."""


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
