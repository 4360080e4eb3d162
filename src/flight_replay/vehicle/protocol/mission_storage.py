"""The mission on board: put there, read back, compared, saved."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flight_replay.errors import VehicleError
from flight_replay.mavlink import dialect
from flight_replay.mission.items import Home, Mission, MissionItem
from flight_replay.vehicle.link.port import Port
from flight_replay.vehicle.protocol.mission_download import Reader
from flight_replay.vehicle.protocol.mission_items import difference, home_item
from flight_replay.vehicle.protocol.mission_upload import Upload, UploadLimits

_ATTEMPTS = 3
_NOWHERE = Home(0.0, 0.0, 0.0)


class OnBoard:
    """The vehicle's mission storage; home, its item 0, is not part of a mission here."""

    def __init__(self, port: Port, *, as_int: bool, limits: UploadLimits | None = None) -> None:
        self._port, self._as_int, self._limits = port, as_int, limits
        self._sent: tuple[MissionItem, ...] | None = None

    def read(self, while_waiting: Callable[[], None] = lambda: None) -> Mission:
        """What is on board now; ``while_waiting`` is called now and then.

        Raises:
            VehicleError: The vehicle does not tell.
        """
        items = Reader(self._port, as_int=self._as_int, while_waiting=while_waiting).read()
        if not items:
            return Mission(())
        home = Home(items[0].lat_deg, items[0].lon_deg, items[0].alt_m)
        return Mission(tuple(items[1:]), home if home != _NOWHERE else None)

    def put(self, mission: Mission, progress: Callable[[int], None]) -> None:
        """Send a mission, read it back and compare; ``progress`` hears how many items are there.

        Raises:
            MissionError: The vehicle refuses it.
            VehicleError: The link fails, or what is on board is not what was sent.
        """
        items = (home_item(mission.home or _NOWHERE), *mission.items)
        self._sent = None
        unlike: str | None = None
        for _ in range(_ATTEMPTS):
            upload = Upload(self._port, items, as_int=self._as_int, limits=self._limits)
            upload.run(lambda taken: progress(max(0, min(taken, len(items)) - 1)))
            unlike = _first_difference(mission.items, self.read().items, as_int=self._as_int)
            if unlike is None:
                self._sent = mission.items
                self._rewind()
                return
        raise VehicleError(f"the mission on board is not the one sent: {unlike}; try again on a better link")

    def verified(self, while_waiting: Callable[[], None] = lambda: None) -> bool:
        """Whether what is on board still is what was put there; ``while_waiting`` is called now and then."""
        if self._sent is None:
            return False
        return _first_difference(self._sent, self.read(while_waiting).items, as_int=self._as_int) is None

    def _rewind(self) -> None:
        """Start at the first item, wherever a mission before this one was left; told by MISSION_CURRENT."""
        port = self._port
        port.send(dialect.MAVLink_mission_set_current_message(port.system, port.component, 0))


def _first_difference(
    sent: Sequence[MissionItem], found: Sequence[MissionItem], *, as_int: bool
) -> str | None:
    if len(sent) != len(found):
        return f"{len(found)} items instead of {len(sent)}"
    for seq, (ours, theirs) in enumerate(zip(sent, found, strict=True), 1):
        unlike = difference(ours, theirs, as_int=as_int)
        if unlike:
            return f"item {seq} has {unlike}"
    return None
