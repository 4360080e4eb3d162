"""Places, distances and lines, on the Earth and in a plane; numpy only."""
