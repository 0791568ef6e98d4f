"""kite-sitl helps along: what a key takes, what was meant, what would be faster."""

import json
import re
import subprocess
import sys

import pytest

from sim_bridge.cli.main import main
from sim_bridge.equipment.error_settings import QUANTITIES
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.plant_choice import slowness
from sim_bridge.scenario.keys import KEYS
from sim_bridge.scenario.plant_names import PLANTS
from sim_bridge.scenario.scenario import load_scenario


def test_keys_tell_what_a_scenario_takes(capsys):
    """Each bound that is shown is taken, and a step beyond it is refused with the same two numbers."""
    assert main(["keys", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert main(["keys"]) == 0
    lines = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line}
    assert lines["plant.kind"].endswith(f"({', '.join(PLANTS)})") and lines["sensors.course"].endswith("(true, false)")
    assert all(quantity in lines["QUANTITY"] for quantity in QUANTITIES)
    for name, key in KEYS.items():
        shown = re.sub(r"^errors\.\w+", "errors.QUANTITY", name)  # once for all quantities
        assert lines[shown].endswith(f"({told[name]['takes']})")
        if key.kind not in (int, float) or key.greatest == float("inf"):
            continue
        least, greatest = key.kind(key.least), key.kind(key.greatest)
        for good in (least, greatest):
            load_scenario("small-kite").set(name, good, "here")
        for bad in (least - 1, greatest * 2 + 1):
            with pytest.raises(ScenarioError, match=told[name]["takes"].replace("+", r"\+")):
                load_scenario("small-kite").set(name, bad, "here")


@pytest.mark.parametrize(("arguments", "says"), [
    ("rn paper-delay", "no verb 'rn'; did you mean run?"),
    ("list --jsn", "--jsn is not an option; did you mean --json?"),
    ("run paper-delay --duratoin 4", "--duratoin is not an option; did you mean --duration?"),
    ("run paper-delay --runtime pico", "'pico' is not one of inproc, cpython, micropython"),
    ("run", "the following arguments are required: NAME"),
    ("run small-kite --set plant.kind=x", "plant.kind is one of turning-rate, one-point, four-point, vortex-lattice"),
    ("run small-kite --set plant.kind=fourpoint", "did you mean four-point?"),
    ("run small-kite --set wind.gusts=dreiden", "one of first-order, dryden, von-karman; did you mean dryden?"),
])
def test_a_mistake_is_answered_in_one_line_with_what_may_have_been_meant(arguments, says, capsys):
    try:
        code = main(arguments.split())
    except SystemExit as leaving:  # argparse's own
        code = leaving.code
    out, error = capsys.readouterr()
    assert code == 2 and out == "" and says in error and error.count("\n") == 1 and error.startswith("kite-sitl")


def test_ground_stations_get_a_firmware_with_a_wire(capsys):
    settings = ["--set", "ground.send_to=127.0.0.1:9", "--set", "ground.listen=127.0.0.1:0"]
    assert main(["run", "paper-delay-tuned", "--duration", "1", "--ground", *settings]) == 0
    assert ", cpython, seed 1" in capsys.readouterr().out
    assert main(["run", "paper-delay-tuned", "--duration", "1", "--ground", "--runtime", "inproc", *settings]) == 2


def test_a_plant_that_flies_uncompiled_says_so_in_one_line():
    assert slowness("turning-rate") is None
    no_numba = "import sys; sys.modules['numba'] = None; from sim_bridge.cli.main import main; sys.exit(main())"
    for script, environment, says in (
        (no_numba, {}, "pip install 'kitepilot[fast]' makes it about 50 times faster"),
        (no_numba.replace("sys.modules['numba'] = None; ", ""), {"NUMBA_DISABLE_JIT": "1"}, "NUMBA_DISABLE_JIT is set"),
    ):
        done = subprocess.run([sys.executable, "-c", script, "run", "small-kite-one-point", "--duration", "0.2"],
                              env={"PATH": "", **environment}, capture_output=True, text=True, check=True)
        assert says in done.stderr and done.stderr.count("\n") == 1
