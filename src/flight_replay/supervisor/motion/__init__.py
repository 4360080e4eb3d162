"""How targets brake for a vehicle that gets no more of them."""
