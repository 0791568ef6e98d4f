"""A folder of a filesystem as storage: on boards, and on a PC under CPython or MicroPython's unix port."""

import os
from errno import ENOENT

_replace = getattr(os, "replace", os.rename)  # CPython's rename does not replace a file on every system


class FileStorage:
    """Small files in `folder`, which is made where there is none; "" is the folder that the program runs in.

    All raise OSError where the filesystem fails.
    """

    def __init__(self, folder: str) -> None:
        self._prefix: str = folder + "/" if folder else ""
        if folder:
            try:
                os.mkdir(folder)
            except OSError:  # it is there already, or the first write will say what is wrong
                pass

    def read(self, name: str) -> bytes | None:
        """The content of file `name`, or None where there is no such file."""
        try:
            with open(self._prefix + name, "rb") as file:
                return file.read()
        except OSError as error:
            if error.errno == ENOENT:
                return None
            raise

    def write(self, name: str, data: bytes) -> None:
        """Write `data` to file `name`; on return it is stored."""
        with open(self._prefix + name, "wb") as file:
            file.write(data)
            file.flush()
            if hasattr(os, "fsync"):
                os.fsync(file.fileno())
        if not hasattr(os, "fsync") and hasattr(os, "sync"):
            os.sync()

    def rename(self, old: str, new: str) -> None:
        """Rename file `old` to `new`, atomically replacing a file of that name."""
        _replace(self._prefix + old, self._prefix + new)

    def remove(self, name: str) -> None:
        """Delete file `name`."""
        os.remove(self._prefix + name)
