"""``flight-replay-many``: the flights of many logs, on the cores of this machine or on a Dask cluster."""
