"""Tests of the checkout itself: arrows, documents, locks, benchmarks, the wheel."""
