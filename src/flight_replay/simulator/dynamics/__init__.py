"""Limits, airframe, controllers: one step of physics and control."""
