"""Recordings followed in step: the motion that targets are taken from, and what to expect of it."""
