"""Runs the command line as `python -m maviper`.

Does: calls `maviper.cli.main`.
Assumes: nothing.
Does not: parse anything itself.
"""

from maviper.cli import main

if __name__ == "__main__":
    main()
