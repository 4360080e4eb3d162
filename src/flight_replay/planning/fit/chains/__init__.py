"""Chains of legs of several drafts: the best of each together."""
