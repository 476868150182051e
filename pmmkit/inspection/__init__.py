"""Looking at files and folders of which nothing is known, without changing anything."""

from pmmkit.inspection.folder import CampaignLook, Group, Look, look
from pmmkit.inspection.seen import Clock, ColumnLook, FileLook

__all__ = ["CampaignLook", "Clock", "ColumnLook", "FileLook", "Group", "Look", "look"]
