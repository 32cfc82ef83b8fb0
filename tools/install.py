"""Install packages into this environment with uv, under pip's settings: python tools/install.py PIP_INSTALL_ARGUMENTS.

uv resolves and unpacks five times as fast as pip, but reads none of pip's settings: indexes, constraints, certificates.
It runs before anything else is installed, so it needs the standard library and pip alone.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from urllib.parse import unquote, urlsplit

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
#: Options of uv for those settings of pip that have a list of values.
OPTIONS = {
    "constraint": "--constraint",
    "extra-index-url": "--index",
    "find-links": "--find-links",
    "trusted-host": "--allow-insecure-host",
}
#: Variables of uv for the others.
VARIABLES = {"index-url": "UV_DEFAULT_INDEX", "cert": "SSL_CERT_FILE", "proxy": "ALL_PROXY"}
#: Later ones override earlier ones.
LEVELS = ("global", "install", ":env:")


def main(arguments: list[str]) -> int:
    """Install, and return uv's exit code; that of pip if uv itself cannot be installed."""
    quiet = ("--quiet", "--disable-pip-version-check")
    pip = [sys.executable, "-m", "pip"]
    dev = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["optional-dependencies"]["dev"]
    uv = next(requirement for requirement in dev if re.match(r"uv\b", requirement))
    if code := subprocess.run([*pip, "install", *quiet, uv], check=False).returncode:
        return code
    listed = subprocess.run([*pip, "config", "list"], check=True, capture_output=True, text=True).stdout
    settings = effective(listed)
    environment = dict(os.environ)
    for name, variable in VARIABLES.items():
        if name in settings:
            environment[variable] = settings[name]
    command = [str(Path(sys.executable).with_name("uv")), "pip", "install", "--quiet", "--python", sys.executable]
    return subprocess.run([*command, *options(settings), *arguments], env=environment, check=False).returncode


def effective(listed: str) -> dict[str, str]:
    """Return the settings of pip that count, from the output of `pip config list`."""
    found = re.findall(r"^([\w:-]+)\.([\w-]+)='(.*)'$", listed, re.MULTILINE)
    return {name: value for level in LEVELS for at, name, value in found if at == level}


def options(settings: dict[str, str]) -> list[str]:
    """Return the options of uv with the same meaning. As in pip, the best version of all indexes is taken."""
    lists = [(option, value) for name, option in OPTIONS.items() for value in settings.get(name, "").split()]
    return [
        "--index-strategy=unsafe-best-match",
        *(["--no-index"] if settings.get("no-index", "").lower() in ("1", "on", "true", "yes") else []),
        *(part for option, value in lists for part in (option, path(value) if option == "--constraint" else value)),
    ]


def path(address: str) -> str:
    """Return the path of a `file:` address; uv takes no address for constraints."""
    return unquote(urlsplit(address).path) if address.startswith("file:") else address


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
