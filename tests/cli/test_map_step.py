"""map_step.py: the live map is there while the flight lasts."""

import io
import queue
import sys
import threading
import webbrowser
from collections.abc import Callable
from types import SimpleNamespace
from urllib.request import urlopen

import pytest

from flight_replay.cli.map_step import with_live_map
from flight_replay.cli.options import parse_options
from flight_replay.events import Event, Notice
from flight_replay.output.console.console import PlainConsole
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import made_following
from tests.helpers.made_tracks import straight_track


def test_without_map_the_listener_is_unchanged() -> None:
    """No server is started."""
    listener = list[Event]().append
    console = PlainConsole(io.StringIO())
    with with_live_map(parse_options([]), spaced_route(straight_track()), console, listener) as combined:
        assert combined is listener


def test_the_map_is_served_and_opened_in_a_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its address is printed; a browser opens where there is a screen."""
    opened: queue.SimpleQueue[str] = queue.SimpleQueue()
    at_a_screen(monkeypatch, opened.put)
    received: list[Event] = []
    route, console = spaced_route(straight_track()), PlainConsole(io.StringIO())
    with with_live_map(parse_options(["--map"]), route, console, received.append) as listener:
        listener(Notice("hello"))
        url = opened.get(timeout=60)
        with urlopen(url, timeout=10) as page:
            assert page.status == 200
    assert received == [Notice(f"Live map: {url}", asked_for=True), Notice("hello")]


def at_a_screen(monkeypatch: pytest.MonkeyPatch, browser: Callable[[str], object]) -> None:
    """Standard output is a terminal with a screen, and this the browser."""
    monkeypatch.setattr(webbrowser, "open", browser)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)


def test_nothing_waits_for_a_browser_that_does_not_return(monkeypatch: pytest.MonkeyPatch) -> None:
    """Such as the command in BROWSER; the flight goes on."""
    closed, ended = threading.Event(), threading.Event()

    def browse(url: str) -> None:
        closed.wait(60)
        ended.set()

    at_a_screen(monkeypatch, browse)
    route, console = spaced_route(straight_track()), PlainConsole(io.StringIO())
    with with_live_map(parse_options(["--map"]), route, console, list[Event]().append):
        assert not ended.is_set()
        closed.set()
        assert ended.wait(60)


def test_a_browser_that_fails_does_not_end_the_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its page has an address, which is shown."""
    failed = threading.Event()

    def browse(url: str) -> None:
        failed.set()
        raise webbrowser.Error("could not locate runnable browser")

    at_a_screen(monkeypatch, browse)
    route, console = spaced_route(straight_track()), PlainConsole(io.StringIO())
    with with_live_map(parse_options(["--map"]), route, console, list[Event]().append):
        assert failed.wait(60)


def test_a_recording_that_is_followed_has_a_map() -> None:
    """Without waypoints."""
    route, console = made_following()[0], PlainConsole(io.StringIO())
    received: list[Event] = []
    with with_live_map(parse_options(["--map", "--mode", "guided"]), route, console, received.append):
        (notice,) = received
        assert isinstance(notice, Notice)
        with urlopen(notice.text.removeprefix("Live map: "), timeout=10) as page:
            assert page.status == 200


def test_the_map_of_a_plan_is_served_until_enter(monkeypatch: pytest.MonkeyPatch) -> None:
    """--dry-run --map: nothing flies, so the page would be gone at once."""
    typed = io.StringIO("\n")
    monkeypatch.setattr(sys, "stdin", typed)
    route, console = spaced_route(straight_track()), PlainConsole(io.StringIO())
    with with_live_map(parse_options(["--map", "--dry-run"]), route, console, list[Event]().append):
        assert typed.tell() == 0
    assert typed.tell() == 1


def test_what_follows_an_input_that_ends_has_a_line_of_its_own(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As from /dev/null: nobody has typed Enter behind the question."""
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    route, console = spaced_route(straight_track()), PlainConsole(io.StringIO())
    with with_live_map(parse_options(["--map", "--dry-run"]), route, console, list[Event]().append):
        pass
    assert capsys.readouterr().err == "The plan is on the map. Press Enter to close it: \n"


def test_the_map_of_a_plan_of_the_input_is_served_until_ctrl_c(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The log came from there, so that there is no Enter to wait for."""
    waited: list[float] = []

    def wait(seconds: float) -> None:
        waited.append(seconds)
        if len(waited) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr("flight_replay.cli.map_step.time", SimpleNamespace(sleep=wait))
    monkeypatch.setattr(sys, "stdin", None)
    route, console = spaced_route(straight_track()), PlainConsole(io.StringIO())
    with with_live_map(parse_options(["-", "--map", "--dry-run"]), route, console, list[Event]().append):
        assert not waited
    assert len(waited) == 3
    assert capsys.readouterr().err == "The plan is on the map. Ctrl-C closes it.\n"
