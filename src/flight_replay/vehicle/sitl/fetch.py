"""Downloads a file over the network: in time, of bounded size, and never from https to http."""

from __future__ import annotations

import hashlib
import http.client
import queue
import socket
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path
from typing import Any

from flight_replay.events import Listener, Progress
from flight_replay.vehicle.link.host_lookup import look_up

_CHUNK = 1 << 16
_LARGEST_BYTES = 1 << 26
"""64 MB; dronekit-sitl's archives have less than 10."""

_Answer = http.client.HTTPResponse


class _RedirectsToHttps(urllib.request.HTTPRedirectHandler):
    """Follows redirects to https only: who can change an answer on its way could name any file."""

    def redirect_request(self, *details: Any) -> urllib.request.Request | None:
        """The request to follow; ``details`` are those of the base class, with the new address last."""
        if urllib.parse.urlsplit(details[-1]).scheme != "https":
            details[1].close()  # The answer that redirects.
            raise OSError(f"refused the redirect to {details[-1]}, which is not https")
        return super().redirect_request(*details)


def fetch(url: str, path: Path, listener: Listener, *, limit_s: float, silence_s: float) -> str:
    """Download an address to a file, completely and in time; returns its SHA-256 in hexadecimal.

    Args:
        url: http or https; redirects are followed to https only.
        path: The file to write.
        listener: Gets the progress.
        limit_s: Longest time for all of it.
        silence_s: Longest time without a byte.

    Raises:
        OSError: The server refuses, is silent or too slow, or the file is too large.
        HTTPException: The server does not speak HTTP.
    """
    end_s = time.monotonic() + limit_s
    _resolve(url, silence_s)
    hashed = hashlib.sha256()
    with _answer_in_time(url, limit_s, silence_s) as answer, path.open("wb") as file:
        total = int(answer.headers.get("Content-Length") or 0)
        _check_size(total)
        done = 0
        # read1, because read waits for a whole chunk, however slow the server is.
        while chunk := answer.read1(_CHUNK):
            hashed.update(chunk)
            done += file.write(chunk)
            if time.monotonic() > end_s:
                raise TimeoutError("the download takes too long")
            _check_size(done)
            listener(Progress("ArduPilot SITL", done, total, "bytes"))
    if total and done != total:
        raise OSError(f"the download ended after {done} of {total} bytes")
    return hashed.hexdigest()


def _check_size(size: int) -> None:
    if size > _LARGEST_BYTES:
        raise OSError("the file is too large to be a simulator")


def _answer_in_time(url: str, limit_s: float, silence_s: float) -> _Answer:
    """The open answer of a server, whose headers may arrive byte by byte: no timeout of a socket ends that.

    A server that is too slow is left to a thread, which ends with the program at the latest.
    """
    answers: queue.SimpleQueue[_Answer | Exception] = queue.SimpleQueue()

    def ask() -> None:
        try:
            answers.put(_answer(url, silence_s))
        except Exception as error:
            answers.put(error)

    threading.Thread(target=ask, name="flight-replay download", daemon=True).start()
    try:
        answer = answers.get(timeout=limit_s)
    except queue.Empty:
        raise TimeoutError("the download takes too long") from None
    if isinstance(answer, Exception):
        raise answer
    return answer


def _answer(url: str, silence_s: float) -> _Answer:
    """The open answer of a server.

    Raises:
        HTTPError: The server refuses; its answer is closed, which the error would leave open.
    """
    opener = urllib.request.build_opener(_RedirectsToHttps)
    try:
        answer: _Answer = opener.open(url, timeout=silence_s)
    except urllib.error.HTTPError as error:
        error.close()
        raise
    return answer


def _resolve(url: str, limit_s: float) -> None:
    """Check in time that the host name resolves; a proxy resolves it itself."""
    parts = urllib.parse.urlsplit(url)
    if parts.scheme in urllib.request.getproxies():
        return
    try:
        look_up(parts.hostname or "", parts.port or parts.scheme, limit_s)
    except socket.gaierror as error:
        raise OSError(f"unknown host name {parts.hostname}") from error
