"""The live map of ``--map``: its data, its page and its server."""
