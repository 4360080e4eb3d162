"""The signals that end a program, and the exit status after one."""

from __future__ import annotations

import signal

INTERRUPTED_STATUS = 130
"""Exit status after Ctrl-C, SIGTERM, or a terminal that was closed."""
TERMINATION_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""The signals that ask a program to end, as far as this system has them."""
