"""All kinds of test: those of this folder and those of installed packages."""

from __future__ import annotations

from typing import Final

from pmmkit.base import Registry, listed_in
from pmmkit.campaigns.test_kinds.kind import TestKind

GROUP: Final = "pmmkit.test_kinds"
"""Entry points by which other packages bring their kinds of test."""
TEST_KINDS: Final = Registry(
    TestKind,
    listed_in(
        "pmmkit.campaigns.test_kinds", "KINDS", first=("steady", "oscillating", "free_running")
    ),
    what="kind of test",
    group=GROUP,
    unknown="{name!r} is not one of {names}{guess}",
    contract="pmmkit.testing.test_kinds:check_test_kind",
)
"""All kinds of test by name: steady, oscillating, free running, then those of other packages."""
