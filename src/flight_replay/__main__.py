"""``python -m flight_replay``, and the console script."""

import gc
import os
import sys


def _open_closed_streams() -> None:
    """Give a program that was started without stdin, stdout or stderr (``>&-``) ones that lead nowhere.

    Otherwise the next file or socket that is opened would be taken for them.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115, PTH123 - for all that is left


def main() -> int:
    """Run the command line; returns the exit status."""
    _open_closed_streams()
    try:
        return _started()
    except KeyboardInterrupt:
        # Sooner than the command line takes signals: nothing was begun that must be ended.
        from flight_replay import signals

        sys.stderr.write("flight-replay: error: interrupted\n")
        return signals.INTERRUPTED_STATUS


def _started() -> int:
    """Import the command line, which takes longer than most of what it does, and run it."""
    # numpy's linear algebra starts a thread per core when it is imported, which takes longer than
    # all the reading and planning of a log; nothing here is large enough to need them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Imports make much that lasts: looking for garbage in it, now and on leaving, takes a tenth of a dry run.
    gc.disable()
    from flight_replay import signals
    from flight_replay.cli import main

    gc.freeze()
    gc.enable()
    status = main.main()
    if status == signals.INTERRUPTED_STATUS:
        # A second Ctrl-C while Python takes itself down would change the exit status.
        import signal

        for number in signals.TERMINATION_SIGNALS:
            signal.signal(number, signal.SIG_IGN)
    return status


if __name__ == "__main__":
    sys.exit(main())
