"""The vehicle behind a connection string; what it says is heard, and what is asked is checked.

``connect`` is the way in. DroneKit is imported in ``drone`` alone, when a vehicle is connected.
"""

from flight_replay.vehicle.connected_vehicle import ConnectedVehicle, connect

__all__ = ["ConnectedVehicle", "connect"]
