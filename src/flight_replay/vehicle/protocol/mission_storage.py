"""The mission on board: uploaded, downloaded, compared."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import dialect
from flight_replay.mission.items import Home, Mission, MissionItem
from flight_replay.vehicle.link.vehicle_link import VehicleLink
from flight_replay.vehicle.protocol.mission_download import MissionDownloader
from flight_replay.vehicle.protocol.mission_items import difference
from flight_replay.vehicle.protocol.mission_upload import MissionUploader
from flight_replay.writing.counted import counted

_ATTEMPTS = 3
_UNKNOWN_HOME = Home(0.0, 0.0, 0.0)
NOT_REPLACED = "its mission is not replaced"
_INCOMPLETE = "its mission may be incomplete"
_REPLACED = "its mission was replaced meanwhile, but not set to its beginning"


class MissionStorage:
    """The vehicle's mission storage; home, its item 0, is not among the items of a ``Mission``.

    ``refuse_armed`` is called before what may send an armed vehicle off at once, with what has become of its
    mission by then, and raises if it is armed.
    """

    def __init__(
        self,
        link: VehicleLink,
        *,
        as_int: bool,
        refuse_armed: Callable[[str], None] = lambda consequence: None,
    ) -> None:
        self._link, self._as_int = link, as_int
        self._refuse_armed, self._consequence = refuse_armed, NOT_REPLACED
        self._uploaded: tuple[MissionItem, ...] | None = None

    def download(self, while_waiting: Callable[[], None] = lambda: None) -> Mission:
        """The mission on board; ``while_waiting`` is called repeatedly.

        Raises:
            VehicleError: The vehicle does not send it.
        """
        items = MissionDownloader(self._link, as_int=self._as_int, while_waiting=while_waiting).run()
        if not items:
            return Mission(())
        home = Home(items[0].lat_deg, items[0].lon_deg, items[0].alt_m)
        return Mission(tuple(items[1:]), home if home != _UNKNOWN_HOME else None)

    def upload(self, mission: Mission, progress: Callable[[int], None]) -> None:
        """Upload a mission, download it and compare; ``progress`` gets the number of items on board.

        Raises:
            MissionError: The vehicle refuses it.
            VehicleError: It is armed, the link fails, or the mission on board differs from the one sent.
        """
        items = (mission.home_item, *mission.items)
        self._uploaded, self._consequence = None, NOT_REPLACED
        unlike: str | None = None
        for _ in range(_ATTEMPTS):
            uploader = MissionUploader(
                self._link, items, as_int=self._as_int, before_count=self._before_count
            )
            uploader.run(lambda taken: progress(max(0, min(taken, len(items)) - 1)))
            unlike = _first_difference(mission.items, self.download().items, as_int=self._as_int)
            if unlike is None:
                self._uploaded = mission.items
                self._restart_mission()
                return
        raise VehicleError(
            f"the mission on board differs from the one sent: {unlike}; try again over a better link"
        )

    def verified(self, while_waiting: Callable[[], None] = lambda: None) -> bool:
        """Whether the mission on board is still the one uploaded; ``while_waiting`` is called repeatedly."""
        if self._uploaded is None:
            return False
        return (
            _first_difference(self._uploaded, self.download(while_waiting).items, as_int=self._as_int) is None
        )

    def _before_count(self) -> None:
        """Refuse an armed vehicle: the first count drops its old mission, a later one part of the new one."""
        self._refuse_armed(self._consequence)
        self._consequence = _INCOMPLETE

    def _restart_mission(self) -> None:
        """Set the current item to the first one, wherever a mission before this one was left."""
        self._refuse_armed(_REPLACED)
        link = self._link
        link.send(dialect.MAVLink_mission_set_current_message(link.system, link.component, 0))


def _first_difference(
    sent: Sequence[MissionItem], found: Sequence[MissionItem], *, as_int: bool
) -> str | None:
    if len(sent) != len(found):
        return f"{counted(len(found), 'item')} instead of {len(sent)}"
    for seq, (ours, theirs) in enumerate(zip(sent, found, strict=True), 1):
        unlike = difference(ours, theirs, as_int=as_int)
        if unlike:
            return f"item {seq} has {unlike}"
    return None
