"""The one exception that a user's mistake may raise; the command line prints it and exits with code 2."""


class WmsError(Exception):
    """A mistake in what the user gave us (a stage, a setting, a missing engine), said in a sentence with its remedy."""
