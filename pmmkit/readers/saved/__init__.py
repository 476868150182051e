"""Campaigns that pmmkit saved."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from pmmkit.readers.base import Cells, Choose, Columns, Reader, Request


class SavedCampaign(Reader):
    """Histories inside an HDF5 file that pmmkit saved: already SI and in ship axes."""

    name = "pmmkit"
    words = "campaign saved by pmmkit"
    reads = "Histories of a saved campaign, already SI and in ship axes."
    binary = True
    campaign = True
    keys = ("group",)

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file is a campaign that pmmkit saved, by its attributes."""
        from pmmkit.readers.hdf5.datasets import is_hdf5, is_saved_campaign

        return is_hdf5(head) and is_saved_campaign(path)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some channels of the run named by ``group``, by default the run's own id."""
        from pmmkit.readers.saved.file import read_run

        data = read_run(request.path, request.options.group or request.run or "")
        headers = tuple(str(name) for name in data.variables if data[name].dims == ("t",))
        if "t" not in headers:
            raise request.error(
                "the run that was saved there is not a history.",
                remedy="Open the saved file itself as the campaign.",
            )
        wanted = tuple(choose(headers, len(headers)))
        return Columns(
            headers=headers,
            positions=wanted,
            values=tuple(np.asarray(data[headers[place]].values, dtype=float) for place in wanted),
            notes=tuple(json.loads(data.attrs.get("conversions", "[]"))),
        )

    def cells(self, request: Request) -> Cells:
        """Not a table: always refused."""
        raise request.error("an HDF5 file of pmmkit holds runs, not a table of rows.")
