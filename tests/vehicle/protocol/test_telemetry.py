"""The vehicle's messages become reports: in order, and those of the vehicle only."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.events import StatusText, VehicleState
from flight_replay.mavlink import dialect
from flight_replay.supervisor.vehicle_interface import (
    Heartbeat,
    HomePosition,
    MissionCurrent,
    MissionItemReached,
    PrearmStatus,
    Rebooted,
    Request,
    RequestAck,
    RequestLost,
)
from flight_replay.vehicle.protocol import telemetry as module
from flight_replay.vehicle.protocol.commands import CommandSender
from flight_replay.vehicle.protocol.telemetry import Telemetry
from tests.helpers.virtual_link import VirtualLink

GOOD = SimpleNamespace(
    is_armable=True,
    gps_0=SimpleNamespace(fix_type=3),
    battery=SimpleNamespace(voltage=12.1, level=80),
)


def telemetry(drone: Any = GOOD) -> Telemetry:
    return Telemetry(drone, CommandSender(VirtualLink()))


def sent(message: Any) -> Any:
    """A message as it is received."""
    frame = message.pack(dialect.MAVLink(None, 1, 1))
    return dialect.MAVLink(None).parse_buffer(frame)[0]


def position(time_ms: int, lat: int = 473977420, lon: int = 85455940) -> Any:
    return sent(
        dialect.MAVLink_global_position_int_message(time_ms, lat, lon, 500000, 12000, 100, -200, 50, 9000)
    )


def heartbeat(mode: int = 4, base: int = 128) -> Any:
    return sent(dialect.MAVLink_heartbeat_message(2, 3, base, mode, 4, 3))


def news_of(*messages: Any, drone: Any = GOOD) -> list[Any]:
    heard = telemetry(drone)
    for message in messages:
        heard.receive(message)
    return list(heard.reports(0.0))


def test_heartbeats_have_mode_and_armed() -> None:
    """Modes by ArduCopter's names; an unknown one by its number."""
    assert news_of(heartbeat(4), heartbeat(99, 0)) == [Heartbeat("GUIDED", True), Heartbeat("mode 99", False)]


def test_the_last_heartbeat_is_kept() -> None:
    """It tells whether the vehicle is armed, whoever takes the reports; an old one tells nothing."""
    heard = telemetry()
    assert heard.heartbeat(60.0) is None
    heard.receive(heartbeat(4, 0))
    heard.receive(heartbeat(3, 128))
    heard.reports(0.0)
    assert heard.heartbeat(60.0) == Heartbeat("AUTO", True)
    assert heard.heartbeat(-1.0) is None


def test_positions_are_in_si_units() -> None:
    """Degrees, metres above home, m/s north, east and up, with mode and battery."""
    _, state = news_of(heartbeat(), position(12345))
    assert state == VehicleState(
        time_s=12.345,
        lat_deg=47.397742,
        lon_deg=8.545594,
        alt_m=12.0,
        velocity_m_s=(1.0, -2.0, -0.5),
        heading_deg=90.0,
        mode="GUIDED",
        armed=True,
        battery_v=12.1,
        battery_percent=80,
    )


@pytest.mark.parametrize(
    ("volts", "level", "known"),
    [(0.0, None, (None, None)), (65.535, None, (None, None)), (11.1, 0, (11.1, 0)), (11.1, -1, (11.1, None))],
)
def test_what_a_vehicle_does_not_know_of_its_battery_is_no_figure(
    volts: float, level: int | None, known: tuple[float | None, int | None]
) -> None:
    """An empty battery is at 0 %, an unknown one at nothing."""
    drone = SimpleNamespace(battery=SimpleNamespace(voltage=volts, level=level))
    _, state = news_of(heartbeat(), position(1000), drone=drone)
    assert isinstance(state, VehicleState)
    assert (state.battery_v, state.battery_percent) == known


def test_a_position_of_0_0_is_ignored() -> None:
    """ArduPilot sends it before it has a position."""
    assert news_of(heartbeat(), position(1000, 0, 0)) == [Heartbeat("GUIDED", True)]


def test_a_position_before_the_first_heartbeat_is_ignored() -> None:
    """Mode and arming are not known before."""
    assert news_of(position(1000)) == []


def test_positions_out_of_order_are_ignored() -> None:
    """An older position that arrives after a newer one."""
    news = news_of(heartbeat(), position(1000), position(1300), position(1100), position(1500))
    times = [state.time_s for state in news if isinstance(state, VehicleState)]
    assert times == [1.0, 1.3, 1.5]


def test_a_clock_that_restarts_is_a_reboot(monkeypatch: pytest.MonkeyPatch) -> None:
    """Old times in a row, without a newer one between; positions count again."""
    clock = [100.0]
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    heard = telemetry()
    heard.receive(heartbeat())
    heard.receive(position(90_000))
    for time_ms in range(1000, 3000, 200):
        clock[0] += 0.2
        heard.receive(position(time_ms))
    kinds = [type(item) for item in heard.reports(0.0)]
    assert kinds.count(Rebooted) == 1
    assert kinds[-1] is VehicleState


def test_what_waited_out_of_order_while_nothing_was_read_is_no_reboot(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A program that was stopped for seconds reads old times at once, and newer ones behind them."""
    clock = [100.0]
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    heard = telemetry()
    heard.receive(heartbeat())
    heard.receive(position(90_000))
    for stopped_s in (3.0, 3.0):
        clock[0] += stopped_s
        for time_ms in range(89_000, 89_900, 100):
            clock[0] += 0.001
            heard.receive(position(time_ms))
    heard.receive(position(96_000))
    kinds = [type(item) for item in heard.reports(0.0)]
    assert Rebooted not in kinds
    assert kinds[-1] is VehicleState


def test_long_texts_are_joined() -> None:
    """MAVLink 2 sends more than 50 characters in chunks."""
    pieces = ["x" * 50, "y" * 50, "end"]
    messages = [
        sent(dialect.MAVLink_statustext_message(3, piece.encode(), id=7, chunk_seq=n))
        for n, piece in enumerate(pieces)
    ]
    assert news_of(*messages) == [StatusText(3, "".join(pieces))]
    assert news_of(messages[0], *messages) == [StatusText(3, "".join(pieces))]
    assert news_of(sent(dialect.MAVLink_statustext_message(6, b"short"))) == [StatusText(6, "short")]


def test_mission_progress_is_reported() -> None:
    """Current item, total and completion if the firmware reports them; items reached."""
    current = dialect.MAVLink_mission_current_message(3, 20, 5)
    unknown = dialect.MAVLink_mission_current_message(3, 65535, 0)
    reached = dialect.MAVLink_mission_item_reached_message(2)
    assert news_of(sent(current), sent(unknown), sent(reached)) == [
        MissionCurrent(3, 20, True),
        MissionCurrent(3, None, False),
        MissionItemReached(2),
    ]


def system_status(enabled: int, health: int) -> Any:
    return sent(
        dialect.MAVLink_sys_status_message(enabled, enabled, health, 0, 12000, 10, 80, 0, 0, 0, 0, 0, 0)
    )


PREARM = dialect.MAV_SYS_STATUS_PREARM_CHECK
NO_FIX = SimpleNamespace(is_armable=False, gps_0=SimpleNamespace(fix_type=1), battery=None)


def no_estimate(satellites: int | None) -> Any:
    gps = SimpleNamespace(fix_type=3, satellites_visible=satellites)
    return SimpleNamespace(is_armable=False, gps_0=gps, battery=None)


NO_ESTIMATE = no_estimate(10)


EKF_STATUS = dialect.MAVLink_ekf_status_report_message(0, 0, 0, 0, 0, 0)
GPS_RAW = dialect.MAVLink_gps_raw_int_message(0, 1, 0, 0, 0, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("drone", "health", "ready", "words"),
    [
        (GOOD, PREARM, True, ""),
        (GOOD, 0, False, "pre-arm checks fail"),
        (NO_FIX, PREARM, False, "no GPS fix yet"),
        (NO_ESTIMATE, PREARM, False, "no EKF position estimate yet"),
        (no_estimate(None), PREARM, False, "no EKF position estimate yet"),
        (no_estimate(4), PREARM, False, "no EKF position estimate yet, with 4 satellites only"),
    ],
    ids=["ready", "checks", "no fix", "no estimate", "untold", "few satellites"],
)
def test_prearm_status_needs_position_and_prearm_checks(
    drone: Any, health: int, ready: bool, words: str
) -> None:
    """The reason where the autopilot's own text has not come yet."""
    *_, readiness = news_of(sent(EKF_STATUS), sent(GPS_RAW), system_status(PREARM, health), drone=drone)
    assert readiness == PrearmStatus(ready, words)


@pytest.mark.parametrize(("drone", "name"), [(NO_FIX, "GPS_RAW_INT"), (NO_ESTIMATE, "EKF_STATUS_REPORT")])
def test_a_message_that_never_came_is_not_taken_for_a_position_that_is_not_there(
    drone: Any, name: str
) -> None:
    """A slow link, or a station that stopped its stream, keeps it away for good."""
    (readiness,) = news_of(system_status(PREARM, PREARM), drone=drone)
    assert readiness == PrearmStatus(False, f"no {name} message yet")


def test_firmware_without_prearm_bit_is_ready_with_its_position() -> None:
    """ArduCopter 3.3 does not report its pre-arm checks: GPS and EKF are enough."""
    assert news_of(system_status(0, 0)) == [PrearmStatus(True)]


def ack(command: int, result: int) -> Any:
    return sent(dialect.MAVLink_command_ack_message(command, result))


def test_acks_name_the_request() -> None:
    """Accepted and refused commands; acks of progress and of other commands are ignored."""
    assert news_of(ack(400, 0), ack(22, 4), ack(400, 5), ack(511, 0)) == [
        RequestAck(Request.ARM, True),
        RequestAck(Request.TAKEOFF, False, "failed"),
    ]


def test_acks_to_other_stations_are_ignored() -> None:
    """Another station's refusal neither repeats our request nor switches to SET_MODE."""
    refused = [sent(dialect.MAVLink_command_ack_message(176, result, 0, 0, 255, 190)) for result in (3, 4)]
    assert news_of(*refused) == []


def test_an_unsupported_mode_command_becomes_set_mode() -> None:
    """At once, and from then on."""
    link = VirtualLink()
    commands = CommandSender(link)
    commands.set_mode(4)
    assert commands.on_ack(ack(176, 3)) is None
    commands.set_mode(3)
    asked = [m for m in link.sent if m.get_type() != "TIMESYNC"]
    assert [m.get_type() for m in asked] == ["COMMAND_LONG", "SET_MODE", "SET_MODE"]
    assert [m.custom_mode for m in asked[1:]] == [4, 3]


def test_an_unacked_mode_is_sent_both_ways() -> None:
    """A lost packet or an old autopilot: after two commands SET_MODE is sent as well."""
    link = VirtualLink()
    commands = CommandSender(link)
    for _ in range(3):
        commands.set_mode(4)
    asked = [m.get_type() for m in link.sent if m.get_type() != "TIMESYNC"]
    assert asked == ["COMMAND_LONG"] * 3 + ["SET_MODE"]


def echo_of(ping: Any, vehicle_ns: int = 5) -> Any:
    return sent(dialect.MAVLink_timesync_message(vehicle_ns, ping.ts1))


def test_a_timesync_reply_without_an_ack_means_a_lost_request() -> None:
    """It is reported once, and not after an ack."""
    link = VirtualLink()
    commands = CommandSender(link)
    commands.arm()
    ping = link.sent[-1]
    assert commands.on_timesync(echo_of(ping, vehicle_ns=0)) is None, "a question, not an echo"
    assert commands.on_timesync(echo_of(ping)) == RequestLost(Request.ARM)
    assert commands.on_timesync(echo_of(ping)) is None
    link.pass_time(0.1)
    commands.set_mode(3)
    assert commands.on_timesync(echo_of(ping)) is None, "an echo from before the request"
    commands.on_ack(ack(176, 0))
    assert commands.on_timesync(echo_of(link.sent[-1])) is None


def test_a_lost_timesync_is_sent_again_but_not_for_ever() -> None:
    """A reply to any of them counts; an autopilot that never replies is left alone."""
    link = VirtualLink()
    commands = CommandSender(link)
    commands.set_mode(3)
    commands.retry_ping()
    assert [m.get_type() for m in link.sent] == ["COMMAND_LONG", "TIMESYNC"], "the first may yet come"
    for _ in range(50):
        link.pass_time(link.round_trip.retry_s)
        commands.retry_ping()
    pings = [m for m in link.sent if m.get_type() == "TIMESYNC"]
    assert 10 < len(pings) < 30
    assert commands.on_timesync(echo_of(pings[3])) == RequestLost(Request.MODE)


def test_a_duplicated_frame_counts_once() -> None:
    """Two copies of a heartbeat are one; a second heartbeat has another sequence number."""
    mav = dialect.MAVLink(None, 1, 1)
    beats = []
    for _ in range(2):
        beats.append(dialect.MAVLink_heartbeat_message(2, 3, 128, 5, 4, 3).pack(mav))
        mav.seq += 1
    heard = telemetry()
    for frame in (beats[0], beats[0], beats[1], beats[0]):
        heard.receive(dialect.MAVLink(None).parse_buffer(frame)[0])
    assert list(heard.reports(0.0)) == [Heartbeat("LOITER", True)] * 2


@pytest.mark.parametrize(
    ("sent_text", "readable"),
    [
        (b"\x1b[31mEVIL\x1b]0;title\x07\r\nmore", "[31mEVIL ]0;title more"),
        (b"  two  spaces ", "two spaces"),
        (b"caf\xe9", "caf\N{REPLACEMENT CHARACTER}"),
    ],
)
def test_status_texts_cannot_control_the_terminal(sent_text: bytes, readable: str) -> None:
    """Escape codes and line ends are removed."""
    text = sent(dialect.MAVLink_statustext_message(3, sent_text))
    assert news_of(text) == [StatusText(3, readable)]


def test_heartbeats_without_sequence_numbers_all_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Equal frames a second apart are not duplicates."""
    heard = telemetry()
    for now_s in (100.0, 100.3, 101.0, 102.0):
        monkeypatch.setattr(time, "monotonic", lambda now_s=now_s: now_s)
        heard.receive(heartbeat(5))
    assert list(heard.reports(0.0)) == [Heartbeat("LOITER", True)] * 3


def test_without_a_report_nothing_is_returned() -> None:
    """When the time to wait for one is over."""
    assert list(telemetry().reports(0.0)) == []


def test_home_is_told_where_it_is() -> None:
    """Degrees, and metres above sea level."""
    message = dialect.MAVLink_home_position_message(
        473977420, 85455940, 488_100, 0, 0, 0, (1, 0, 0, 0), 0, 0, 0
    )
    assert news_of(sent(message)) == [HomePosition(47.397742, 8.545594, 488.1)]


def test_who_moves_home_in_flight_does_not_move_the_vehicle() -> None:
    """Heights stay above the home of arming, which arming itself moves, until the next arming."""

    def at(time_ms: int, home_m: float, above_home_m: float) -> Any:
        amsl_m = home_m + above_home_m
        return sent(
            dialect.MAVLink_global_position_int_message(
                time_ms, 473977420, 85455940, round(amsl_m * 1e3), round(above_home_m * 1e3), 0, 0, 0, 0
            )
        )

    told = news_of(
        heartbeat(4, 0), at(1000, 480.0, 5.0), heartbeat(4, 128), at(2000, 485.0, 0.0), at(3000, 485.0, 30.0),
        at(4000, 515.0, 0.0), at(5000, 515.4, 1.0), at(6000, 515.4, -25.0),
        heartbeat(9, 0), at(7000, 515.4, -30.0), heartbeat(5, 128), at(8000, 490.0, 0.0),
    )  # fmt: skip
    heights_m = [report.alt_m for report in told if isinstance(report, VehicleState)]
    assert heights_m == pytest.approx([5.0, 0.0, 30.0, 30.0, 31.0, 5.0, 0.0, 0.0])
