"""Files that grow together and stay consistent if the program is killed, interrupted or out of disk at any moment."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple


class _State(NamedTuple):
    """All that changes, so that one assignment, which no signal can divide, moves from one state to the next."""

    files: tuple[int, ...]
    sizes: tuple[int, ...]
    pending: list[tuple[bytes, ...]]


class GrowingFiles:
    """New files at `paths`, with `heads` for their first bytes.

    `add` keeps a record for each file, and `commit` writes them out: to all files or, if that fails, to none. After an
    interrupt at any point the next `commit` does what was left. Files are written in the order of `paths`: of a
    process killed in between, the first ones have more.

    Raises:
        OSError: a file is there already, or cannot be made.
    """

    def __init__(self, paths: Sequence[Path], heads: Sequence[bytes]):
        self._paths = tuple(paths)
        self._heads = tuple(heads)
        self._state = _State((), (), [])
        for path in self._paths:
            files = (*self._state.files, _create(path, os.O_EXCL))
            self._state = _State(files, (0,) * len(files), [])
        self.add(*self._heads)
        self.commit()

    @property
    def sizes(self) -> tuple[int, ...]:
        """Bytes written to each file [bytes]."""
        return self._state.sizes

    def add(self, *records: bytes) -> None:
        """Keep what is to be written next to each file."""
        self._state.pending.append(records)

    def commit(self) -> None:
        """Hand what was added to the operating system.

        Raises:
            OSError: it cannot be written; all files are as after the last commit.
        """
        files, sizes, pending = self._state
        if not pending or not files:
            return
        chunks = [b"".join(records) for records in zip(*pending, strict=True)]
        try:
            for file, size, chunk in zip(files, sizes, chunks, strict=True):
                _write_at(file, size, chunk)
        except OSError:
            for file, size in zip(files, sizes, strict=True):
                os.ftruncate(file, size)
            raise
        grown = tuple(size + len(chunk) for size, chunk in zip(sizes, chunks, strict=True))
        self._state = _State(files, grown, [])

    def start_again(self, index: int) -> None:
        """Set the file at `index` aside, in the place of the one set aside before, and begin it again.

        Raises:
            OSError: that cannot be.
        """
        path, old = self._paths[index], self._state.files[index]
        if path.exists() and os.path.samestat(path.stat(), os.fstat(old)):
            path.replace(set_aside(path))
        new, head = _create(path, os.O_TRUNC), self._heads[index]
        _write_at(new, 0, head)
        files, sizes, pending = self._state
        self._state = _State(
            (*files[:index], new, *files[index + 1 :]), (*sizes[:index], len(head), *sizes[index + 1 :]), pending)
        os.close(old)

    def close(self) -> None:
        """Close the files as they are; what was not committed is lost."""
        files = self._state.files
        self._state = _State((), (), [])
        for file in files:
            os.close(file)


def set_aside(path: Path) -> Path:
    """Where the earlier part of the file at `path` is kept."""
    return path.with_name(f"{path.stem}.old{path.suffix}")


def _create(path: Path, how: int) -> int:
    return os.open(path, os.O_WRONLY | os.O_CREAT | how | getattr(os, "O_BINARY", 0), 0o666)


def _write_at(file: int, offset: int, data: bytes) -> None:
    os.lseek(file, offset, os.SEEK_SET)
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]
