"""`kite-sitl list` and `keys`."""

import json
from argparse import Namespace

from sim_bridge.equipment.error_settings import QUANTITIES, ErrorSettings
from sim_bridge.scenario.keys import KEYS
from sim_bridge.scenario.scenario import load_scenario, scenario_names
from sim_bridge.settings import Key, own_keys


def list_scenarios(options: Namespace) -> int:
    """`kite-sitl list`."""
    titles = {name: load_scenario(name).title for name in scenario_names()}
    if options.json:
        print(json.dumps([{"scenario": name, "title": title} for name, title in titles.items()]))
    else:
        for name, title in titles.items():
            print(f"{name:30} {title}")
    return 0


def list_keys(options: Namespace) -> int:
    """`kite-sitl keys`."""
    if options.json:
        print(json.dumps({name: {"default": key.default, "text": key.text, "takes": key.takes()}
                          for name, key in KEYS.items()}))
        return 0
    for name, key in _alike_once().items():
        default = "" if key.default is None else str(key.default).lower() if key.kind is bool else f"{key.default}"
        print(f"{name:32} {default:>16}  {key.text} ({key.takes()})")
    quantities = ", ".join(f"{name} [{unit}]" if unit else name for name, (_, unit) in QUANTITIES.items())
    print(f"\nQUANTITY is one of {quantities}; noise, wander and bias are in this unit.")
    return 0


def _alike_once() -> dict[str, Key]:
    """All keys; but those of errors, which all quantities have alike, once for all of them."""
    shown = {}
    for name, key in KEYS.items():
        _, _, field = name.rpartition(".")
        if name.startswith("errors."):
            shown[f"errors.QUANTITY.{field}"] = own_keys(ErrorSettings)[field]
        else:
            shown[name] = key
    return shown
