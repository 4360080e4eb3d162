"""The vehicle behind a connection string: ``connect`` opens the link and finds the vehicle on it.

DroneKit is imported in ``dronekit_adapter`` alone, when a vehicle is connected.
"""

from flight_replay.vehicle.connected_vehicle import CONNECT_LIMIT_S, ConnectedVehicle, connect

__all__ = ["CONNECT_LIMIT_S", "ConnectedVehicle", "connect"]
