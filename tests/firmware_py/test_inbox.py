"""Where messages wait: the newest sample counts, no sender takes all places, and what finds none is counted."""

import pytest
from firmware_bench import PARK, sample

from firmware_py.services.inbox import Inbox, Queue
from firmware_py.services.request import Request
from protocol import dialect

SENSORS = dialect.MAVLINK_MSG_ID_KITE_SENSORS
SET, PING = dialect.MAVLINK_MSG_ID_PARAM_SET, dialect.MAVLINK_MSG_ID_PING
FTP = dialect.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL
WRAP = 1 << 30
VALUES = (1.0, 1, 1, b"INNER_P", 9)  # of a PARAM_SET; as good as any for a PING


@pytest.mark.parametrize(("stamps", "newest"), [
    ((1000, 3000, 2000), 3000), ((1000, 1001), 1001), ((WRAP - 500, 500, WRAP - 100), 500)])
def test_of_the_samples_that_come_in_one_tick_the_newest_counts(stamps, newest):
    """A link lets go of what it held back, in any order, and the sensor's clock may wrap meanwhile."""
    inbox = Inbox()
    for stamp in stamps:
        inbox.put(SENSORS, sample(stamp), 1, 1)
    assert inbox.take_sample() == sample(newest)
    assert inbox.take_sample() is None


def test_a_second_sample_with_the_same_stamp_does_not_take_the_firsts_place():
    inbox = Inbox()
    for azimuth in (0.1, 0.2):
        inbox.put(SENSORS, sample(1000, azimuth=azimuth), 1, 1)
    assert inbox.take_sample() == sample(1000, azimuth=0.1)


def waiting_of(queue: Queue) -> list[int]:
    return [request.system for request in queue.requests]


@pytest.mark.parametrize(("message", "places"), [(SET, 32), (PING, 64)])
def test_the_last_four_places_are_for_those_who_have_none(message, places):
    inbox = Inbox()
    queue = inbox.orders if message == SET else inbox.questions
    for _ in range(2):  # and the second time as the first: places that were left are free again, and nobody's
        before = inbox.refused
        for _ in range(100):
            inbox.put(message, VALUES, 66, 1)
        assert inbox.refused == before + 100 - (places - 4)
        for system in (1, 1, 2, 3, 4, 5):  # one place each, while there are any
            inbox.put(message, VALUES, system, 190)
        assert waiting_of(queue) == [66] * (places - 4) + [1, 2, 3, 4]
        assert inbox.refused == before + 100 - (places - 4) + 2
        while queue.requests:
            queue.take()


def test_a_place_is_free_again_for_a_sender_who_still_waits():
    queue = Queue(32)
    for _ in range(28):
        assert queue.put(Request(PING, (), 66, 1))
    assert not queue.put(Request(PING, (), 66, 1))
    queue.take()
    assert queue.put(Request(PING, (), 66, 1))
    assert not queue.put(Request(PING, (), 66, 1))


def test_senders_are_taken_in_turn_and_each_ones_oldest_first():
    queue = Queue(32)
    for number, system in enumerate((66, 66, 66, 1, 66, 2, 1)):
        queue.put(Request(PING, (number,), system, 1))
    taken = [queue.take_fairly() for _ in range(7)]
    assert [(*request.values, request.system) for request in taken] == [
        (0, 66), (3, 1), (1, 66), (5, 2), (2, 66), (6, 1), (4, 66)]


def test_four_pieces_of_files_wait_and_the_fifth_is_refused():
    inbox = Inbox()
    for number in range(6):
        inbox.put(FTP, (number,), 255, 190)
    assert inbox.files == [((number,), 255, 190) for number in range(4)]
    assert inbox.refused == 2


def test_what_nobody_has_a_use_for_takes_no_place_and_is_not_refused():
    inbox = Inbox()
    inbox.put(dialect.MAVLINK_MSG_ID_COMMAND_ACK, (PARK, 0, 0, 0, 0, 0), 255, 190)
    assert (inbox.orders.requests, inbox.questions.requests, inbox.urgent, inbox.refused) == ([], [], [], 0)
