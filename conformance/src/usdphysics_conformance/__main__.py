"""`python -m usdphysics_conformance`."""

from usdphysics_conformance.cli import main

if __name__ == "__main__":
    main()
