"""Who may read the live map: requests to a loopback name that know the token in the address.

A page of another site can make a browser connect to loopback, also under a name of its own (DNS
rebinding). Its requests then have that name in their Host header, and not the token. Other users of this
machine can connect too, so that connections, messages and pages are bounded.
"""

from __future__ import annotations

import hmac
from typing import Any

from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.iostream import IOStream
from tornado.web import ErrorHandler

_NAMES = ("127.0.0.1", "localhost", "[::1]")
_MAX_CONNECTIONS = 64
_MAX_SESSIONS = 20
"""Open pages; one that was closed counts for half a minute."""
_MAX_MESSAGE_BYTES = 1 << 20
_MAX_BODY_BYTES = 1 << 16
_HEADER_TIMEOUT_S = 30.0
_BODY_TIMEOUT_S = 10.0
_FORBIDDEN, _BUSY = 403, 503


def loopback_hosts(port: int) -> list[str]:
    """The Host headers of requests to this machine by a name that nobody else can own."""
    return [f"{name}:{port}" for name in _NAMES]


class GuardedTornado(BokehTornado):
    """Bokeh's web application, below the path ``/TOKEN/``; anything else is forbidden."""

    def __init__(self, applications: Any, token: str, port: int) -> None:
        self._token = token.encode()
        self._hosts = frozenset(loopback_hosts(port))
        super().__init__(
            applications,
            prefix=token,
            extra_websocket_origins=loopback_hosts(port),
            websocket_max_message_size_bytes=_MAX_MESSAGE_BYTES,
        )

    def find_handler(self, request: HTTPServerRequest, **kwargs: Any) -> Any:
        """The handler of a request, or one that refuses it; websockets begin as requests too."""
        refusal = self._refusal(request)
        if refusal is not None:
            return self.get_handler_delegate(request, ErrorHandler, {"status_code": refusal})
        return super().find_handler(request, **kwargs)

    def _refusal(self, request: HTTPServerRequest) -> int | None:
        """The status with which to refuse a request; None if it is served."""
        _, *parts = request.path.split("/")
        known = hmac.compare_digest(parts[0].encode() if parts else b"", self._token)
        if not known or request.headers.get("Host", "").lower() not in self._hosts:
            return _FORBIDDEN
        is_page = parts[1:] in ([], [""])
        return _BUSY if is_page and len(self.get_sessions("/")) >= _MAX_SESSIONS else None


class BoundedServer(HTTPServer):
    """A web server that closes connections beyond a number."""

    def handle_stream(self, stream: IOStream, address: tuple[Any, ...]) -> None:
        """Serve a new connection, or close it."""
        if len(self._connections) >= _MAX_CONNECTIONS:
            stream.close()
            return
        super().handle_stream(stream, address)

    def drop_connections(self) -> None:
        """Close those that are open, whatever is being received or sent."""
        for connection in list(self._connections):
            connection.stream.close()


def bounded_server(application: GuardedTornado) -> BoundedServer:
    """A web server that closes connections beyond a number, and those that stay silent."""
    return BoundedServer(
        application,
        max_body_size=_MAX_BODY_BYTES,
        max_buffer_size=2 * _MAX_MESSAGE_BYTES,
        idle_connection_timeout=_HEADER_TIMEOUT_S,
        body_timeout=_BODY_TIMEOUT_S,
    )
