"""Tests of photons."""
