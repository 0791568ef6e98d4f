"""What pyproject.toml cannot say: a wheel made where the compiled loop was built carries it, for that Python only."""

from pathlib import Path

from setuptools import Distribution, setup


class DistributionWithLoop(Distribution):
    """Has extension modules where `make compiled` has put some."""

    def has_ext_modules(self) -> bool:
        """True makes the wheel one for this platform and Python."""
        return (Path(__file__).parent / "kitepilot_compiled" / "build.json").exists()


setup(distclass=DistributionWithLoop)
