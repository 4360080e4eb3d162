"""The exception that ends a flight early, and the message for each cause."""

from __future__ import annotations

_NOW = {
    "ALT_HOLD": "take control, the vehicle drifts",
    "BRAKE": "take control, the vehicle hovers there",
    "AVOID_ADSB": "watch the vehicle, it may fly on by itself",
}
"""What a person has to do where the vehicle chose a mode."""

_STRAIGHT = 0.8
"""With so much of the distance it is above or below, not beside."""


class FlightEnded(Exception):  # noqa: N818 - it becomes an error only before AUTO
    """The flight cannot go on as planned: ``ended`` and ``problem`` as in ``FlightRecord``."""

    def __init__(self, ended: str, problem: str) -> None:
        super().__init__(problem)
        self.ended = ended
        self.problem = problem


def quoted(reason: str) -> str:
    """The vehicle's own reason, a status text, as the end of a clause; empty where it gave none."""
    return f': it says "{reason}"' if reason else ""


class LandedElsewhere(FlightEnded):
    """The vehicle has landed, but not where RTL goes."""


class Fallen(FlightEnded):
    """The vehicle falls, or has fallen, and may lie on the ground with its motors running."""


def link_lost(silence: str, chosen_mode: str | None = None, *, may_be_armed: bool = True) -> FlightEnded:
    """No data came from the vehicle until the deadline; ``silence`` says for how long.

    ``chosen_mode`` is that of the last heartbeat if somebody else chose it. A vehicle that was never
    asked to arm has no failsafe to wait for.
    """
    now = (
        "; its own failsafe takes over: watch it, and check the link" if may_be_armed else "; check the link"
    )
    if chosen_mode:
        now = (
            f"; its last heartbeat showed {chosen_mode}, which somebody else chose, "
            "and flight-replay sends no more commands: watch it, and check the link"
        )
    return FlightEnded("link lost", f"link to the vehicle lost: {silence}{now}")


def internal_error(fault: str) -> FlightEnded:
    """An error of this program, told in ``fault``, keeps it from hearing the vehicle."""
    return FlightEnded("internal error", fault)


def pilot(mode: str | None) -> FlightEnded:
    """The pilot, or another ground station, changed the mode."""
    return FlightEnded(
        "pilot",
        f"the mode was changed to {mode} by the pilot or another ground station; "
        "flight-replay sends no more commands",
    )


def failsafe(mode: str | None, reason: str) -> FlightEnded:
    """The mode is one of a failsafe; ``reason`` is the vehicle's status text, or empty."""
    what = f"the vehicle changed to {mode} by itself: {reason}"
    if mode == "AVOID_ADSB":
        what = "the vehicle changed to AVOID_ADSB by itself, to keep away from another aircraft"
    elif not reason:
        who = "the pilot, a failsafe or another ground station"
        what = f"the mode was changed to {mode} by {who}, and no reason was given"
    now = _NOW.get(mode or "", "watch the vehicle")
    return FlightEnded("failsafe", f"{what}; flight-replay sends no more commands: {now}")


def not_rtl(mode: str | None, failsafe: str) -> str:
    """Told of a vehicle that was in RTL, until somebody or a failsafe chose another mode.

    ``failsafe`` is the vehicle's status text of one, or empty.
    """
    now = "flight-replay sends no more commands: watch the vehicle until it has landed"
    return f"RTL became {mode}: {_who_changed_it(failsafe)}; {now}"


def _who_changed_it(failsafe: str) -> str:
    return (
        f'it says "{failsafe}"' if failsafe else "the pilot, another ground station or a failsafe changed it"
    )


def landed_elsewhere(from_home_m: float, failsafe: str) -> LandedElsewhere:
    """RTL became LAND on the way, as ``not_rtl`` told."""
    return LandedElsewhere(
        "no progress",
        f"the vehicle landed {from_home_m:.0f} m away from home: RTL became LAND: "
        f"{_who_changed_it(failsafe)}; fetch it, and find out why before flying again",
    )


def left_alone(mode: str | None) -> str:
    """Told instead of RTL, after an error or Ctrl-C, when somebody else has the vehicle."""
    return (
        f"no RTL is commanded: somebody else chose the mode, which is {mode}; "
        "watch the vehicle until it has landed"
    )


def rebooted() -> FlightEnded:
    """The autopilot rebooted."""
    return FlightEnded("reboot", "the autopilot rebooted; find out why before flying again")


def no_position(heartbeats: int) -> FlightEnded:
    """Heartbeats go on, and no position has come among the last of them."""
    return FlightEnded(
        "no progress",
        f"the vehicle has told no position for {heartbeats} s, and its flight cannot be supervised; "
        "check its stream rates, the link and its GPS",
    )


def clock_jumped(step_s: float) -> FlightEnded:
    """The vehicle's clock, which times the flight, jumped ahead by ``step_s``."""
    return FlightEnded(
        "no progress",
        f"the vehicle's clock jumped ahead by {step_s:.0f} s, and nothing tells how long the flight has "
        "lasted; find out why before flying again",
    )


def jumped(jump: str) -> str:
    """Told in flight where ``jump`` tells of one of the position estimate: its GPS is, or was, wrong."""
    return f"{jump}: it flies, returns and lands that far from where it seems to; check its GPS and watch it"


def off_course(apart_m: float, higher_m: float, jump: str) -> FlightEnded:
    """The vehicle was too far from where it was to be, of which ``higher_m`` above it.

    ``jump`` is the beginning of a sentence where its position estimate has just jumped, or empty.
    """
    kind, where, check = FlightEnded, "from", "wind, fence, limits and load"
    if -higher_m > _STRAIGHT * apart_m:
        kind, where, check = Fallen, "below", "its motors, battery, load and limits"
    elif higher_m > _STRAIGHT * apart_m:
        where, check = "above", "its barometer, wind and limits"
    who, what_now = "the vehicle was", f"check {check}, or allow more with --max-error"
    if jump:
        who, what_now = f"{jump}, and it was", "check its GPS, and watch where it lands"
    return kind("off course", f"{who} {apart_m:.1f} m {where} where it was to be; {what_now}")


def sank(altitude_m: float, lowest_m: float, reason: str) -> FlightEnded:
    """The vehicle came far below all that it is to fly; ``reason`` is its status text, or empty."""
    return Fallen(
        "off course",
        f"the vehicle sinks, or has fallen: it is {altitude_m:.1f} m above home, and was to be at "
        f"{lowest_m:.0f} m or higher{quoted(reason)}; keep away until it is disarmed, its motors may "
        "start again",
    )


def sank_in_takeoff(highest_m: float, now_m: float, reason: str) -> FlightEnded:
    """The vehicle lost what it had climbed; ``reason`` is its status text, or empty."""
    return Fallen(
        "off course",
        f"the vehicle sank from {highest_m:.1f} m to {now_m:.1f} m during take-off{quoted(reason)}; "
        "keep away from it until it is disarmed, and find out why",
    )


def disarmed(reason: str) -> FlightEnded:
    """The vehicle disarmed; ``reason`` is its status text, or empty."""
    return FlightEnded(
        "disarmed", f"the vehicle disarmed in flight{quoted(reason)}; find out why before flying again"
    )


def disarmed_unseen(reason: str) -> FlightEnded:
    """The vehicle disarmed on its way home while nothing came from it that tells whether it had landed."""
    return FlightEnded(
        "disarmed",
        f"the vehicle disarmed{quoted(reason)}, and no position tells whether it had landed; look for it",
    )
