"""The S175 model at 1:36 as a campaign file states it, for tests and studies that write one."""

from __future__ import annotations

from typing import Final

S175: Final = """[ship]
name = "S175 model"
L = 4.861111
B = 0.705556
d = 0.236111
mass = 454.476
Izz = 618.332
volume = 0.454861
[water]
rho = 999.1
"""
