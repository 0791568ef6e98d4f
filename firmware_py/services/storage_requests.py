"""MAV_CMD_PREFLIGHT_STORAGE: a ground station reads, writes and resets what is on flash."""

from ..generated_enums import (
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_FAILED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_SEVERITY_WARNING,
)

_READ = 0.0
_WRITE = 1.0
_RESET = 2.0


class StorageCommands:
    """Over a `keeper`. `announce(index)` is called for each parameter that a command changed."""

    def __init__(self, parameters, modes, keeper, say, announce):
        self._parameters = parameters
        self._modes = modes
        self._keeper = keeper
        self._say = say
        self._announce = announce

    def run(self, action):
        """Do what param1 of the command asks for; return the MAV_RESULT."""
        if action not in (_READ, _WRITE, _RESET):
            return MAV_RESULT_DENIED
        if self._keeper.store is None:
            self._say(MAV_SEVERITY_WARNING, "no storage on this board")
            return MAV_RESULT_TEMPORARILY_REJECTED
        if self._modes.armed():
            self._say(MAV_SEVERITY_WARNING, "disarm first")
            return MAV_RESULT_TEMPORARILY_REJECTED
        before = list(self._parameters.values)
        if action == _READ:
            done = self._keeper.read_back()
        elif action == _WRITE:
            done = self._keeper.save()
        else:
            done = self._keeper.reset()
        for index in range(len(before)):
            if self._parameters.values[index] != before[index]:
                self._announce(index)
        return MAV_RESULT_ACCEPTED if done else MAV_RESULT_FAILED
