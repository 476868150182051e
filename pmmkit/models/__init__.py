"""Models: a ship and effects as data, in files and from derivative tables."""

from pmmkit.models.build import to_model
from pmmkit.models.estimates import estimated_model
from pmmkit.models.model import Model, Part
from pmmkit.models.scale import full_scale, scaled
from pmmkit.models.step import Step
from pmmkit.models.store import load_model, model_text, save_model

__all__ = [
    "Model",
    "Part",
    "Step",
    "estimated_model",
    "full_scale",
    "load_model",
    "model_text",
    "save_model",
    "scaled",
    "to_model",
]
