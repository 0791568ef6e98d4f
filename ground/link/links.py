"""Several links to one vehicle at a time; each is reopened automatically when it breaks."""

import select
import time
from collections.abc import Callable
from itertools import chain
from typing import NamedTuple

from ground.link.framing import FrameReader, Received
from ground.link.statistics import LinkStatistics
from ground.link.transports import LinkError, Transport, open_transport, parse_link

Clock = Callable[[], float]

RETRY_S = 1.0
HEARS_S = 3.0  # a link counts as hearing the vehicle for this long after its last message
_SLICE_S = 0.01


class Link:
    """One link to the vehicle. `problem` says why it is not open; `statistics` covers the vehicle's messages on it."""

    def __init__(self, name: str, opener: Callable[[], Transport]) -> None:
        self.name = name
        self.problem: str | None = None
        self.statistics = LinkStatistics()
        self.bytes_received = 0
        self.transport: Transport | None = None
        self.reader = FrameReader()
        self.retry_s = float("-inf")
        self.opener = opener
        self._vehicle_at: object = None  # the sender of the vehicle's heartbeats
        self._vehicle_at_s = float("-inf")  # when the last one arrived from there

    def meet(self, now_s: float) -> None:
        """The data read last held the vehicle's heartbeat: send to that sender from now on.

        Another sender, even under the vehicle's id, gets nothing while the first one is heard.
        """
        if self.transport is None:
            return
        sender = self.transport.sender
        if sender != self._vehicle_at and now_s - self._vehicle_at_s < HEARS_S:
            return
        self._vehicle_at, self._vehicle_at_s = sender, now_s
        self.transport.answer(sender)

    def hears(self, now_s: float) -> bool:
        """Whether the vehicle was heard on it within HEARS_S."""
        last_s = self.statistics.last_s
        return self.transport is not None and last_s is not None and now_s - last_s < HEARS_S


class Heard(NamedTuple):
    """A message, and the link on which it arrived."""

    link: Link
    received: Received


class Links:
    """All links to the vehicle. `warn` receives a line when one breaks, and when it is back.

    `clock` gives seconds; `sleep` is called when no link is open to wait for.
    """

    def __init__(self, openers: dict[str, Callable[[], Transport]], clock: Clock,
                 warn: Callable[[str], None], sleep: Callable[[float], None] = time.sleep) -> None:
        self.all = [Link(name, opener) for name, opener in openers.items()]
        self.clock = clock
        self.warn = warn
        self._sleep = sleep

    @property
    def name(self) -> str:
        """The names of all, for messages."""
        return ", ".join(link.name for link in self.all)

    def open(self) -> None:
        """Open every link; those that fail are retried later. Raises LinkError if all fail."""
        problems = [error for link in self.all if (error := self._open(link)) is not None]
        if len(problems) == len(self.all):
            self.close()
            raise problems[0]
        for error in problems:
            self.warn(f"{error}; retrying while the other links are used")

    def send(self, data: bytes, everywhere: bool = False) -> None:
        """Send on the links on which the vehicle is heard; on all of them if there are none, or if `everywhere`."""
        now_s = self.clock()
        opened = [link for link in self.all if link.transport]
        hearing = [link for link in opened if link.hears(now_s)]
        for link in opened if everywhere or not hearing else hearing:
            try:
                assert link.transport
                link.transport.send(data)
            except LinkError as error:
                self._lose(link, error)

    def receive(self, timeout_s: float) -> list[Heard]:
        """Wait up to `timeout_s` [s] for messages on any link, and retry links that are down."""
        self._reopen()
        opened = [link for link in self.all if link.transport]
        if not opened:
            self._sleep(min(timeout_s, RETRY_S))
            return []
        if len(opened) == 1:
            return self._read(opened[0], timeout_s)
        files = [link.transport.fileno() for link in opened if link.transport]
        if None not in files:
            select.select([file for file in files if file is not None], [], [], max(timeout_s, 0.0))
            return self._read_all(opened)
        return self._take_turns(opened, timeout_s)

    def close(self) -> None:
        """Close every link. May be called twice."""
        for link in self.all:
            if link.transport:
                link.transport.close()
                link.transport = None
                link.retry_s = float("inf")

    def _take_turns(self, opened: list[Link], timeout_s: float) -> list[Heard]:
        """If the operating system cannot wait for all at once: read each, and wait briefly on one."""
        end_s = self.clock() + timeout_s
        while not (heard := self._read_all(opened)) and (left_s := end_s - self.clock()) > 0.0:
            heard = self._read(opened[0], min(_SLICE_S, left_s))
            if heard:
                break
        return heard

    def _read_all(self, opened: list[Link]) -> list[Heard]:
        return list(chain.from_iterable(self._read(link, 0.0) for link in opened))

    def _read(self, link: Link, timeout_s: float) -> list[Heard]:
        try:
            data = link.transport.receive(timeout_s) if link.transport else b""
        except LinkError as error:
            self._lose(link, error)
            return []
        link.bytes_received += len(data)
        return [Heard(link, received) for received in link.reader.feed(data)]

    def _lose(self, link: Link, error: LinkError) -> None:
        if link.transport:
            link.transport.close()
        link.transport, link.problem = None, str(error)
        link.retry_s = self.clock() + RETRY_S
        self.warn(f"{error}; retrying every {RETRY_S:g} s")

    def _reopen(self) -> None:
        for link in self.all:
            if link.transport is None and self.clock() >= link.retry_s and self._open(link) is None:
                self.warn(f"link {link.name}: back")

    def _open(self, link: Link) -> LinkError | None:
        try:
            link.transport = link.opener()
        except LinkError as error:
            link.problem, link.retry_s = str(error), self.clock() + RETRY_S
            return error
        link.transport.answer(None)  # to nobody, until the vehicle is heard
        link.problem, link.reader = None, FrameReader()
        return None


def open_links(names: list[str], clock: Clock, warn: Callable[[str], None]) -> Links:
    """Open the links `names`, each in one of the forms of `open_transport`.

    Raises:
        LinkError: a name has none of these forms, two are equal, or no link can be opened.
    """
    for name in names:
        parse_link(name)
        if names.count(name) > 1:
            raise LinkError(f"link {name!r}: given twice")
    links = Links({name: lambda name=name: open_transport(name) for name in names}, clock, warn)
    links.open()
    return links
