"""What ArduPilot calls mission items in its status texts (AP_Mission::Mission_Command::type)."""

from __future__ import annotations

_NAMES = {
    16: "WP", 17: "LoitUnlim", 18: "LoitTurns", 19: "LoitTime", 20: "RTL", 21: "Land", 22: "Takeoff",
    30: "ContinueAndChangeAlt", 31: "LoitAltitude", 82: "SplineWP", 84: "VTOLTakeoff", 85: "VTOLLand",
    92: "GuidedEnable", 93: "Delay", 94: "PayloadPlace", 112: "CondDelay", 114: "CondDist", 115: "CondYaw",
    177: "Jump", 178: "ChangeSpeed", 179: "SetHome", 181: "SetRelay", 182: "RepeatRelay", 183: "SetServo",
    184: "RepeatServo", 188: "ReturnPathStart", 189: "LandStart", 191: "Go Around", 193: "PauseContinue",
    201: "SetROI", 205: "MountControl", 206: "SetCamTrigDst", 207: "FenceEnable", 208: "Parachute",
    211: "Gripper", 212: "AutoTuneEnable", 213: "SetYawSpd", 216: "Sprayer", 218: "AuxFunction",
    222: "GuidedLimits", 600: "Tag", 601: "JumpToTag", 42600: "Winch",
}  # fmt: skip

REPORTED_AS_REACHED = frozenset({16, 19, 82})
"""Commands that are reported as "Reached command #n"."""


def name_of(command: int) -> str:
    """The name of a command."""
    return _NAMES.get(command, "?")
