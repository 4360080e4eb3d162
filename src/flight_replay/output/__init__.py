"""What people and programs get: lines, a live display, a map, pictures, a report, JSON."""
