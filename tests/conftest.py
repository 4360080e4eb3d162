"""The state of the process that tests start from, whatever started them."""

import signal

from hypothesis import HealthCheck, settings

# The same examples in every run, and no limit of wall-clock time that a busy machine would exceed.
settings.register_profile(
    "repeatable", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)


def pytest_configure() -> None:
    """Signals work: in the background of a shell or under nohup, tests and programs would ignore them."""
    settings.load_profile("repeatable")
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
