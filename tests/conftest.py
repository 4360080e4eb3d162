"""The state of the process that tests start from, whatever started them."""

import signal


def pytest_configure() -> None:
    """Signals work: in the background of a shell or under nohup, tests and programs would ignore them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
