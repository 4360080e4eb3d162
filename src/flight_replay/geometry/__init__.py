"""Positions, distances and lines, on the Earth and in a plane: arrays in, arrays out."""
