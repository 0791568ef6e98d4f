"""Waits for a board's first HEARTBEAT on its link."""

import socket
import time
from collections.abc import Callable
from typing import Any

import serial

from protocol import dialect
from sim_bridge.boards.image import read_entries
from sim_bridge.errors import BoardError

WAIT_S = 20.0


def wait_for_heartbeat(settings: str, listen: str | None, say: Callable[[str], None], wait_s: float = WAIT_S) -> None:
    """Listen where the board of these `settings` (the text of its board.py) sends, until it is heard.

    `listen` is the serial port of this computer that a UART link ends at, as DEVICE[:BAUD].

    Raises:
        BoardError: nothing was received, or listening failed.
    """
    entries = read_entries(settings) or {}
    if entries.get("LINK") == "wifi":
        host, port = str(entries.get("GROUND", ":14550")).split(":")
        say(f"waiting for the first HEARTBEAT on UDP port {port}")
        _await(_udp(int(port)), f"no HEARTBEAT on UDP port {port} within {wait_s:g} s: is this computer {host}, does "
               "the firewall let UDP in, and what does the console say (`mpremote resume repl`)?", wait_s, say)
    elif listen:
        device, _, baud = listen.partition(":")
        speed = int(baud) if baud.isdigit() else int(entries.get("UART_BAUD", 115200))
        say(f"waiting for the first HEARTBEAT on {device} at {speed} baud")
        _await(_uart(device, speed), f"no HEARTBEAT on {device} within {wait_s:g} s: are TX and RX crossed, and what "
               "does the console say (`mpremote resume repl`)?", wait_s, say)
    else:
        say("restarted; its link is a UART: give LISTEN=DEVICE[:BAUD], where the cable ends here, to wait for it")


def _udp(port: int) -> Callable[[], bytes]:
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.settimeout(0.2)
    try:
        listener.bind(("", port))
    except OSError as error:
        listener.close()
        raise BoardError(f"UDP port {port}: {error.strerror}; the ground station that has it hears the board") from None

    def read() -> bytes:
        try:
            return listener.recv(2048)
        except TimeoutError:
            return b""

    return read


def _uart(device: str, speed: int) -> Callable[[], bytes]:
    try:
        line = serial.Serial(device, speed, timeout=0.2)
    except (OSError, ValueError) as error:
        raise BoardError(f"{device}: {error}") from None
    return lambda: line.read(512)


def _await(read: Callable[[], bytes], otherwise: str, wait_s: float, say: Callable[[str], None]) -> None:
    parser: Any = dialect.MAVLink(None)
    parser.robust_parsing = True
    end = time.monotonic() + wait_s
    while time.monotonic() < end:
        for message in parser.parse_buffer(read()) or []:
            if message.get_type() == "HEARTBEAT" and message.type == dialect.MAV_TYPE_KITE:
                say(f"heard: HEARTBEAT of system {message.get_srcSystem()}")
                return
    raise BoardError(otherwise)
