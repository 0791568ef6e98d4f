"""From power-on to the loop on simulated boards: settings, a way out, servo, watchdog, a reset in flight."""

import importlib
import sys
from types import ModuleType, SimpleNamespace

import pytest
from simulated_hardware import SimulatedClock, SimulatedMachine, encoder_bus

import firmware_py.boards
from firmware_py import startup
from firmware_py.boards.retained_layout import FLIGHT, SIZE
from firmware_py.drivers.as5600 import STEPS
from firmware_py.mavlink.decoder import Decoder
from firmware_py.mavlink.encoder import Encoder
from firmware_py.mavlink.generated_messages import COMMAND_LONG, HEARTBEAT, KITE_SENSORS, KITE_STATE

CABLE = {"LINK": "uart", "UART": 0, "UART_TX": 0, "UART_RX": 1, "SENSORS": "hil", "SERVO_PIN": 15, "SYSTEM_ID": 7,
         "MAINTENANCE_PIN": 22}
WIRELESS = {"LINK": "wifi", "WIFI_SSID": "kite", "WIFI_KEY": "", "GROUND": "127.0.0.1:9", "SENSORS": "hil"}
LINE = CABLE | {"SENSORS": "line-angles", "AZIMUTH": {"i2c": 0, "sda": 4, "scl": 5},
                "ELEVATION": {"i2c": 1, "sda": 6, "scl": 7}}
WATCHDOG_RAN = {0x4005801C: 0x6AB73121}
NOBODYS = {0x4005800C: 0}  # the register that remembers where the block is, at power-on
_BY_HAND = Encoder(255, 190)


class Bench:
    """A board on a bench: its hardware, its memory, its clock, and a pilot who presses Ctrl-C at `stop_s`."""

    def __init__(self, monkeypatch, tmp_path, platform="rp2", lacks=()):
        self._monkeypatch = monkeypatch
        self.machine = SimulatedMachine()
        self.machine.mem32 |= NOBODYS
        self.clock = SimulatedClock(look_us=7)
        self.clock.on_sleep = self._on_sleep
        self._rtc_memory = b""
        self._blocks = {}  # in a Pico's heap, by address
        self.stop_s = 10.0
        self.plan = []
        rtc = SimpleNamespace(memory=self._memory)
        self.machine.RTC = lambda: rtc
        uctypes = SimpleNamespace(addressof=self._address_of, bytearray_at=lambda address, size: self._blocks[address])
        monkeypatch.setitem(sys.modules, "machine", self.machine)
        monkeypatch.setitem(sys.modules, "uctypes", uctypes)
        monkeypatch.setitem(sys.modules, "network", SimpleNamespace())
        monkeypatch.setattr(sys.implementation, "_machine", "Raspberry Pi Pico with RP2040", raising=False)
        for name in lacks:
            monkeypatch.setitem(sys.modules, name, None)  # importing it raises ImportError
        self.platform = platform
        self.module = self._load()
        self.startup = importlib.import_module("firmware_py.startup")
        monkeypatch.setattr(self.startup, "time", self.clock)
        monkeypatch.setattr(self.module.machine_board, "STORAGE_FOLDER", str(tmp_path / "flash"))

    def _load(self):
        """The board's module, loaded anew."""
        for name in (f"{self.platform}_board", "rp2_memory"):
            sys.modules.pop(f"firmware_py.boards.{name}", None)
            self._monkeypatch.delattr(firmware_py.boards, name, raising=False)
        module = importlib.import_module(f"firmware_py.boards.{self.platform}_board")
        self._monkeypatch.setattr(module, "time", self.clock)
        return module

    def reset_by_the_watchdog(self):
        """What was loaded is gone; what is retained is not."""
        self.machine.cause = self.machine.WDT_RESET
        self.machine.mem32.update(WATCHDOG_RAN)
        self.module = self._load()

    def flight(self):
        """The part of what is retained that a reset would resume."""
        block = self.module.rp2_memory.BLOCK if self.platform == "rp2" else self._rtc_memory
        return bytes(block[FLIGHT:])

    def power_on(self, entries):
        board = ModuleType("board")
        for name, value in entries.items():
            setattr(board, name, value)
        self._monkeypatch.setitem(sys.modules, "board", board)
        self.machine.made.clear()
        self.startup.start(self.platform)

    def _on_sleep(self, now):
        while self.plan and now >= self.plan[0][0] * 1e6:
            self.plan.pop(0)[1]()
        if now >= self.stop_s * 1e6:
            self.stop_s = 1e9
            raise KeyboardInterrupt

    def _address_of(self, block):
        if len(block) != SIZE:
            return 0x20008000  # what keeps the block off the heap's bottom
        address = 0x20018000 + 1024 * len(self._blocks)
        self._blocks[address] = block
        return address

    def _memory(self, data=None):
        if data is not None:
            self._rtc_memory = bytes(data)
        return self._rtc_memory

    def frames(self):
        """(message, values, system) of all frames that left by the UART."""
        decoder, found = Decoder(1 << 20), []
        decoder.feed(self.machine.made["UART"][0].outgoing)
        while decoder.next_frame():
            found.append((decoder.message, decoder.values, decoder.system))
        return found

    def send(self, message, values):
        buffer = bytearray(300)
        size = _BY_HAND.encode(buffer, 0, message, values)
        self.machine.made["UART"][0].incoming += buffer[:size]

    def arm(self):
        self.send(COMMAND_LONG, (1.0, 0, 0, 0, 0, 0, 0, 400, 7, 1, 0))


@pytest.fixture(params=["rp2", "esp32"])
def bench(request, monkeypatch, tmp_path):
    return Bench(monkeypatch, tmp_path, request.param)


@pytest.fixture
def pico(monkeypatch, tmp_path):
    return Bench(monkeypatch, tmp_path)


def wired(bench, entries):
    """The same settings on either board: the ESP32's first UART is its console."""
    return entries | {"UART": 1} if bench.platform == "esp32" else entries


def test_it_boots_beats_its_heart_and_gives_the_console_back_on_ctrl_c(bench, capsys):
    bench.power_on(wired(bench, CABLE))
    made = bench.machine.made
    beats = [frame for frame in bench.frames() if frame[0] == HEARTBEAT]
    assert len(beats) == 8 and {frame[2] for frame in beats} == {7}  # of ten seconds the first two are the way out
    said = capsys.readouterr().out.splitlines()
    assert said == ["kitepilot: flying in 2 s; Ctrl-C stops", "kitepilot: running as system 7, link uart, sensors hil",
                    "kitepilot: stopped by Ctrl-C; machine.reset() starts again"]
    watchdog = made["WDT"][0]
    assert watchdog.timeout == 1000 and watchdog.fed == pytest.approx(400, abs=2)
    timer = made["Timer"][0]
    assert timer.period < watchdog.timeout / 4
    fed = watchdog.fed
    timer.call(timer)
    assert watchdog.fed == fed + 1  # the console stays
    assert made["PWM"][0].pulses == [1500]
    assert not any(bench.flight())


def test_the_uart_is_given_room_and_never_waits(pico):
    pico.power_on(CABLE)
    settings = pico.machine.made["UART"][0].settings
    assert (settings["baudrate"], settings["timeout"]) == (115200, 0)
    assert settings["txbuf"] >= 2048 and settings["rxbuf"] >= 1024


def test_a_grounded_maintenance_pin_keeps_it_from_flying(bench, capsys):
    bench.machine.grounded = {22}
    bench.machine.cause = bench.machine.WDT_RESET  # even then
    bench.machine.mem32.update(WATCHDOG_RAN)
    bench.power_on(wired(bench, CABLE))
    assert "WDT" not in bench.machine.made
    assert "stopped by the maintenance pin" in capsys.readouterr().out


def test_ctrl_c_in_the_first_two_seconds_comes_before_the_watchdog(bench, capsys):
    bench.stop_s = 1.5
    bench.power_on(wired(bench, CABLE))
    assert "WDT" not in bench.machine.made and bench.clock.now < 1_600_000
    assert "stopped by Ctrl-C" in capsys.readouterr().out


@pytest.mark.parametrize(("entries", "says"), [
    ({"LINK": "uart"}, ["UART is missing", "UART_TX is missing", "UART_RX is missing", "SENSORS is missing"]),
    (CABLE | {"SYSTEM_ID": 0}, ["SYSTEM_ID = 0 is wrong: write a whole number from 1 to 250"])])
def test_wrong_settings_are_told_line_by_line_and_blinked(pico, capsys, entries, says):
    pico.power_on(entries)
    said = capsys.readouterr().out.splitlines()
    assert len(said) == len(says)
    for line, expected in zip(said, says, strict=True):
        assert line.startswith(f"kitepilot: board.py: {expected}")
    timer, pin = pico.machine.made["Timer"][0], pico.machine.made["Pin"][0]
    for _ in range(40):
        pico.clock.now += timer.period * 1000
        timer.call(timer)
    assert pin.number == "LED" and pin.levels[:5] == [1, 0, 1, 0, 1]
    assert not {"WDT", "UART"} & set(pico.machine.made)


def test_a_missing_and_a_broken_board_py_are_told_in_one_line(pico, capsys, monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(tmp_path)
    for text, says in ((None, "not found"), ("LINK = \n", "not Python"), ("import machinee\n", "machinee"),
                       ("1 / 0\n", "ZeroDivisionError")):
        sys.modules.pop("board", None)
        importlib.invalidate_caches()
        if text is not None:
            (tmp_path / "board.py").write_text(text + "#" * len(text))
        startup.start("rp2")
        said = capsys.readouterr().out.splitlines()
        assert len(said) == 1 and says in said[0], (text, said)
        assert pico.machine.made.pop("Timer")
        (tmp_path / "board.py").unlink(missing_ok=True)
    sys.modules.pop("board", None)


def test_what_the_hardware_refuses_is_told_and_blinked(pico, capsys):
    def refuse(number, **settings):
        raise ValueError("bad TX pin")

    pico.machine.UART = refuse
    pico.power_on(CABLE)
    assert "rejected by the hardware: bad TX pin" in capsys.readouterr().out
    assert pico.machine.made["Timer"] and pico.machine.made["PWM"][0].pulses == [1500]


def test_a_pico_without_wi_fi_says_so(pico, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "network", None)  # importing it raises ImportError
    pico.power_on(WIRELESS)
    assert 'this board has no Wi-Fi, write "uart"' in capsys.readouterr().out


class Radio:
    """A network interface that never finds its network: `network.WLAN`."""

    PM_NONE = 0

    def __call__(self, interface):
        return self

    def active(self, on):
        pass

    def config(self, **settings):
        pass

    def connect(self, *credentials):
        pass

    def isconnected(self):
        return False

    def status(self):
        return 0


LACKS = {  # modules of MicroPython 1.28's builds that a board does not have
    "Pico": ("rp2", ["socket", "network", "ssl", "esp", "esp32", "espnow", "bluetooth"]),
    "Pico W": ("rp2", ["esp", "esp32", "espnow"]),
    "ESP32": ("esp32", ["rp2"]),
}


@pytest.mark.parametrize("board", LACKS)
@pytest.mark.parametrize("link", ["uart", "wifi"])
def test_each_board_loads_nothing_that_it_does_not_have(monkeypatch, tmp_path, capsys, board, link):
    """Every module of the firmware is loaded anew, with what the board lacks taken away, and the board flies."""
    platform, lacks = LACKS[board]
    for name in [name for name in sys.modules if name.startswith("firmware_py")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delattr(firmware_py.boards, f"{platform}_board", raising=False)
    bench = Bench(monkeypatch, tmp_path, platform, lacks)
    if "network" not in lacks:
        radio = Radio()
        sys.modules["network"].__dict__.update(WLAN=radio, STA_IF=0)
    if link == "wifi":
        bench.stop_s = 1.5  # the network is real: everything is loaded by then, and nothing waits for it
    bench.power_on(wired(bench, CABLE) if link == "uart" else WIRELESS)
    said = capsys.readouterr().out
    if link == "uart":
        assert len([frame for frame in bench.frames() if frame[0] == HEARTBEAT]) == 8
    elif "network" in lacks:
        assert 'this board has no Wi-Fi, write "uart"' in said
    else:
        assert "flying in 2 s" in said and "stopped by Ctrl-C" in said


def samples(bench, seconds):
    """A kite that hovers, as the bridge would say it."""
    for tick in range(int(seconds * 50)):
        time_s = 2.0 + tick / 50
        values = (tick * 20_000, 0.0, 0.7, 100.0, 0.3, 0.3, 18.0, 100.0, 0.0, 255)
        bench.plan.append((time_s, lambda values=values: bench.send(KITE_SENSORS, values)))


def test_armed_it_steers_and_on_ctrl_c_the_servo_is_neutral_and_nothing_resumes(pico):
    samples(pico, 8)
    pico.plan.append((5.0, pico.arm))
    pico.plan.sort(key=lambda entry: entry[0])
    pico.power_on(CABLE)
    pulses = pico.machine.made["PWM"][0].pulses
    assert pulses[0] == 1500 and pulses[-1] == 1500 and len(set(pulses)) > 1
    assert min(pulses) >= 1000 and max(pulses) <= 2000
    assert not any(pico.flight())


def test_after_a_reset_by_the_watchdog_in_flight_it_flies_on_at_once(pico, monkeypatch):
    samples(pico, 8)
    pico.plan.append((5.0, pico.arm))
    pico.plan.sort(key=lambda entry: entry[0])
    hung = []
    pico.plan.append((9.0, lambda: hung.append(pico.flight())))
    pico.power_on(CABLE)
    pico.module.rp2_memory.BLOCK[FLIGHT:] = hung[0]
    pico.reset_by_the_watchdog()
    began, pico.stop_s, pico.plan = pico.clock.now, pico.clock.now / 1e6 + 1.0, []
    pico.power_on(CABLE)
    beats = [values for message, values, _ in pico.frames() if message == HEARTBEAT]
    assert beats and beats[0][0] == 2 and beats[0][3] & 128  # PARK, armed
    assert pico.clock.now - began < 1_100_000


def test_machine_reset_does_not_pass_for_the_watchdog(pico):
    pico.machine.cause = pico.machine.WDT_RESET
    pico.machine.mem32[0x4005801C] = 0
    assert pico.module.reset_cause() == "soft"
    pico.machine.mem32.update(WATCHDOG_RAN)
    assert pico.module.reset_cause() == "watchdog"
    pico.machine.cause = pico.machine.PWRON_RESET
    assert pico.module.reset_cause() == "power-on"


def test_a_loop_that_fails_leaves_the_servo_neutral_and_the_board_to_the_watchdog(pico, capsys, monkeypatch):
    def fail(autopilot, board):
        board.actuator.write(1.0, True)
        raise RuntimeError("a mistake of ours")

    monkeypatch.setattr(startup, "run_real_time", fail)
    pico.power_on(CABLE)
    assert pico.machine.made["PWM"][0].pulses == [1500, 2000, 1500]
    assert "Timer" not in pico.machine.made  # nobody feeds it
    assert "a mistake of ours" in (said := capsys.readouterr().out) and "the watchdog resets the board" in said


def test_line_angles_reach_the_estimator(pico):
    (azimuth, pico.machine.buses[0]), (elevation, pico.machine.buses[1]) = encoder_bus(100), encoder_bus(455)
    pico.plan = [(4.0, lambda: setattr(azimuth, "raw", 110)), (5.0, lambda: setattr(elevation, "raw", 460))]
    pico.power_on(LINE)
    states = [values for message, values, _ in pico.frames() if message == KITE_STATE]
    step = 6.283185 / STEPS
    assert states[0][2:4] == (pytest.approx(100 * step), pytest.approx(455 * step))
    assert states[-1][2:4] == (pytest.approx(110 * step), pytest.approx(460 * step))



@pytest.mark.parametrize(("entries", "mhz", "volts"), [
    ({}, 200, 1.15), ({"CPU_MHZ": 133}, 133, 1.10), ({"CPU_MHZ": 150}, 150, 1.15)])
def test_a_picos_clock_is_raised_after_its_voltage(pico, entries, mhz, volts):
    """RP2040 datasheet: 1.10 V is good for 133 MHz, 1.15 V for 200; VSEL counts 50 mV from 0.85 V at 6 on."""
    pico.machine.mem32[0x40064000] = 0xB1  # 1.10 V, as after a reset
    at_the_change = []
    change = pico.machine.freq

    def freq(hz=None):
        if hz is not None:
            at_the_change.append(0.85 + 0.05 * ((pico.machine.mem32[0x40064000] >> 4 & 15) - 6))
        return change(hz)

    pico.machine.freq = freq
    pico.stop_s = 0.1
    pico.power_on(CABLE | entries)
    assert pico.machine.clock_hz == mhz * 1_000_000
    assert at_the_change == [pytest.approx(volts)]
    assert pico.machine.mem32[0x40064000] & 0xF == 1
