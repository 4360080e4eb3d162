"""``python -m flight_replay``, and the console script."""

import os
import sys


def main() -> int:
    """Run the command line; returns the exit status."""
    # numpy's linear algebra starts a thread per core when it is imported, which takes longer than
    # all the reading and planning of a log; nothing here is large enough to need them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from flight_replay import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
