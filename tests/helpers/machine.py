"""The machine that runs the tests: what else it is doing, and its address."""

import socket
import time

_MEASURED_S = 0.1


def cpu_share() -> float:
    """The share of a core that a program which only computes gets now; 1 on an idle machine."""
    began_s, began_cpu_s = time.monotonic(), time.thread_time()
    while time.thread_time() - began_cpu_s < _MEASURED_S:
        pass
    return _MEASURED_S / (time.monotonic() - began_s)


def free_udp_port() -> int:
    """A UDP port that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def outside_address() -> str:
    """An address of this machine other than 127.0.0.1, outside loopback if it has one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return "127.0.0.2"
        return str(probe.getsockname()[0])
