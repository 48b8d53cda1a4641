"""Runs the command as ``python -m vencejo.cli``."""

from vencejo.cli import main

if __name__ == "__main__":
    main()
