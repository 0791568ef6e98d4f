"""The order of a station's commands that change mode or arming, over any number of links.

A station numbers its frames across all links. A copy over a slow link may arrive after a later command
was obeyed: it must not undo that one.
"""

_RECENT_US = 3000000  # a link that is later than this is not flown by; beyond it a station may have begun anew
_BEHIND = 32  # numbers; further back it is a station that begins anew
_REMEMBERED = 8


class CommandOrder:
    """Remembers the last few commands that were obeyed, or overtaken while they waited."""

    def __init__(self):
        self._done = []  # (sender, sequence, what, time), the newest last

    def is_late(self, sender, sequence, what, is_safe, uptime_us):
        """True for a command that is not later than its sender's last one. Ask only if it would change something.

        `what` it asks for; `is_safe`: PARK, MANUAL or disarm, which are late only as the very frame that was obeyed
        before. `sequence` None: nothing is known of the order.
        """
        if sequence is None:
            return False
        last = None
        same = False
        for command in self._done:
            if command[0] == sender and uptime_us - command[3] < _RECENT_US:
                last = command
                same = same or (command[1] == sequence and command[2] == what)
        if last is None or (last[1] - sequence) & 0xFF > _BEHIND:
            return False
        return same or not is_safe

    def note(self, sender, sequence, what, uptime_us):
        """A command was obeyed, or is overtaken for good; one without a number says nothing of the order."""
        if sequence is None:
            return
        self._done = self._done[1 - _REMEMBERED :]
        self._done.append((sender, sequence, what, uptime_us))
