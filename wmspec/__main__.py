"""`python -m wmspec` is `wmspec`."""

from wmspec.cli import main

if __name__ == "__main__":
    main()
