"""How a program is asked to end, and what it says by its exit status when it did."""

from __future__ import annotations

import signal

INTERRUPTED = 130
"""Exit status after Ctrl-C, SIGTERM or a terminal that was closed."""
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Those that the system has of the signals that ask a program to end."""
