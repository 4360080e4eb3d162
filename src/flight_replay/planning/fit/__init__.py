"""The whole flight in few waypoints, straight and spline, with holds and speeds: ``--route fit``.

``fit`` plans with the model of how ArduCopter flies (``simulator``), because a line on paper says
little of the flight: dense straight legs crawl, splines bulge, corners are cut. The objective and
its trade between space and time are in ``objective``.
"""

from flight_replay.planning.fit.fit import fit
from flight_replay.planning.fit.result import FitResult

__all__ = ["FitResult", "fit"]
