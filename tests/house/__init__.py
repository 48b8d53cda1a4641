"""Tests of the checkout itself: architecture, documents, locks, benchmarks, the wheel."""
