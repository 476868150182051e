"""Models: a ship and effects as data, in files and from derivative tables."""

from pmmkit.model.build import to_model
from pmmkit.model.estimated import estimated_model
from pmmkit.model.model import Model, Part
from pmmkit.model.scale import full_scale, scaled
from pmmkit.model.store import load_model, model_text, save_model

__all__ = [
    "Model",
    "Part",
    "estimated_model",
    "full_scale",
    "load_model",
    "model_text",
    "save_model",
    "scaled",
    "to_model",
]
