"""The state of the process that tests start from, whatever started them."""

import signal
from importlib import import_module

import pytest
from hypothesis import HealthCheck, settings

# The same examples in every run, and no limit of wall-clock time that a busy machine would exceed.
settings.register_profile(
    "repeatable", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)


def pytest_configure() -> None:
    """Signals work: in the background of a shell or under nohup, tests and programs would ignore them."""
    settings.load_profile("repeatable")
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in ("SIGHUP", "SIGQUIT", "SIGTSTP", "SIGTTOU"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)


@pytest.fixture
def brief_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits end after a quarter of their search: for tests of all but how much the rest of it gains."""
    monkeypatch.setattr(import_module("flight_replay.planning.fit.fit"), "_MOST_FLIGHTS", 40)
