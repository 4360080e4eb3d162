"""The battery: what the motors draw, what is left, and ArduPilot's two failsafe levels.

Voltage is SIM_BATT_VOLTAGE throughout, as in ArduPilot's SITL with SIM_BATT_CAP_AH 0; with a
capacity given it falls with the charge. The current is what ArduCopter 4.6 SITL reports: 28.1 A in
hover, 1.0 A more for each m/s of climb.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

_HOVER_A = 28.1
_CLIMB_A_PER_M_S = 1.0
_IDLE_A = 0.5
_S_PER_H = 3600.0
_EMPTY_VOLTAGE_SHARE = 0.75


class BatteryFailsafe(IntEnum):
    """Which battery failsafe is active."""

    NONE = 0
    LOW = 1
    CRITICAL = 2


@dataclass(slots=True)
class Battery:
    """Charge and draw; ``parameters`` is the autopilot's table, read at every use."""

    parameters: Mapping[str, float]
    current_a: float = 0.0
    consumed_mah: float = 0.0
    consumed_wh: float = 0.0
    failsafe: BatteryFailsafe = BatteryFailsafe.NONE
    _below_since_s: tuple[float | None, float | None] = (None, None)

    def draw(self, seconds: float, *, armed: bool, landed: bool, climb_m_s: float) -> None:
        """Draw the motors' current for so many seconds of vehicle time."""
        flying_a = _HOVER_A + _CLIMB_A_PER_M_S * max(climb_m_s, -5.0)
        self.current_a = 0.0 if not armed else _IDLE_A if landed else flying_a
        self.consumed_mah += self.current_a * 1000 * seconds / _S_PER_H
        self.consumed_wh += self.current_a * self.voltage_v * seconds / _S_PER_H

    @property
    def voltage_v(self) -> float:
        """Volts at the terminals."""
        full_v, capacity_ah = self.parameters["SIM_BATT_VOLTAGE"], self.parameters["SIM_BATT_CAP_AH"]
        if capacity_ah <= 0:
            return full_v
        used = min(self.consumed_mah / 1000 / capacity_ah, 1.0)
        return full_v * (1 - used * (1 - _EMPTY_VOLTAGE_SHARE))

    @property
    def remaining_mah(self) -> float:
        """What is left of BATT_CAPACITY."""
        return self.parameters["BATT_CAPACITY"] - self.consumed_mah

    @property
    def remaining_percent(self) -> int:
        """The same in whole percent, 0 to 100."""
        capacity = self.parameters["BATT_CAPACITY"]
        return max(0, min(100, int(100 * self.remaining_mah / capacity))) if capacity > 0 else 0

    def _is_below(self, prefix: str) -> tuple[bool, bool]:
        """Whether voltage and charge are below the limits of BATT_LOW or BATT_CRT."""
        volts, mah = self.parameters[f"{prefix}_VOLT"], self.parameters[f"{prefix}_MAH"]
        return 0 < self.voltage_v < volts, mah > 0 and self.remaining_mah < mah

    def arming_problem(self) -> str:
        """The battery check that fails, or nothing (AP_BattMonitor_Backend::arming_checks)."""
        low_volt, low_mah = self._is_below("BATT_LOW")
        critical_volt, critical_mah = self._is_below("BATT_CRT")
        failed = {
            "below minimum arming voltage": 0 < self.voltage_v < self.parameters["BATT_ARM_VOLT"],
            "below minimum arming capacity": 0 < self.parameters["BATT_ARM_MAH"] > self.remaining_mah,
            "low voltage failsafe": low_volt,
            "low capacity failsafe": low_mah,
            "critical voltage failsafe": critical_volt,
            "critical capacity failsafe": critical_mah,
        }
        return next((text for text, has_failed in failed.items() if has_failed), "")

    def failsafe_triggered(self, time_s: float) -> bool:
        """Whether a worse failsafe has just been triggered; voltages count after BATT_LOW_TIMER seconds."""
        low_volt, low_mah = self._is_below("BATT_LOW")
        critical_volt, critical_mah = self._is_below("BATT_CRT")
        low_s, critical_s = self._below_since_s
        low_s = (low_s if low_s is not None else time_s) if low_volt else None
        critical_s = (critical_s if critical_s is not None else time_s) if critical_volt else None
        self._below_since_s = (low_s, critical_s)
        timer_s = self.parameters["BATT_LOW_TIMER"]
        found = BatteryFailsafe.NONE
        if low_mah or (timer_s > 0 and low_s is not None and time_s - low_s > timer_s):
            found = BatteryFailsafe.LOW
        if critical_mah or (timer_s > 0 and critical_s is not None and time_s - critical_s > timer_s):
            found = BatteryFailsafe.CRITICAL
        if found <= self.failsafe:
            return False
        self.failsafe = found
        return True
