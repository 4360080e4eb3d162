"""Reading DataFlash logs, which ArduPilot writes on board: ``.bin`` files, and ``.log`` as text."""
