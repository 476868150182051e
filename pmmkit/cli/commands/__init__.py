"""The commands, one a file: a file ``name.py`` with a function ``name`` is the command."""
