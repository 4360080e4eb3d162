"""ArduPilot's AC_WPNav: S-curves, splines, and how legs join."""
