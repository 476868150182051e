"""The application with all of its commands."""

from pmmkit.cli import commands, identify_commands, model_commands, trial_commands
from pmmkit.cli.options import app

__all__ = ["app", "commands", "identify_commands", "model_commands", "trial_commands"]
