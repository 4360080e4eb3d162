"""What will be flown, as data, and the files that other programs read it from."""
