"""What ground stations of others ask for: messages, intervals, modes, missions, files; and several at a time."""

import json
import struct
import zlib

import pytest
from firmware_bench import (
    ARM,
    MANUAL,
    NAMES,
    PARK,
    STANDBY,
    TRACK,
    Bench,
    FlyingKite,
    command_long,
    hovering,
    of_kind,
    set_parameter,
)

from protocol import dialect
from protocol.parameter_table import load_parameters

ACCEPTED, REJECTED, DENIED, UNSUPPORTED = (
    dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED, dialect.MAV_RESULT_DENIED,
    dialect.MAV_RESULT_UNSUPPORTED)
REQUEST, SET_INTERVAL, GET_INTERVAL = 512, dialect.MAV_CMD_SET_MESSAGE_INTERVAL, dialect.MAV_CMD_GET_MESSAGE_INTERVAL
REGULAR = ("HEARTBEAT", "SYS_STATUS", "KITE_STATE", "LOCAL_POSITION_NED", "NAMED_VALUE_FLOAT", "CURRENT_MODE")
NUMBERS = {kind.msgname: number for number, kind in dialect.mavlink_map.items()}


class Station:
    """A ground station of its own ids, on a bench."""

    def __init__(self, bench: Bench, system: int, component: int = 190):
        self.bench = bench
        self.ids = (system, component)
        self._mav = dialect.MAVLink(None, system, component)

    def tell(self, *messages: dialect.MAVLink_message) -> None:
        for message in messages:
            self.bench._waiting.append(message.pack(self._mav))
            self._mav.seq = (self._mav.seq + 1) % 256

    def answers(self, kind: str, messages: list) -> list:
        """Those of `messages` that are for this station."""
        return [m for m in of_kind(kind, messages) if (m.target_system, m.target_component) == self.ids]


@pytest.mark.parametrize("name", [*REGULAR, "AUTOPILOT_VERSION", "COMPONENT_METADATA", "AVAILABLE_MODES_MONITOR"])
def test_every_message_can_be_requested(name):
    bench = Bench()
    bench.run(0.44)
    usual = len(of_kind(name, bench.step()))
    messages = bench.ask(command_long(REQUEST, float(NUMBERS[name])))
    assert [ack.result for ack in of_kind("COMMAND_ACK", messages)] == [ACCEPTED]
    # (with the first request, CURRENT_MODE is sent regularly too)
    assert len(of_kind(name, messages)) == usual + (2 if name == "CURRENT_MODE" else 1)


def test_the_mode_is_told_regularly_once_a_station_knows_the_messages_about_modes():
    """To one that does not, each would be a number missing."""
    bench = Bench()
    assert not of_kind("CURRENT_MODE", bench.run(10.0))
    bench.ask(command_long(REQUEST, 435.0))
    assert len(of_kind("CURRENT_MODE", bench.run(10.0))) == 5


def test_what_is_not_sent_is_refused_at_once():
    bench = Bench()
    bench.sky = None
    for number in (242.0, 245.0, 22.0, -1.0, 0.5, 1e9, float("nan")):
        messages = bench.ask(command_long(REQUEST, number), command_long(SET_INTERVAL, number, 100000.0))
        assert [ack.result for ack in of_kind("COMMAND_ACK", messages)] == [UNSUPPORTED, UNSUPPORTED]
    assert bench.command(REQUEST, float(NUMBERS["KITE_STATE"])) == REJECTED  # there is no kite to speak of
    assert bench.command(410) == UNSUPPORTED  # home position
    whole = dialect.MAVLink_command_int_message(1, 1, 0, 410, 0, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    assert bench.ask_for("COMMAND_ACK", whole).result == UNSUPPORTED


@pytest.mark.parametrize(("name", "second"), [("KITE_STATE", 50), ("LOCAL_POSITION_NED", 4), ("SYS_STATUS", 1)])
def test_an_interval_is_kept_and_goes_back_to_the_usual(name, second):
    bench = Bench()
    number = float(NUMBERS[name])
    for interval_us, least, most in ((200000.0, 9, 11), (-1.0, 0, 0), (0.0, 2 * second - 1, 2 * second + 1)):
        assert bench.command(SET_INTERVAL, number, interval_us) == ACCEPTED
        answers = bench.ask(command_long(GET_INTERVAL, number))
        assert [ack.result for ack in of_kind("COMMAND_ACK", answers)] == [ACCEPTED]
        (told,) = of_kind("MESSAGE_INTERVAL", answers)
        assert told.message_id == number
        assert told.interval_us == (int(interval_us) or 1_000_000 // second)
        assert least <= len(of_kind(name, bench.run(2.0))) <= most
    for bad in (1.0, 1e12, -2.0, float("nan")):
        assert bench.command(SET_INTERVAL, number, bad) == DENIED
    assert bench.command(SET_INTERVAL, 0.0, -1.0) == DENIED  # the heartbeat stays


def test_modes_are_listed_and_the_present_one_is_told_when_it_changes():
    bench = Bench(FlyingKite())
    modes = of_kind("AVAILABLE_MODES", bench.ask(command_long(REQUEST, 435.0)))
    assert [(mode.mode_index, mode.custom_mode, mode.mode_name) for mode in modes] == [
        (1, STANDBY, "STANDBY"), (2, MANUAL, "MANUAL"), (3, PARK, "PARK"), (4, TRACK, "TRACK")]
    assert {mode.number_modes for mode in modes} == {4}
    assert modes[0].properties & dialect.MAV_MODE_PROPERTY_NOT_USER_SELECTABLE
    (one,) = of_kind("AVAILABLE_MODES", bench.ask(command_long(REQUEST, 435.0, 4.0)))
    assert one.mode_name == "TRACK"
    assert bench.command(REQUEST, 435.0, 5.0) == DENIED
    bench.heard.clear()
    bench.arm()
    assert bench.change_mode(TRACK) == ACCEPTED
    bench.run(0.1)
    told = [message.custom_mode for message in of_kind("CURRENT_MODE", [message for _, message in bench.heard])]
    assert told[-2:] == [PARK, TRACK]


def test_there_is_no_mission():
    (answer,) = of_kind("MISSION_COUNT", Bench().ask(dialect.MAVLink_mission_request_list_message(1, 1, 1)))
    assert (answer.count, answer.mission_type, answer.target_system) == (0, 1, 255)


def ftp(opcode: int, offset: int = 0, data: bytes = b"", size: int | None = None, session: int = 0,
        sequence: int = 7) -> dialect.MAVLink_message:
    """A message of MAVLink's file transfer."""
    head = struct.pack("<HBBBBBBI", sequence, session, opcode, len(data) if size is None else size, 0, 0, 0, offset)
    return dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, list((head + data).ljust(251, b"\0")))


def unpack(message) -> tuple:
    """(sequence, opcode, size, burst complete, offset, data) of an answer."""
    payload = bytes(message.payload)
    sequence, _, opcode, size, _, complete, _, offset = struct.unpack_from("<HBBBBBBI", payload)
    return sequence, opcode, size, complete, offset, payload[12 : 12 + size]


def read_in_bursts(bench: Bench, station: Station, name: bytes) -> bytes:
    """A whole file."""
    station.tell(ftp(dialect.MAV_FTP_OPCODE_OPENFILERO, data=name))
    (opened,) = station.answers("FILE_TRANSFER_PROTOCOL", bench.step())
    (length,) = struct.unpack("<I", unpack(opened)[5])
    station.tell(ftp(dialect.MAV_FTP_OPCODE_BURSTREADFILE, size=239))
    content = b""
    for _ in range(600):  # the link has 2500 bytes a second for it
        for answer in station.answers("FILE_TRANSFER_PROTOCOL", bench.step()):
            _, opcode, _, complete, offset, data = unpack(answer)
            assert (opcode, offset) == (dialect.MAV_FTP_OPCODE_ACK, len(content))
            content += data
            if complete:
                assert len(content) == length
                return content
    raise AssertionError("the burst does not end")


def test_metadata_is_found_from_its_message_and_read_over_mavftp():
    bench = Bench()
    station = Station(bench, 255)
    (where,) = of_kind("COMPONENT_METADATA", bench.ask(command_long(REQUEST, 397.0)))
    general = read_in_bursts(bench, station, where.uri.removeprefix("mftp://").encode())
    assert zlib.crc32(general, 0xFFFFFFFF) ^ 0xFFFFFFFF == where.file_crc
    (entry,) = json.loads(general)["metadataTypes"]
    parameters = read_in_bursts(bench, station, entry["uri"].removeprefix("mftp:///").encode())
    assert zlib.crc32(parameters, 0xFFFFFFFF) ^ 0xFFFFFFFF == entry["fileCrc"]
    listed = json.loads(parameters)["parameters"]
    assert [(p["name"], p["shortDesc"]) for p in listed] == [(p.name, p.text) for p in load_parameters().values()]

    station.tell(ftp(dialect.MAV_FTP_OPCODE_READFILE, offset=100, size=50))  # what a burst lost is read again
    (again,) = station.answers("FILE_TRANSFER_PROTOCOL", bench.run(0.5))
    assert unpack(again) == (8, dialect.MAV_FTP_OPCODE_ACK, 50, 0, 100, parameters[100:150])


def test_two_stations_read_two_files_at_once():
    bench = Bench()
    stations = [Station(bench, 255), Station(bench, 254)]
    for station, name in zip(stations, (b"/parameters.json", b"general.json"), strict=True):
        station.tell(ftp(dialect.MAV_FTP_OPCODE_OPENFILERO, data=name))
        bench.step()
    for station in stations:
        station.tell(ftp(dialect.MAV_FTP_OPCODE_BURSTREADFILE, size=80))
    messages = bench.run(14.0)
    for station, name in zip(stations, ("parameters", "general"), strict=True):
        pieces = [unpack(answer)[5] for answer in station.answers("FILE_TRANSFER_PROTOCOL", messages)]
        assert set(json.loads(b"".join(pieces))) >= ({"parameters"} if name == "parameters" else {"metadataTypes"})


@pytest.mark.parametrize(("request_", "error"), [
    (ftp(dialect.MAV_FTP_OPCODE_OPENFILERO, data=b"@PARAM/param.pck?withdefaults=1"), dialect.MAV_FTP_ERR_FILENOTFOUND),
    (ftp(dialect.MAV_FTP_OPCODE_OPENFILERO, data=b"../firmware_py/main.py"), dialect.MAV_FTP_ERR_FILENOTFOUND),
    (ftp(dialect.MAV_FTP_OPCODE_LISTDIRECTORY, data=b"/"), dialect.MAV_FTP_ERR_UNKNOWNCOMMAND),
    (ftp(dialect.MAV_FTP_OPCODE_WRITEFILE, data=b"x"), dialect.MAV_FTP_ERR_UNKNOWNCOMMAND),
    (ftp(dialect.MAV_FTP_OPCODE_READFILE, size=10), dialect.MAV_FTP_ERR_INVALIDSESSION),
    (ftp(99), dialect.MAV_FTP_ERR_UNKNOWNCOMMAND),
])
def test_other_files_and_opcodes_are_refused_in_the_next_tick(request_, error):
    bench = Bench()
    (answer,) = of_kind("FILE_TRANSFER_PROTOCOL", bench.ask(request_))
    assert unpack(answer)[:3] == (8, dialect.MAV_FTP_OPCODE_NAK, 1)
    assert unpack(answer)[5] == bytes([error])


def test_every_copy_of_a_command_is_acknowledged_and_does_nothing_twice():
    bench = Bench(hovering())
    bench.step()
    others = Station(bench, 240, 1)
    bench.tell(*[command_long(ARM, 1.0)] * 3)
    others.tell(command_long(ARM, 1.0))
    messages = bench.run(1.0)
    acks = [(ack.target_system, ack.result) for ack in of_kind("COMMAND_ACK", messages)]
    assert sorted(acks) == [(240, ACCEPTED), *[(255, ACCEPTED)] * 3]
    assert bench.texts().count("armed: PARK") == 1


def test_a_listing_is_not_disturbed_by_another_station():
    bench = Bench()
    first, second = Station(bench, 255), Station(bench, 254)
    first.tell(dialect.MAVLink_param_request_list_message(1, 1))
    bench.run(0.2)
    second.tell(dialect.MAVLink_param_request_list_message(1, 1), set_parameter("INNER_P", 2.5))
    in_time = {m.param_id for m in of_kind("PARAM_VALUE", [m for _, m in bench.heard] + bench.run(0.3))}
    assert in_time == set(NAMES)
    assert {m.param_id for m in of_kind("PARAM_VALUE", bench.run(0.4))} | in_time == set(NAMES)
