"""What the control loop needs from a board, and stand-ins for missing parts.

A board is any object with these attributes; each is passed in, never imported by the loop:

    ticks_us()      the clock [us], wrapped at 2^30 (see clock.py)
    ended()         True when the loop should return; a real board never ends
    transport       read() -> bytes or None, write(view), wait(timeout_ms) -> bool, `datagrams`: True where bytes
                    arrive in whole datagrams
    bytes_per_tick  maximum received in a tick: more would take too long
    sensors         None if samples arrive over the link; else sample(now) -> values of KITE_SENSORS in wire
                    order, or None if there is nothing new
    actuator        None if steering only goes out over the link; else write(steering, armed): -1 to 1, neutral
                    if not armed
    storage         None, or a folder of small files: read(name) -> bytes or None, write(name, data),
                    rename(old, new), remove(name)
    retained        None, or memory that survives a watchdog reset but not a loss of power, laid out as in
                    retained_layout.py: read(offset, size) -> bytes, write(offset, data)
    watchdog        feed()
    light           show(mode, stale, now): status light
    reset_cause     one of the words below
"""

POWER_ON = "power-on"
WATCHDOG = "watchdog"
SOFT = "soft"
CAUSES = (POWER_ON, WATCHDOG, SOFT)

# What is noted in retained memory, with a value.
EVENT_RESET = 1  # the cause, by its place in CAUSES
EVENT_MODE = 2  # the new mode


class NoWatchdog:
    """For boards without a watchdog, and for the PC."""

    def feed(self):
        """No watchdog to feed."""


class NoLight:
    """For boards without a status light."""

    def show(self, mode, stale, now):
        """No light to show it."""
