"""Writes many parameters over a link with loss and delay."""

from collections.abc import Sequence

from ground.link.connection import SILENCE_S, Connection
from ground.link.framing import Message
from ground.parameters.changes import RENAMING, Change, ChangeState, Setting, Table, Told

AT_ONCE = 8  # under way at a time: a slow link stays free for telemetry, a slow answer delays no other


class ParameterWriter:
    """Sends each change until the vehicle acknowledges or refuses it, `attempts` times at most.

    `retries` counts the repeated requests.
    """

    def __init__(self, connection: Connection, table: Table, attempts: int) -> None:
        self.retries = 0
        self._connection, self._table, self._attempts = connection, table, attempts
        self._started_s = connection.clock()

    def write(self, changes: Sequence[Change], told: Told) -> None:
        """Send `changes` and update their states; `told` is called with each when it has its answer.

        Those refused for a reason not in the table are retried after the others, one at a time, as long as any is
        accepted: a wider eight may have to wait until its centre is higher. A new SYSTEM_ID goes last.
        """
        self._started_s = self._connection.clock()
        first = [change for change in changes if change.name != RENAMING]
        refused = self._carry_out(first, told)
        while len(first) > 1 and refused:
            left = [change for change in refused if self._carry_out([change], told)]
            if len(left) == len(refused):
                break
            refused = left
        self._carry_out([change for change in changes if change.name == RENAMING], told)

    def _carry_out(self, changes: Sequence[Change], told: Told) -> list[Change]:
        """Send `changes` until each is settled; return those refused perhaps because of another value."""
        waiting = [Setting(self._connection, self._table, change, alone=len(changes) == 1) for change in changes]
        under_way: list[Setting] = []
        surprised: list[Change] = []

        def observe(time_s: float, message: Message, frame: bytes) -> None:
            for setting in under_way:
                setting.observe(message)

        self._connection.add_observer(observe)
        try:
            while (waiting or under_way) and not self._is_down():
                while waiting and len(under_way) < AT_ONCE:
                    under_way.append(waiting.pop(0))
                self._send_due(under_way)
                self._connection.wait_until(lambda: any(setting.settled for setting in under_way),
                                            min(setting.due_s for setting in under_way) - self._connection.clock())
                for setting in [setting for setting in under_way if setting.settled or self._is_spent(setting)]:
                    under_way.remove(setting)
                    if setting.surprising and setting.change.state is ChangeState.REFUSED:
                        surprised.append(setting.change)
                    told(setting.change)
        finally:
            self._connection.remove_observer(observe)
        return surprised

    def _send_due(self, under_way: list[Setting]) -> None:
        for setting in under_way:
            if setting.due_s <= self._connection.clock():
                self.retries += setting.change.state is ChangeState.SENT
                setting.send()

    def _is_spent(self, setting: Setting) -> bool:
        if setting.change.sent < self._attempts or setting.due_s > self._connection.clock():
            return False
        setting.give_up()
        return True

    def _is_down(self) -> bool:
        return self._connection.silence_s(self._started_s) >= SILENCE_S
