"""Legs changed one by one, each change judged by the model over the legs around it."""
