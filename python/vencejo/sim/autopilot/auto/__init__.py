"""What AUTO does: the mode, the flow of the mission, the execution of each command, and the commands' names.

Take-offs and landings, which other modes fly too, are in :mod:`..takeoff` and :mod:`..landing`.
"""
