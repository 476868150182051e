"""Errors, registries, executors and progress: what every room stands on."""

from typing import TYPE_CHECKING

from pmmkit.base.door import lazy

if TYPE_CHECKING:
    from pmmkit.base.errors import (
        CampaignError,
        ContradictionError,
        DataError,
        ExtrapolationError,
        FileExists,
        MissingPartError,
        ModelError,
        NotUsableError,
        PmmkitError,
        Problem,
        Remedy,
        SimulationError,
        TableError,
        UnknownNameError,
        Way,
    )
    from pmmkit.base.executors.board import each
    from pmmkit.base.executors.places import ONE_THREAD, Workers, opened
    from pmmkit.base.progress import Progress, shown
    from pmmkit.base.registry import Registry, did_you_mean
    from pmmkit.base.version import __version__

__all__ = [
    "ONE_THREAD",
    "CampaignError",
    "ContradictionError",
    "DataError",
    "ExtrapolationError",
    "FileExists",
    "MissingPartError",
    "ModelError",
    "NotUsableError",
    "PmmkitError",
    "Problem",
    "Progress",
    "Registry",
    "Remedy",
    "SimulationError",
    "TableError",
    "UnknownNameError",
    "Way",
    "Workers",
    "__version__",
    "did_you_mean",
    "each",
    "lazy",
    "opened",
    "shown",
]

lazy(__name__)
