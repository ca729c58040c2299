"""`python -m trundle` is the `trundle` command."""

from trundle.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
