"""Equations and inequalities with a structure that makes them quick to solve."""
