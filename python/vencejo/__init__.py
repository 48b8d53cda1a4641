"""Vencejo: send a fixed-wing autonomous plane to positions."""
