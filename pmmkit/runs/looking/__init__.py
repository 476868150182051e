"""Looking at files and folders of which nothing is known, without changing anything."""

from pmmkit.runs.looking.folder import CampaignLook, Group, Look, look
from pmmkit.runs.looking.seen import Clock, ColumnLook, FileLook

__all__ = ["CampaignLook", "Clock", "ColumnLook", "FileLook", "Group", "Look", "look"]
