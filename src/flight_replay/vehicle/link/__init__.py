"""Bytes and frames: transports, the link's thread, who is on it."""
