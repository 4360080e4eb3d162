"""The live map of ``--map``: server, data and page."""
