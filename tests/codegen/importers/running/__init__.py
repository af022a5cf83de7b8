"""Tests of the second reading of if/else Python, by Python itself."""
