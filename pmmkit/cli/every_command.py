"""The application with all of its commands."""

from pmmkit.cli import (
    commands,
    compare_commands,
    diagnosis_commands,
    export_commands,
    identify_commands,
    inspect_commands,
    model_commands,
    plan_commands,
    trial_commands,
)
from pmmkit.cli.options import app

__all__ = [
    "app",
    "commands",
    "compare_commands",
    "diagnosis_commands",
    "export_commands",
    "identify_commands",
    "inspect_commands",
    "model_commands",
    "plan_commands",
    "trial_commands",
]
