"""Flights that are compared with rehearsals: recorded, or flown by the simulated plane (bench/truth.py)."""
