"""The ArduPlane-like autopilot of the simulated plane."""
