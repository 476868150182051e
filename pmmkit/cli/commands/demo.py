"""``pmmkit demo``."""

from __future__ import annotations

from typing import Final

from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import Out, results_folder

EXAMPLE: Final = "pmmkit demo --out my-demo"


def demo(out: Out = None) -> Outcome:
    """Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""
    from pmmkit.cli.commands.reduce import reduced
    from pmmkit.files import datasets_folder

    return reduced(
        datasets_folder() / "s175",
        results_folder(out, "pmmkit-demo"),
        parts="s175-3dof",
        reference="s175-3dof",
        reference_name="Son and Nomoto 1981",
        asked="cubic",
    )
