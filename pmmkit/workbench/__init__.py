"""The workbench: a page in a browser where a model meets its tests, and the server behind it."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.workbench.application import frozen_page, serve
    from pmmkit.workbench.desk import Desk
    from pmmkit.workbench.saved import WorkbenchState

__all__ = ["Desk", "WorkbenchState", "frozen_page", "serve"]

lazy(__name__)
