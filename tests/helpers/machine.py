"""What else the machine that runs the tests is doing."""

import os


def slowdown() -> float:
    """How many times as long work takes that processes hand on to each other; 1 on an idle machine.

    Each of two processes waits for a core as long as the programs per core say.
    """
    try:
        load, _, _ = os.getloadavg()
    except (AttributeError, OSError):  # Windows
        return 1.0
    return max(1.0, load / (os.cpu_count() or 1)) ** 2
