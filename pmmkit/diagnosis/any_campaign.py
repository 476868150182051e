"""From measurements to a verdict, captive or free running."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.conventions import STRUCTURES, Structure
from pmmkit.diagnosis.captive.diagnose import derivatives_of, diagnose_captive
from pmmkit.diagnosis.captive.refit import written_in
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.models import Model, load_model


def diagnose(
    model: Model | str | Path | Sequence[str] | Structure, campaign: Campaign, **settings: Any
) -> Diagnosis:
    """Name what a model lacks that captive tests or free-running records show.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        A model, whose derivatives of hull and added mass are the base; the name of a structure, of
        a library ship or a file; or a list of derivatives. The values are fitted to the tests.
    campaign : Campaign
        Captive tests, or free-running records, which need a complete model.
    **settings
        As for `diagnose_captive`, or for `diagnose_free`.

    Returns
    -------
    Diagnosis

    Raises
    ------
    DataError
        If the model does not fit the kind of the campaign, or the runs say nothing of their noise.
    """
    if campaign.kind == "free-running":
        return diagnose_free(complete_model(model), campaign, **settings)
    source, structure, effects = derivatives_of(model)
    given = (*effects, *settings.pop("given", ()))
    ship = source if isinstance(source, Model) else None
    own = written_in(ship, settings.pop("own", ()))
    return diagnose_captive(campaign, structure, given=given, own=own, model=ship, **settings)


def complete_model(model: Model | str | Path | Sequence[str] | Structure) -> Model:
    """A model that can sail, as free-running records need one.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        As for `diagnose`.

    Raises
    ------
    DataError
        If it is a structure or a list of derivatives.
    """
    if isinstance(model, (str, Path)) and model not in STRUCTURES:
        model = load_model(model)
    if not isinstance(model, Model):
        raise DataError(
            "Free-running records are diagnosed with a complete model: a model file or a ship of "
            "the library. A list of derivatives has no propeller and no rudder."
        )
    return model
