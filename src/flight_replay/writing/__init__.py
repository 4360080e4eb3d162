"""Files that are written whole, and writes that never hold up a flight."""
