"""Random sources of Python and C, read, and asked beside Python itself and compiled C: see tests/hunt.py."""
