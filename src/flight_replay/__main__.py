"""``python -m flight_replay``."""

import sys

from flight_replay.cli import main

if __name__ == "__main__":
    sys.exit(main())
