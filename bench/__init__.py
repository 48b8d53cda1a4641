"""Comparison with other tools: see bench/README.md."""
