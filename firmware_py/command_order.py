"""Tells commands that move the kite in the order in which a station sent them, over however many links they come.

A station numbers what it sends, whatever link that goes over. A copy over a slow link may arrive when a later command
was obeyed already: it must not undo that one.
"""

_RECENT_US = 3000000  # a link that is later than this is not flown by; beyond it a station may have begun anew
_BEHIND = 32  # numbers; further back it is a station that begins anew
_REMEMBERED = 8


class CommandOrder:
    """Remembers the last few commands that were obeyed or refused: (sender, sequence, what, time)."""

    def __init__(self):
        self._commands = []

    def is_late(self, sender, sequence, what, is_safe, uptime_us):
        """True for a command that its sender overtook; else it is remembered.

        `what` it asks for; one that asks for the same as the last is no harm. `is_safe`: PARK, MANUAL or disarm, which
        are late only as the very frame that came before. `sequence` None: nothing is known of the order.
        """
        if sequence is None:
            return False
        recent = [command for command in self._commands if uptime_us - command[3] < _RECENT_US]
        mine = [command for command in recent if command[0] == sender]
        last = mine[-1] if mine else None
        if last is None or (last[1] - sequence) & 0xFF > _BEHIND:
            repeats = False
        else:
            repeats = last[2] == what
            if not repeats and (not is_safe or _has(mine, sequence, what)):
                return True
        if not repeats:
            recent.append((sender, sequence, what, uptime_us))
        self._commands = recent[-_REMEMBERED:]
        return False


def _has(commands, sequence, what):
    """True if this very frame is among the `commands`."""
    return any(command[1] == sequence and command[2] == what for command in commands)
