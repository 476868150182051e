"""``python -m pmmkit`` is the command ``pmmkit``."""

import sys

from pmmkit.cli import main

if __name__ == "__main__":
    sys.exit(main())
