"""What pyproject.toml cannot say: a wheel made where the compiled loop was built carries it, for that Python only."""

import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

sys.path.insert(0, str(Path(__file__).parent))
from sim_bridge.native.choice import misfit_of_build
from sim_bridge.native.modules import BUILD

_MISFIT = misfit_of_build()  # also where there is none


class DistributionWithLoop(Distribution):
    """Has extension modules where there is a build of the very sources that are packed."""

    def has_ext_modules(self) -> bool:
        """True makes the wheel one for this platform and Python."""
        return _MISFIT is None


class BuildPackages(build_py):
    """Leaves a build of other sources out."""

    def finalize_options(self) -> None:
        """As setuptools does, less that folder."""
        super().finalize_options()
        if _MISFIT is not None:
            self.packages = [name for name in self.packages or () if name.partition(".")[0] != BUILD.name]


setup(distclass=DistributionWithLoop, cmdclass={"build_py": BuildPackages})
