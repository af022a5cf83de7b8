"""Random sources of if/else Python and C, imported, and asked beside Python itself and compiled C: see tests/hunt.py."""
