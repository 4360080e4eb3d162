"""``--heading recorded``: CONDITION_YAW and DO_SET_ROI items that turn the vehicle as the recorded one was.

``headings.py`` adds them to a finished route, whichever way it was planned; ``legs.py`` has what is wanted
on each leg of its predicted flight, ``turns.py`` how the vehicle answers, ``turn_choice.py`` chooses.
"""

from flight_replay.planning.heading.headings import with_recorded_headings

__all__ = ["with_recorded_headings"]
