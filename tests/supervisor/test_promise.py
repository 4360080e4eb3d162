"""The promise: whatever any part raises at any moment, RTL is commanded while the vehicle may be armed."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import struct
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import replace
from functools import partial
from types import FunctionType
from typing import Any

import numpy as np
import pytest

from flight_replay import supervisor
from flight_replay.events import (
    Climbing,
    Event,
    Notice,
    ReturnCommanded,
    TargetAltitudeReached,
    VehicleState,
)
from flight_replay.supervisor import FollowPlan, Plan, fly
from flight_replay.supervisor.vehicle_interface import Vehicle
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route
from tests.helpers.supervised import RECORDED_S, s_curve

FAULTS: tuple[type[BaseException], ...] = (
    OSError, RuntimeError, AttributeError, TypeError, ValueError, KeyError, MemoryError, RecursionError,
    struct.error, AssertionError, KeyboardInterrupt, SystemExit, GeneratorExit,
)  # fmt: skip
POINTS = 8
MISSION = Plan(mission=route(POINTS), duration_s=20.0, takeoff_altitude_m=10.0)
FOLLOWING = FollowPlan(reference=s_curve(), recorded_s=RECORDED_S, duration_s=5.0, takeoff_altitude_m=10.0)
PLANS: dict[str, Plan | FollowPlan] = {"auto": MISSION, "guided": FOLLOWING}
PARTS = tuple(name for name in vars(Vehicle) if not name.startswith("_"))


class Faults:
    """Counts the calls into every part of a flight, and raises in those that are chosen."""

    def __init__(self, chosen: dict[int, type[BaseException]], *, before: bool = True) -> None:
        self.parts: list[object] = []
        """Which part was called, call by call."""
        self._chosen, self._before = chosen, before

    @property
    def calls(self) -> int:
        return len(self.parts)

    def around(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """The call, which raises before or after its work when its turn is a chosen one."""

        def counted(*arguments: Any) -> Any:
            self.parts.append(call)
            fault = self._chosen.get(self.calls)
            if fault is not None and self._before:
                raise fault("injected")
            result = call(*arguments)
            if fault is not None:
                raise fault("injected")
            return result

        return counted


def flown(faults: Faults, plan: Plan | FollowPlan) -> FakeVehicle:
    """A vehicle after a flight in which every part was called through ``faults``."""
    clock = FakeClock()

    class Watched(FakeVehicle):
        pass

    for name in PARTS:
        part = getattr(FakeVehicle, name)
        is_property = isinstance(part, property)
        setattr(Watched, name, property(faults.around(part.fget)) if is_property else faults.around(part))
    vehicle = Watched(clock, points=POINTS)

    def listen(_event: Event) -> None:
        return

    watched = FakeClock()
    watched.monotonic_s = faults.around(lambda: clock.now_s)  # type: ignore[method-assign]
    with suppress(BaseException):
        fly(vehicle, watched, plan, faults.around(listen))
    return vehicle


def assert_sent_home(vehicle: FakeVehicle, story: object) -> None:
    """Armed, or asked to arm: then the last word on the mode is RTL."""
    if "arm" in vehicle.requested:
        assert vehicle.mode == "RTL" and "RTL" in vehicle.requested, story


def calls_of_a_whole_flight(plan: Plan | FollowPlan) -> list[list[int]]:
    """The numbers of the calls into each part, and of the calls that a fault may add."""
    faults = Faults({})
    vehicle = flown(faults, plan)
    assert vehicle.requested[-1] == "RTL"
    calls: dict[object, list[int]] = {}
    for number, part in enumerate(faults.parts, 1):
        calls.setdefault(part, []).append(number)
    return [*calls.values(), list(range(faults.calls + 1, faults.calls + 50))]


def injected(seed: int, count: int, plan: Plan | FollowPlan) -> None:
    """Fly ``count`` times with one to three faults at random calls of random parts, some that stay."""
    parts = calls_of_a_whole_flight(plan)
    chance = np.random.default_rng(seed)
    for number in range(count):
        chosen = {
            int(chance.choice(parts[part])): FAULTS[chance.integers(len(FAULTS))]
            for part in chance.integers(len(parts), size=chance.integers(1, 4))
        }
        if chance.random() < 0.3:
            first, stays = min(chosen), int(chance.integers(2, 6))
            chosen |= dict.fromkeys(range(first, first + stays), chosen[first])
        faults = Faults(chosen, before=bool(chance.random() < 0.5))
        assert_sent_home(flown(faults, plan), (seed, number, chosen))


@pytest.mark.parametrize(("way", "count"), [("auto", 300), ("guided", 100)])
def test_rtl_is_commanded_whatever_is_raised(way: str, count: int) -> None:
    """Flights with faults injected into vehicle, clock and listener."""
    injected(1, count, PLANS[way])


@pytest.mark.slow
@pytest.mark.parametrize(("way", "count"), [("auto", 600), ("guided", 250)])
@pytest.mark.parametrize("seed", range(2, 12))
def test_rtl_is_commanded_whatever_is_raised_often(seed: int, way: str, count: int) -> None:
    """The same in thousands of flights."""
    injected(seed, count, PLANS[way])


@pytest.mark.parametrize("part", ["send_target", "request_position", "request_speed", "round_trip_s"])
def test_rtl_is_commanded_when_a_part_of_following_fails(part: str) -> None:
    """At its first call, and at its last before the flight would have ended."""
    counts = Faults({})
    vehicle = FakeVehicle(FakeClock())
    setattr(vehicle, part, counts.around(getattr(vehicle, part)))
    plan = replace(FOLLOWING, approach_m_s=3.0)
    fly(vehicle, vehicle.clock, plan)
    for number in (1, counts.calls):
        vehicle = FakeVehicle(FakeClock())
        setattr(vehicle, part, Faults({number: OSError}).around(getattr(vehicle, part)))
        with pytest.raises(OSError, match="injected"):
            fly(vehicle, vehicle.clock, plan)
        assert_sent_home(vehicle, number)


@pytest.mark.parametrize("fault", [OSError, AttributeError, KeyboardInterrupt])
def test_a_request_that_fails_is_sent_again(fault: type[BaseException]) -> None:
    """RTL itself may be what fails."""
    clock = FakeClock()
    vehicle = FakeVehicle(clock, points=POINTS)
    request_mode, failures = vehicle.request_mode, [3]

    def failing(mode: str) -> None:
        if mode == "RTL" and failures[0]:
            failures[0] -= 1
            raise fault("injected")
        request_mode(mode)

    vehicle.request_mode = failing  # type: ignore[method-assign]
    with pytest.raises(fault):
        fly(vehicle, clock, Plan(mission=route(POINTS), duration_s=5.0))
    assert vehicle.mode == "RTL"


@pytest.mark.parametrize("way", PLANS)
@pytest.mark.parametrize("since", [Climbing, TargetAltitudeReached, VehicleState, ReturnCommanded])
@pytest.mark.parametrize("fault", [OSError, KeyboardInterrupt, SystemExit, GeneratorExit])
def test_a_listener_that_raises_for_ever_does_not_hold_rtl_back(
    fault: type[BaseException], since: type[Event], way: str
) -> None:
    """From the first event of a kind on: in the climb, above, armed or being armed, and on the way home."""
    vehicle = FakeVehicle(FakeClock(), points=POINTS)
    raises = False

    def listen(event: Event) -> None:
        nonlocal raises
        raises = raises or (isinstance(event, since) and "arm" in vehicle.requested)
        if raises:
            raise fault("injected")

    with nullcontext() if issubclass(fault, Exception) else pytest.raises(fault):
        fly(vehicle, vehicle.clock, PLANS[way], listen)
    assert_sent_home(vehicle, since)
    assert raises


@pytest.mark.parametrize("fault", [KeyboardInterrupt, SystemExit])
def test_a_listener_that_raises_when_an_error_is_told_does_not_hold_rtl_back(
    fault: type[BaseException],
) -> None:
    """As Ctrl-C does that comes then: the vehicle is on its way home before it ends the program."""
    clock = FakeClock()
    vehicle = FakeVehicle(clock, points=POINTS, refuse_mode=frozenset({"AUTO"}))
    told: list[Event] = []

    def listen(event: Event) -> None:
        told.append(event)
        if isinstance(event, Notice):
            raise fault("injected")

    with pytest.raises(fault):
        fly(vehicle, clock, MISSION, listen)
    assert vehicle.requested[-2:] == ["AUTO", "RTL"]
    assert told[-1] == ReturnCommanded(True)


MODULES = [
    found.name
    for found in pkgutil.walk_packages(supervisor.__path__, f"{supervisor.__name__}.")
    if found.name not in (fly.__module__, Vehicle.__module__) and not found.ispkg
]


def functions_of(module_name: str) -> Iterator[FunctionType]:
    """The functions and methods of a module that can be broken."""
    module = importlib.import_module(module_name)
    classes = [owner for _, owner in inspect.getmembers(module, inspect.isclass)]
    for owner in (module, *classes):
        for member in vars(owner).values():
            function = member.fget if isinstance(member, property) else member
            if not isinstance(function, FunctionType) or function.__closure__:
                continue
            if function.__module__ == module_name:
                yield function


def never_again(*_arguments: object, **_named: object) -> None:
    """What a broken function does."""
    raise RuntimeError("injected")


def one_after_another(*calls: Callable[[], None]) -> Callable[[], None]:
    """One call for several."""

    def call_all() -> None:
        for call in calls:
            call()

    return call_all


@pytest.mark.parametrize("way", PLANS)
@pytest.mark.parametrize("module_name", MODULES)
def test_rtl_is_commanded_when_a_function_of_our_own_is_broken(
    module_name: str, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the request to arm on, and for ever: it may be one that commands RTL as a rule."""
    for function in functions_of(module_name):
        vehicle = FakeVehicle(FakeClock(), points=POINTS)
        with monkeypatch.context() as patch, suppress(RuntimeError):
            breaks = partial(patch.setattr, function, "__code__", never_again.__code__)
            patch.setattr(vehicle, "request_arm", one_after_another(vehicle.request_arm, breaks))
            fly(vehicle, vehicle.clock, PLANS[way])
        assert_sent_home(vehicle, function)
