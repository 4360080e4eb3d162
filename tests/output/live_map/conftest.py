"""What the tests of the live map share."""

import threading

import pytest

from flight_replay.output.charts import map_tiles


@pytest.fixture
def no_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    """No tile server is asked."""
    monkeypatch.setattr(map_tiles, "probe", threading.Event)
