"""What is special about running a command of the docs; all others are run as they are shown, to their end.

Keys are commands as shown. One that is shown nowhere any more is an error, so that no exception outlives its command.
"""

# Programs that no command of the docs is run with here, and why.
PROGRAMS_NOT_RUN = {
    "pip": "needs a package index; make's set-up installs the same, on every fresh clone that CI takes",
    "mpremote": "needs a board",
    "mavproxy.py": "1 GB with what it needs, not among the development tools",
    "wireshark": "comes with the system's package manager",
    "tshark": "comes with the system's package manager (tests/protocol runs it where it is installed)",
}
# Names in running text of what does nothing without arguments. Shown anywhere or nowhere.
MENTIONS = ("make flash", *(f"kite-sitl {verb}" for verb in (
    "run", "hil", "rerun", "sweep", "shadow", "identify", "design", "flash", "board-image")), *(
    f"kite-ground {verb}" for verb in ("param", "param load", "param set", "record", "plot", "log export", "replay")))
NOT_RUN = {
    "make test": "runs this very test",
    "make mutants": "most of an hour",
    "kite-sitl bench --before DIR": "needs another checkout (test_bench.py has one)",
    "make compiled": "a minute; CI runs it before the tests, which fly what it builds (test_native_loop.py)",
    "make emulated-pico": "needs MicroPython's image, and a quarter of an hour",
    "make emulated-pico PICO_IMAGE=RPI_PICO-v1.28.0.uf2": "needs that image, and a quarter of an hour",
    "make lint type test": "runs this very test",
    "kite-sitl hil --link serial:/dev/ttyUSB0:115200 small-kite --status": "needs a board (test_hil.py has one)",
    "git clone --depth 1 --branch v1.28.0 https://github.com/micropython/micropython": "needs a network",
    "make -C micropython/ports/unix BUILD=build-f32 CFLAGS_EXTRA=-DMICROPY_FLOAT_IMPL=MICROPY_FLOAT_IMPL_FLOAT "
    "FROZEN_MANIFEST= MICROPY_PY_BTREE=0 MICROPY_PY_SSL=0 MICROPY_PY_FFI=0": "needs the clone",
    "kite-sitl run small-kite --runtime micropython --interpreter micropython/ports/unix/build-f32/micropython":
        "needs that build; test_interpreter.py flies with others",
    "MICROPYTHON_F32=micropython/ports/unix/build-f32/micropython pytest tests/sim_bridge/test_single_precision.py":
        "needs that build; CI runs the same with one, where it has one",
    "kite-sitl identify ours.csv --columns ours.toml": "the reader's own flight; test_flight_record.py reads such ones",
    "kite-sitl shadow ours.csv --columns ours.toml": "the reader's own flight; test_shadow.py has another team's",
    "kite-ground replay DIR/ground.tlog": "no ground station was there in this flight",
    "kite-ground --link serial:/dev/ttyUSB0:57600 --link udpin:0.0.0.0:14550 monitor": "needs a radio",
}
# Only under `make soak`: they need minutes, or a kite in real time for longer than CI has.
SOAK = {
    "make validate": "minutes",
    "kite-ground tune --identify": "40 s of eights, and as much again to see what became of them",
    "kite-ground tune --step +10%": "four rounds of the eight",
    "python docs/examples/fly_and_tune.py": "five rounds of the eight",
}
PYTHON_IS_SOAK = "it measures for 20 s, and tries a step over four rounds of the eight"

# Options that are appended, and why the command is still the one that is shown. {port} is the ground station's.
APPENDED = {
    "make flash PORT=/dev/ttyACM0": ("DRY_RUN=1", "no board"),
    "make flash PORT=/dev/ttyACM0 BOARD='--link wifi --ssid NAME --key KEY --ground 192.168.1.10:14555'":
        ("DRY_RUN=1", "no board"),
    "kite-sitl run small-kite --speed 1 --ground --forever":
        ("--set ground.send_to=127.0.0.1:{port} --set ground.listen=127.0.0.1:0", "ports of its own"),
    "python docs/examples/fly_and_tune.py": ("udpin:127.0.0.1:{port}", "a port of its own"),
    "kite-ground record flight.tlog": ("--duration 2", "ends by itself"),
    "kite-ground replay flight.tlog": ("--to udpout:127.0.0.1:{port} --speed 60", "a port of its own, and sooner"),
    "kite-ground replay flight.tlog --speed 4 --from 60 --to-time 120 --loop":
        ("--to udpout:127.0.0.1:{port} --speed 60", "a port of its own, and sooner"),
}
# The same, but not under `make soak`: there, all of it is flown.
SHORTER = {
    "kite-ground tune": ("--seconds 4", "the simulated kite flies at 5 times real time here, so these are 20 s"),
    "kite-sitl sweep paper-delay-tuned --over param.INNER_P=1:10:20 --over link.control.delay_s=0.05:0.5:10 --plot":
        ("--duration 11", "all 200 flights, but short"),
    "kite-sitl bench": ("--duration 10", "fewer ticks"),
    "kite-sitl bench --runtime micropython": ("--duration 10", "fewer ticks"),
}
ANSWERS = dict.fromkeys((
    "kite-ground tune", "kite-ground tune --identify", "kite-ground tune --step +10%", "kite-ground tune --delay 0.2",
    "kite-ground param revert", "kite-ground param revert INNER_P", "kite-ground param load before.param",
), "y\n")
# These have no end: Ctrl-C, once they have said this.
ENDLESS = {
    "kite-ground monitor": "mode=TRACK",
    "kite-ground param watch 'INNER_*'": "INNER_P",
    "kite-ground replay flight.tlog --speed 4 --from 60 --to-time 120 --loop": "replaying",
}
# A simulated kite that flies until the end of its page, there when it has said this.
KEEPS_FLYING = {"kite-sitl run small-kite --speed 1 --ground --forever": "ground stations"}
# What the reader has done, or has, beforehand: in shell.
BEFORE = {
    "kite-sitl run mine.toml": "cp sim_bridge/scenario/sets/small-kite.toml mine.toml",
    "kite-ground replay flight.tlog": "cp long.tlog flight.tlog",  # as recorded, but for longer
    'kite-ground completion zsh > "${fpath[1]}/_kite-ground"': 'fpath=(. "$HOME")',
    "kite-ground completion fish > ~/.config/fish/completions/kite-ground.fish": "mkdir -p ~/.config/fish/completions",
    "mavgen.py --lang=WLua --wire-protocol=2.0 --output=kite protocol/kite.xml":
        "cp {dialects}/common.xml {dialects}/standard.xml {dialects}/minimal.xml protocol/",
}
PLACEHOLDERS = {"FILE": "tests/data/flight/20191008_0010.csv.gz", "NAME": "one-point", "KEY": "not-a-secret"}
