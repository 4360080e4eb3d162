"""What a vehicle must not be made to fly, mended after the search: it is rare."""
