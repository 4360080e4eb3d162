"""log_lines.py: log records are lines on a stream, and nobody who logs waits for it."""

from __future__ import annotations

import io
import logging
import threading
import time

from flight_replay.output.console.log_lines import QUEUED_RECORDS, log_lines

_log = logging.getLogger("somebody")


def test_records_of_a_level_are_lines() -> None:
    """Escaped; afterwards logging is as it was."""
    stream, before = io.StringIO(), logging.getLogger().level
    with log_lines(stream, logging.INFO):
        _log.info("says \x1b[31m")
        _log.debug("a detail")
    _log.critical("later")
    assert stream.getvalue() == "INFO:somebody:says \\x1b[31m\n"
    assert logging.getLogger().level == before


def test_a_stream_that_is_stuck_holds_nobody_up() -> None:
    """Neither who logs, in any thread, nor the end; a bounded number of records waits."""
    free, began_s = threading.Event(), time.monotonic()

    class Stuck(io.StringIO):
        def write(self, text: str) -> int:
            free.wait(60)
            return super().write(text)

    stream = Stuck()
    try:
        with log_lines(stream, logging.CRITICAL):
            other = threading.Thread(target=_log.critical, args=("from elsewhere",))
            other.start()
            for number in range(2 * QUEUED_RECORDS):
                _log.critical("number %d", number)
            other.join(10)
            assert not other.is_alive()
        assert time.monotonic() - began_s < 10
    finally:
        free.set()
