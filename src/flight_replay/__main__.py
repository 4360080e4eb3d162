"""``python -m flight_replay``, and the console script."""

import gc
import os
import sys

from flight_replay import signals


def _open_closed_streams() -> None:
    """Open stdin, stdout and stderr on the null device where the program was started without (``>&-``).

    Otherwise the next file or socket to be opened would get their descriptors.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115, PTH123 - open until exit


def main() -> int:
    """Run the command line; returns the exit status."""
    signals.exit_at_once("flight-replay: error: interrupted\n")
    _open_closed_streams()
    return _import_and_run()


def _import_and_run() -> int:
    """Import the command line, which takes longer than most of what it does, and run it."""
    # numpy's linear algebra starts a thread per core on import, which takes longer than reading and
    # planning a log, and nothing here is large enough to need them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Collecting garbage among the imported modules, now and on exit, takes a tenth of a dry run.
    gc.disable()
    from flight_replay import signals
    from flight_replay.cli import main
    from flight_replay.output.console import terminal

    gc.freeze()
    gc.enable()
    status = main.main()
    signals.ignore()
    if status == signals.INTERRUPTED_STATUS or _thread_is_stuck():
        # Flushing a stream that another thread is stuck in would wait for ever.
        os._exit(status)
    # Python would change the exit status if standard error is full.
    terminal.flush_or_discard(sys.stderr)
    return status


def _thread_is_stuck() -> bool:
    """Whether a thread of ours did not end: it waits for a terminal, a pipe or a disk."""
    import threading

    return any(thread.name.startswith("flight-replay") for thread in threading.enumerate())


if __name__ == "__main__":
    sys.exit(main())
