"""How targets brake for a vehicle that gets no more of them, and how fast one with much drag can follow."""
