"""Constants that are put in before the firmware is compiled: what is, what must not be, and that lines stay."""

import ast

from sim_bridge.boards.architectures import ARCHITECTURES
from sim_bridge.boards.constants import is_types_only, put_constants_in
from sim_bridge.boards.image import firmware_files, lay_out, to_compile


def package(**texts: str) -> dict[str, str]:
    """A package `kite` with these modules, its constants put in."""
    sources = {"kite": (True, "")} | {f"kite.{name}": (False, text) for name, text in texts.items()}
    return put_constants_in(sources)


def value(text: str, name: str = "answer") -> object:
    """What a function of a module without imports returns."""
    names: dict[str, object] = {}
    exec(text, names)
    return names[name]()  # type: ignore[operator]


def test_a_number_takes_the_place_of_its_name_here_and_where_it_is_imported():
    put_in = package(
        modes="PARK = 2\n_BIT = 1 << 3\nFLAGS = _BIT | 1\nGAIN = -0.5\n",
        loop="from .modes import FLAGS, GAIN, PARK as parking\n\ndef answer():\n    return parking, FLAGS, 2 - GAIN\n")
    assert "import" not in put_in["kite.loop"]
    assert value(put_in["kite.loop"]) == (2, 9, 2.5)
    assert not put_in["kite.modes"].strip()


def test_what_can_change_or_is_no_number_keeps_its_name():
    text = """\
COUNT = 0
LIMIT = 3
NAME = "kite"
STEP = 0.1 * 3
if NAME:
    LIMIT = 4

def answer():
    global COUNT
    COUNT += 1
    return COUNT, LIMIT, NAME, STEP
"""
    assert package(loop=text)["kite.loop"] == text  # a board may round a product otherwise
    shadowed = "WIDTH = 5\n\ndef answer(WIDTH=7):\n    return WIDTH\n"
    assert value(package(loop=shadowed)["kite.loop"]) == 7


def test_what_is_looked_up_in_a_module_stays_there():
    put_in = package(
        light="LED = 25\nDARK = 0\n",
        board="from . import light\n\ndef pin():\n    return light.LED\n",
        late="def pin():\n    from .light import DARK\n    return DARK\n")
    assert value("def answer():\n    return LED, DARK\n" + put_in["kite.light"]) == (25, 0)


def test_a_traceback_names_the_right_line():
    text = ("from .modes import (\n    PARK,\n    TRACK,\n)\n\nLONG = (\n    1\n    + 2\n)\n\ndef answer():\n"
            "    return LONG + PARK / 0\n")
    put_in = package(modes="PARK = 2\nTRACK = 3\n", loop=text)["kite.loop"]
    assert put_in.count("\n") == text.count("\n")
    function = next(node for node in ast.parse(put_in).body if isinstance(node, ast.FunctionDef))
    assert function.lineno == 11
    assert put_in.splitlines()[11].strip() == "return 3 + 2 / 0"


def test_the_firmware_is_left_without_names_for_its_modes_and_messages():
    texts = to_compile()
    assert set(texts) == set(firmware_files())
    for path, text in texts.items():
        assert text.count("\n") == path.read_text("utf-8").count("\n")
        assert "KITE_MODE_" not in text.replace("KITE_MODE values", ""), path


def test_what_is_for_type_checkers_alone_goes_and_the_constants_with_it():
    kite = "from math import pi\n\nTYPE_CHECKING = False\nif TYPE_CHECKING:\n    from typing import Final\n\n"
    put_in = package(
        kite=kite + "TURN = 2  # type: Final\n", types=kite.replace("Final", "Any"),
        loop="from .kite import TURN\n\nTYPE_CHECKING = False\nif TYPE_CHECKING:\n    from .types import Any\n\n\n"
             'def answer(kite: "Any" = None) -> int:\n    return TURN\n')
    assert value(put_in["kite.loop"]) == 2
    assert not any(word in text for text in put_in.values() for word in ("TYPE_CHECKING", "typing", ".types"))
    assert put_in["kite.kite"].count("\n") == kite.count("\n") + 1


def test_only_a_file_of_types_alone_is_none_of_a_board():
    types = '"""Types."""\n\nTYPE_CHECKING = False\nif TYPE_CHECKING:\n    from typing import Any\n'
    assert is_types_only(types)
    assert not any(map(is_types_only, ("", '"""A package."""\n', types + "LIGHT = 3\n", '"""A light."""\nLIGHT = 3\n')))


def test_a_board_gets_no_trace_of_types(tmp_path):
    names = lay_out(tmp_path, {}, ARCHITECTURES["rp2"])
    assert "firmware_py/autopilot.mpy" in names and "firmware_py/control/interface.mpy" not in names
    for path in tmp_path.rglob("*.mpy"):
        assert not any(word in path.read_bytes() for word in (b"TYPE_CHECKING", b"typing", b"Protocol")), path
