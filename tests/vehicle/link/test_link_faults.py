"""link_faults.py: errors of the program on the link's thread, and whether it hears the vehicle."""

import pytest

from flight_replay.exceptions import LinkFaultError
from flight_replay.vehicle.link.link_faults import LinkFaults


class Clock:
    """A clock that tests set."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_faults_between_messages_are_noted_only() -> None:
    """The first is told, whatever follows; the vehicle is heard."""
    clock = Clock()
    faults = LinkFaults(clock)
    assert faults.first == ""
    for number in range(20):
        faults.note(f"process PING {number}", ValueError("no"))
        clock.now_s += 1.0
        faults.passed()
        faults.check()
    assert faults.first == (
        "cannot process PING 0: internal error (ValueError: no); please report it with the output of -v"
    )


def test_faults_with_no_message_between_them_are_an_error() -> None:
    """Not one alone, however long the silence, nor many at once; until the vehicle is heard again."""
    clock = Clock()
    faults = LinkFaults(clock)
    faults.note("read the link", KeyError(5))
    clock.now_s += 60.0
    faults.check()
    faults.passed()
    for _ in range(5):
        faults.check()
        faults.note("read the link", SystemExit("no"))
    faults.check()
    clock.now_s += 1.0
    with pytest.raises(LinkFaultError, match=r"nothing is heard .* read the link: .* \(SystemExit: no\)"):
        faults.check()
    faults.passed()
    faults.check()
