"""A model in water of a depth between those of the tests."""

from __future__ import annotations

from collections.abc import Mapping

from pmmkit.errors import MissingPartError
from pmmkit.models.build import to_model
from pmmkit.models.model import Model
from pmmkit.tables.by_depth import TablesByDepth


def model_at_depth(tables: TablesByDepth, models: Mapping[float, Model], ratio: float) -> Model:
    """The model of the derivatives at a depth, other parts from the model of the nearest one.

    Parameters
    ----------
    tables : TablesByDepth
        Derivatives at the depths of the tests.
    models : mapping of float to Model
        Models of the tests by their depth over the draught; propeller, rudder and what the tests
        do not give come from the nearest.
    ratio : float
        Depth of the water over the draught.

    Raises
    ------
    ExtrapolationError
        If the depth lies outside of the tables.
    NotUsableError
        If the derivatives at a depth beside it are not usable.
    MissingPartError
        If there is no model to take other parts from.
    """
    if not models:
        raise MissingPartError("No depth has a model from which propeller and rudder could come.")
    nearest = min(models, key=lambda known: abs(1 / known - 1 / ratio))
    return to_model(tables.at(ratio), models[nearest], missing="estimate")
