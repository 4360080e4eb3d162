"""What each Dask worker on this machine loads before it works: Ctrl-C at the terminal is not for it.

Nor is what else ends a program there (SIGQUIT). The program that started it ends it, and keeps what it has
done.
"""

import signal

signal.signal(signal.SIGINT, signal.SIG_IGN)
if hasattr(signal, "SIGQUIT"):
    signal.signal(signal.SIGQUIT, signal.SIG_IGN)
