"""Flights that rehearsals are compared with: recorded, or flown by the simulated plane (bench/truth.py)."""
