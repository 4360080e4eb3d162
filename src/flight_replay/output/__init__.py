"""What people and programs get: console lines, a live display, a live map, charts, a report, JSON."""
