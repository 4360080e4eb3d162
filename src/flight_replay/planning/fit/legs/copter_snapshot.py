"""Copies of a copter in flight, as many as are wanted, each a tenth of what ``copy.deepcopy`` takes."""

from __future__ import annotations

import io
import pickle
from collections.abc import Sequence
from typing import Any

from flight_replay.simulator.flight.copter import Copter


class CopterSnapshot:
    """A copter in AUTO as it was; what is ``shared`` is not copied."""

    def __init__(self, copter: Copter, shared: Sequence[object]) -> None:
        run = copter.mission
        assert run is not None, "a draft is flown in AUTO"
        self._shared = shared
        # What was reached so far would be half of what is written and read.
        self._reached, run.reached = run.reached, []
        file = io.BytesIO()
        _Pickler(file, shared).dump(copter)
        self._bytes = file.getvalue()
        run.reached = self._reached.copy()

    def copy(self, shared: Sequence[object] | None = None) -> Copter:
        """A copter in the same state, which flies on by itself, with other shared things if given."""
        copied: Copter = _Unpickler(io.BytesIO(self._bytes), shared or self._shared).load()
        run = copied.mission
        assert run is not None, "a draft is flown in AUTO"
        run.reached = self._reached.copy()
        return copied


class _Pickler(pickle.Pickler):
    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._index = {id(each): i for i, each in enumerate(shared)}

    def persistent_id(self, obj: Any) -> int | None:
        return self._index.get(id(obj))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, pid: Any) -> object:
        return self._shared[pid]
