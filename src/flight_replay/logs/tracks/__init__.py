"""Tracks that other programs wrote: GPX, KML, KMZ, GeoJSON and CSV."""
