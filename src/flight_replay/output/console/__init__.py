"""Plain lines, or a live display on a terminal."""
