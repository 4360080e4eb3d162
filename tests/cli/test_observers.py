"""Everybody who watches hears everything, and none of them can end a flight."""

import io
import logging
import sys
import webbrowser
from urllib.request import urlopen

import pytest

from flight_replay.cli.observers import mapped
from flight_replay.cli.options import parse
from flight_replay.events import Event, Finished, Notice, combine_listeners
from flight_replay.output.console.console import PlainConsole
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_tracks import dash


def test_one_watcher_that_fails_does_not_keep_the_others_from_hearing(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A failing listener is logged; the rest go on."""
    heard: list[Event] = []

    def broken(event: Event) -> None:
        raise RuntimeError("no screen")

    with caplog.at_level(logging.ERROR):
        combine_listeners(broken, heard.append)(Finished("duration"))
    assert heard == [Finished("duration")]
    assert "a listener failed" in caplog.text


def test_without_a_map_the_listener_is_the_same() -> None:
    """Nobody pays for a map that was not asked for."""
    heard: list[Event] = []
    listener = heard.append
    with mapped(parse([]), spaced_route(dash()), PlainConsole(io.StringIO()), listener) as watching:
        assert watching is listener


def test_a_map_is_served_and_its_place_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page is there while the flight lasts; a browser opens only where a person has a screen."""
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    heard: list[Event] = []
    with mapped(parse(["--map"]), spaced_route(dash()), PlainConsole(io.StringIO()), heard.append) as tell:
        tell(Notice("hello"))
        url = opened[0]
        with urlopen(url, timeout=10) as page:
            assert page.status == 200
    assert heard[0] == Notice(f"The map is at {url}")
    assert heard[1] == Notice("hello")
