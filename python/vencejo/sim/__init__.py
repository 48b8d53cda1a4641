"""The simulated plane: a JSBSim foam pusher flown by an ArduPlane-like autopilot that speaks MAVLink."""
