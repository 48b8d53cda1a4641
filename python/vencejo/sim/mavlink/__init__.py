"""The MAVLink face of the simulated plane: protocols without sockets, driven by messages and by ticks.

``codec`` and ``link`` carry frames; ``telemetry`` and ``streams`` say what is sent and how often; ``parameters``,
``mission``, ``ftp`` and ``commands`` are one protocol each; ``component`` puts them together for one plane.
"""
