"""Model-test results as the SIMMAN workshops ask for them."""

from pmmkit.exports.simman.write import write_simman

__all__ = ["write_simman"]
