"""/board.py: what may stand there, and the one line that each mistake is answered with."""

import pytest

from firmware_py.boards.settings import check_settings

CABLE = {"LINK": "uart", "UART": 0, "UART_TX": 0, "UART_RX": 1, "SENSORS": "hil"}
RADIO = {"LINK": "wifi", "WIFI_SSID": "kite", "WIFI_KEY": "12345678", "GROUND": "192.168.1.10:14550", "SENSORS": "hil"}
LINE = CABLE | {
    "SENSORS": "line-angles", "SERVO_PIN": 15,
    "AZIMUTH": {"i2c": 0, "sda": 4, "scl": 5, "zero": 17, "direction": -1},
    "ELEVATION": {"i2c": 1, "sda": 6, "scl": 7},
}


def problems(entries, platform="rp2"):
    return check_settings(entries, platform)[1]


def without(entries, name):
    return {key: value for key, value in entries.items() if key != name}


def test_good_settings_are_taken_over_and_the_rest_is_at_its_default():
    settings, wrong = check_settings(CABLE, "rp2")
    assert not wrong
    assert (settings.link, settings.uart, settings.tx, settings.rx, settings.baud) == ("uart", 0, 0, 1, 115200)
    assert (settings.system_id, settings.sensors, settings.servo_pin, settings.light_pin) == (1, "hil", None, "LED")
    assert (settings.servo_us, settings.maintenance_pin) == ((1000, 1500, 2000), None)
    settings, wrong = check_settings(RADIO, "rp2")
    assert not wrong
    assert (settings.ssid, settings.key, settings.ground) == ("kite", "12345678", ("192.168.1.10", 14550))
    settings, wrong = check_settings(LINE, "rp2")
    assert not wrong
    assert settings.azimuth == LINE["AZIMUTH"]
    assert settings.elevation == {"i2c": 1, "sda": 6, "scl": 7, "zero": 0, "direction": 1}


def test_an_open_network_a_dark_board_and_a_servo_turned_round():
    assert not problems(RADIO | {"WIFI_KEY": ""})
    settings, wrong = check_settings(CABLE | {"LIGHT_PIN": None, "SERVO_MINUS_US": 2000, "SERVO_PLUS_US": 1000}, "rp2")
    assert not wrong and settings.light_pin is None and settings.servo_us == (2000, 1500, 1000)
    assert not problems(RADIO | {"machine": object(), "_x": 1, "lower": 2})  # the user's own names


MISSING = [(CABLE, name) for name in ("LINK", "UART", "UART_TX", "UART_RX", "SENSORS")]
MISSING += [(RADIO, name) for name in ("WIFI_SSID", "WIFI_KEY", "GROUND")]
MISSING += [(LINE, name) for name in ("AZIMUTH", "ELEVATION", "SERVO_PIN")]


@pytest.mark.parametrize(("entries", "name"), MISSING, ids=[name for _, name in MISSING])
def test_a_missing_entry_is_named_in_one_line(entries, name):
    said = problems(without(entries, name))
    assert len(said) == 1 and said[0].startswith(f"{name} is missing") and "\n" not in said[0]


WRONG = {
    "LINK": ["WIFI", "", None, 1], "UART": [-1, 2, "0", 1.0, True, None], "UART_TX": [-1, 30, "GP0", None, 0.5],
    "UART_BAUD": [9599, 3000001, "115200", None], "SYSTEM_ID": [0, 251, "1", 1.5, True], "SENSORS": ["HIL", None],
    "SERVO_PIN": [-1, 30, "15"], "SERVO_MINUS_US": [499, 2501, 1.0, None], "SERVO_PLUS_US": [499, 2501, "2000"],
    "SERVO_NEUTRAL_US": [1000, 2000, 999, 2001], "LIGHT_PIN": [-1, 30, "led"], "MAINTENANCE_PIN": [-1, 30, True],
}
WRONG_RADIO = {
    "WIFI_SSID": ["", "x" * 33, 5, None], "WIFI_KEY": ["1234567", "x" * 64, None, 12345678],
    "GROUND": ["192.168.1.10", "192.168.1:14550", "kite.local:14550", "1.2.3.256:1", "1.2.3.4:0", "1.2.3.4:65536",
               "1.2.3.4:x", "1.2.3.4:5:6", "", None, 14550],
}
RIGHT = {
    "UART_TX": [2, 29], "UART_BAUD": [9600, 3000000], "SYSTEM_ID": [1, 250], "SERVO_PIN": [None, 2, 29],
    "SERVO_MINUS_US": [500, 1499], "SERVO_PLUS_US": [1501, 2500], "SERVO_NEUTRAL_US": [1001, 1999],
    "LIGHT_PIN": ["LED", 2, 29], "MAINTENANCE_PIN": [2, 29],
}
CASES = [(CABLE, name, value) for name, values in WRONG.items() for value in values]
CASES += [(RADIO, name, value) for name, values in WRONG_RADIO.items() for value in values]


@pytest.mark.parametrize(("entries", "name", "value"), CASES)
def test_a_wrong_entry_is_named_in_one_line_that_says_what_would_be_right(entries, name, value):
    said = problems(entries | {name: value})
    assert len(said) == 1 and name in said[0] and "\n" not in said[0] and len(said[0]) < 160
    assert "write" in said[0] or "between" in said[0]


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in RIGHT.items() for value in values])
def test_the_last_good_value_on_each_side_is_taken(name, value):
    assert problems(CABLE | {name: value}) == []


def test_the_longest_and_the_shortest_names_and_keys():
    for name, values in {"WIFI_SSID": ["x", "x" * 32], "WIFI_KEY": ["", "x" * 8, "x" * 63],
                         "GROUND": ["0.0.0.0:1", "255.255.255.255:65535"]}.items():
        for value in values:
            assert problems(RADIO | {name: value}) == []


@pytest.mark.parametrize(("change", "says"), [
    ({"zero": 4096}, 'AZIMUTH zero = 4096'), ({"zero": -1}, "0 to 4095"), ({"direction": 0}, "1 or -1"),
    ({"direction": 2}, "1 or -1"), ({"i2c": 2}, "0 to 1"), ({"sda": 6}, "both on pin 6"), ({"i2c": 1}, "one bus"),
    ({"zerro": 3}, '"zerro" is not known')])
def test_an_encoder_s_entries_are_checked_one_by_one(change, says):
    said = problems(LINE | {"AZIMUTH": LINE["AZIMUTH"] | change})
    assert len(said) == 1 and says in said[0]
    assert not problems(LINE | {"AZIMUTH": LINE["AZIMUTH"] | {"zero": 4095, "direction": 1}})
    assert "AZIMUTH = 5 is wrong" in problems(LINE | {"AZIMUTH": 5})[0]


def test_a_pin_has_one_use():
    assert problems(CABLE | {"SERVO_PIN": 1}) == ["UART_RX and SERVO_PIN are both on pin 1: each needs its own"]


def test_a_slip_of_the_pen_is_noticed_and_entries_of_the_other_link_are_not():
    said = problems(CABLE | {"SERVO_PINN": 15})
    assert len(said) == 1 and said[0].startswith("SERVO_PINN is not a setting: there are LINK, ")
    assert not problems(CABLE | without(RADIO, "LINK"))


def test_the_esp32_has_its_own_pins_and_its_console_is_not_a_link():
    entries = CABLE | {"UART": 2, "UART_TX": 17, "UART_RX": 16}
    settings, wrong = check_settings(entries, "esp32")
    assert not wrong and settings.light_pin == 2
    assert "1 to 2" in problems(entries | {"UART": 0}, "esp32")[0]
    assert "LIGHT_PIN" in problems(entries | {"LIGHT_PIN": "LED"}, "esp32")[0]


def test_everything_wrong_is_told_at_once():
    said = problems({})
    assert [line.split()[0] for line in said] == ["LINK", "SENSORS"]
    assert len(problems({"LINK": "uart", "SENSORS": "line-angles"})) == 6
