"""The autopilot: modes, arming, failsafes, home, parameters; no sockets, and no clock but the vehicle's."""
