"""What else the machine that runs the tests is doing."""

import time

_MEASURED_S = 0.1


def cpu_share() -> float:
    """The share of a core that a program which only computes gets now; 1 on an idle machine."""
    began_s, began_cpu_s = time.monotonic(), time.thread_time()
    while time.thread_time() - began_cpu_s < _MEASURED_S:
        pass
    return _MEASURED_S / (time.monotonic() - began_s)
