"""``python -m pmmkit`` is the command ``pmmkit``."""

from pmmkit.cli import main

if __name__ == "__main__":
    main()
