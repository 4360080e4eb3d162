"""Tests of the recorded headings."""
