"""The table ``[imo]``: what the form of MSC/Circ.1053 asks for and no record holds."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pmmkit.campaigns.file.single_tables import Entry, Names, Positive, said


class ImoEntry(Entry):
    """``[imo]``, of a campaign file or of a file of its own."""

    administration: str | None = said("to which the form goes", None)
    reference: str | None = said("reference number that the administration assigns", None)
    ship_type: str | None = said("such as container ship, tanker, bulk carrier", None)
    rudder_type: str | None = said("such as full spade, semi-spade, high lift", None)
    rudders: Annotated[int, Field(ge=0)] | None = said("how many", None)
    rudder_area: Positive | None = said("of all rudders together [m²]", None)
    propeller_type: str | None = said("such as fixed pitch, controllable pitch, with nozzle", None)
    propellers: Annotated[int, Field(ge=0)] | None = said("how many", None)
    engine_type: str | None = said("such as diesel, steam turbine, diesel-electric", None)
    full_load_draught: Positive | None = said("mean draught of full load [m]", None)
    full_load_trim: float | None = said("trim of full load, by the stern positive [m]", None)
    full_load_block: Annotated[float, Field(gt=0, le=1)] | None = said(
        "block coefficient of full load; that of `[ship]` where its draught is that of full load",
        None,
    )
    ballast: str | None = said("the ballast condition in words", None)
    draught_fore: Positive | None = said("draught forward as tried [m]", None)
    draught_aft: Positive | None = said("draught aft as tried [m]", None)
    wind_beaufort: Annotated[int, Field(ge=0, le=12)] | None = said(
        "wind of the trial; a recorded wind counts before it", None
    )
    sea_state: Annotated[int, Field(ge=0, le=9)] | None = said("waves of the trial", None)
    speed_85: Positive | None = said("speed at 85 % of the engine's largest output [m/s]", None)
    place: str | None = said("of the trial", None)
    date: str | None = said("of the trial", None)
    remarks: Names | None = said("sentences for the form", None)
