"""The state of the process that tests start from, whatever started them."""

import signal


def pytest_configure() -> None:
    """Ctrl-C works: started in the background of a shell, tests and their programs would ignore it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
