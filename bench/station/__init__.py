"""Figures of the ground station in the browser: its server, its page, and a plane for both."""
