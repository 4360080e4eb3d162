"""The vehicle's clock over wraps, reboots and records that come late."""
