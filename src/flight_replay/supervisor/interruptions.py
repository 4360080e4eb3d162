"""Turns of events that end a flight as planned, each with its sentence."""

from __future__ import annotations


class Interrupted(Exception):  # noqa: N818 - a turn of events, which only becomes an error in flight
    """The flight cannot go on as planned: ``ended`` and ``problem`` as in FlightRecord."""

    def __init__(self, ended: str, problem: str) -> None:
        super().__init__(problem)
        self.ended = ended
        self.problem = problem


def link_lost(silence: str) -> Interrupted:
    """The vehicle was not heard for as long as ``silence`` says."""
    return Interrupted(
        "link lost",
        f"the link to the vehicle is lost, {silence}; "
        "its own failsafe decides now: watch it, and check the link",
    )


def taken_over(mode: str | None) -> Interrupted:
    """Somebody else chose a mode."""
    return Interrupted(
        "pilot", f"the mode was changed to {mode} by somebody else, who has control of the vehicle now"
    )


def failsafe(mode: str | None, words: str) -> Interrupted:
    """The vehicle chose a mode, for a reason that it gave in ``words``, or did not give."""
    why = f"by itself: {words}" if words else "without being asked to from here"
    return Interrupted("failsafe", f"the vehicle changed to {mode} {why}; it was let go")


def rebooted() -> Interrupted:
    """The autopilot started anew."""
    return Interrupted("reboot", "the autopilot rebooted; check why before flying again")
