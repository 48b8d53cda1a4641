"""The MAVLink half of the simulated plane: protocols without sockets, driven by messages and by ticks.

``codec`` and ``link`` carry frames; ``telemetry`` and ``streams`` build and schedule telemetry; ``parameters``,
``mission``, ``ftp`` and ``commands`` are one protocol each; ``component`` combines them for one plane.
"""
