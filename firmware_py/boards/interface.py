"""What the control loop needs of a board, and parts for boards that lack something.

A board is any object with these attributes; each of them is handed in, never imported by the loop:

    ticks_us()      the clock [us], wrapped at 2^30 (see clock.py)
    ended()         True when the loop should return; a real board never ends
    transport       read() -> bytes or None, write(view), wait(timeout_ms) -> bool, `datagrams`: True where bytes
                    arrive in whole datagrams
    bytes_per_tick  received at most in a tick: more would take longer than there is
    sensors         None where samples arrive over the link; else sample(now) -> values of KITE_SENSORS in wire
                    order, or None while there is nothing new
    actuator        None where steering only goes out over the link; else write(steering, armed): -1 to 1, neutral
                    where not armed
    storage         None, or a folder of small files: read(name) -> bytes or None, write(name, data),
                    rename(old, new), remove(name)
    retained        None, or a few hundred bytes of memory that survive a watchdog reset but not a loss of power:
                    read() -> bytes, write(data)
    watchdog        feed()
    light           show(mode, stale, now): what the operator sees
    reset_cause     one of the words below
"""

POWER_ON = "power-on"
WATCHDOG = "watchdog"
SOFT = "soft"


class NoWatchdog:
    """For boards that have none, and for the PC."""

    def feed(self):
        """Nothing waits to be fed."""


class NoLight:
    """For boards without a status light."""

    def show(self, mode, stale, now):
        """Nobody sees it."""
