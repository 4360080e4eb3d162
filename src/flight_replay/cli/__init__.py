"""The command line: each step of a replay is one module."""
