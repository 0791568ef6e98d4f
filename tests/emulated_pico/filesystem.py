"""The file system of a Pico: littlefs on the last 352 blocks of its flash, as MicroPython makes it."""

from pathlib import Path

from littlefs import LittleFS, LittleFSError

BLOCK_BYTES = 4096
BLOCKS = 352
OFFSET = 2 * 1024 * 1024 - BLOCKS * BLOCK_BYTES  # in flash


def filesystem_of(folder: Path, full: bool = False) -> bytes:
    """An image that holds the files of `folder`; with `full` also one that leaves no room for another."""
    disk = _disk()
    disk.format()
    disk.mount()
    for path in sorted(folder.rglob("*")):
        name = "/" + path.relative_to(folder).as_posix()
        if path.is_dir():
            disk.mkdir(name)
        else:
            with disk.open(name, "wb") as file:
                file.write(path.read_bytes())
    if full:
        _fill(disk)
    return bytes(disk.context.buffer)


def files_of(image: bytes) -> dict[str, bytes]:
    """The files of an image by name.

    Raises:
        littlefs.LittleFSError: it cannot be mounted.
    """
    disk = _disk()
    disk.context.buffer = bytearray(image)
    disk.mount()
    files = {}
    for folder, _, names in disk.walk("/"):
        for name in names:
            path = f"{folder.rstrip('/')}/{name}"
            with disk.open(path, "rb") as file:
                files[path] = file.read()
    return files


def _fill(disk: LittleFS) -> None:
    number = 0
    while True:
        try:
            with disk.open(f"/fill{number}", "wb") as file:
                file.write(bytes(BLOCK_BYTES))
        except LittleFSError:
            return
        number += 1


def _disk() -> LittleFS:
    return LittleFS(block_size=BLOCK_BYTES, block_count=BLOCKS, prog_size=256, read_size=32, mount=False)
