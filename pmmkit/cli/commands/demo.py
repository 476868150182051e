"""``pmmkit demo``."""

from __future__ import annotations

from pathlib import Path

from pmmkit.cli.options import Out
from pmmkit.cli.output import Outcome


def demo(out: Out = None) -> Outcome:
    """Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""
    from pmmkit.cli.commands.reduce import reduced
    from pmmkit.files import datasets_folder

    return reduced(
        datasets_folder() / "s175",
        out or Path("pmmkit-demo"),
        parts="s175-3dof",
        reference="s175-3dof",
        reference_name="Son and Nomoto 1981",
        asked="cubic",
    )
