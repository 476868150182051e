"""The application with all of its commands."""

from pmmkit.cli import commands, model_commands
from pmmkit.cli.options import app

__all__ = ["app", "commands", "model_commands"]
