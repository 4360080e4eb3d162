"""The drafts that differ from one in how a place is flown to: straight or curved, with a stop."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.planning.fit.draft import Draft

STOP_S = 1.0


def kind_changes(
    draft: Draft, place: int, hovers: Collection[int], *, straight_starts: bool
) -> Iterator[Draft]:
    """The drafts that differ in how a place is flown to, and whether it is stopped at, each by itself."""
    after_stop = straight_starts and draft.hold_s[place - 1] > 0
    if place in hovers:
        return
    if place == len(draft) - 1:
        if not after_stop:
            yield _flipped(draft, place)
        return
    if draft.hold_s[place] > 0:
        yield _through(draft, place, spline=not after_stop)
        return
    if not after_stop:
        yield _flipped(draft, place)
    yield _stopped(draft, place, straight_start=straight_starts)
    if draft.spline[place + 1]:
        yield _flipped(_flipped(draft, place) if draft.spline[place] else draft, place + 1)


def corner_changes(draft: Draft, place: int, hovers: Collection[int], fixes_m: Floats) -> Iterator[Draft]:
    """The drafts that go straight to where the recording turns, and on from there straight or as before.

    Args:
        draft: whose place is changed.
        place: flown through, not the last.
        hovers: the places that are waited at.
        fixes_m: the fixes (n, 2) passed on the way to the place, and from there to the next.
    """
    if place == len(draft) - 1 or place in hovers or not len(fixes_m):
        return
    before_m, after_m = draft.places_m[place - 1, :2], draft.places_m[place + 1, :2]
    _, apart_m = nearest_on_segments(fixes_m, before_m, after_m - before_m)
    places = draft.places_m.copy()
    places[place, :2] = fixes_m[apart_m.argmax()]
    for end in (place + 2, place + 1):
        spline = draft.spline.copy()
        spline[place:end] = False
        yield replace(draft, places_m=places, spline=spline)


def _flipped(draft: Draft, place: int) -> Draft:
    spline = draft.spline.copy()
    spline[place] = not spline[place]
    return replace(draft, spline=spline)


def _stopped(draft: Draft, place: int, *, straight_start: bool) -> Draft:
    """Straight to a stop, and on from it as before, or straight."""
    spline, hold_s = draft.spline.copy(), draft.hold_s.copy()
    spline[place : place + 1 + straight_start], hold_s[place] = False, STOP_S
    return replace(draft, spline=spline, hold_s=hold_s)


def _through(draft: Draft, place: int, *, spline: bool) -> Draft:
    """Through without a stop, on a curve or straight."""
    is_spline, hold_s = draft.spline.copy(), draft.hold_s.copy()
    is_spline[place], hold_s[place] = spline, 0.0
    return replace(draft, spline=is_spline, hold_s=hold_s)
