"""What each Dask worker on this machine loads before it works: Ctrl-C at the terminal is not for it.

The program that started it ends it, and keeps what it has done.
"""

import signal

signal.signal(signal.SIGINT, signal.SIG_IGN)
