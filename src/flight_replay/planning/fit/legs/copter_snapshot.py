"""Copies of a copter in flight, as many as are wanted, each a tenth of what ``copy.deepcopy`` takes."""

from __future__ import annotations

import io
import pickle
from collections.abc import Sequence
from typing import Any

from flight_replay.simulator.flight.copter import Copter


class CopterSnapshot:
    """A copter in AUTO as it was; what is ``shared`` is not copied, which must not be of a built-in type."""

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


def _shared_at(index: int) -> object:
    """Stands in a pickle for what is shared."""
    raise NotImplementedError("a snapshot is read by its copy()")


class _Pickler(pickle.Pickler):
    # Unlike persistent_id, this is not called for numbers, of which a copter mostly consists.

    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._index = {id(each): i for i, each in enumerate(shared)}

    def reducer_override(self, obj: Any) -> Any:
        index = self._index.get(id(obj))
        return NotImplemented if index is None else (_shared_at, (index,))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file)
        self._shared = shared

    def find_class(self, module: str, name: str) -> Any:
        return self._shared.__getitem__ if name == _shared_at.__name__ else super().find_class(module, name)
