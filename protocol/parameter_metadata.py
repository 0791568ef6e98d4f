"""The parameter table as the JSON files that ground stations read over MAVFTP: units, limits, documentation.

Formats: MAVLink's component metadata, "general" and "parameter", each of version 1.
"""

import json
import zlib

from protocol.parameter_table import Parameter

GENERAL = "general.json"
PARAMETERS = "parameters.json"
_TYPE_PARAMETER = 1  # COMP_METADATA_TYPE_PARAMETER
_MOST_DECIMALS = 6


def metadata_files(table: dict[str, Parameter]) -> dict[str, str]:
    """The text of each file, by name, for a parameter `table`."""
    parameters = _compact({"version": 1, "parameters": [_describe(parameter) for parameter in table.values()]})
    entry = {"type": _TYPE_PARAMETER, "uri": f"mftp:///{PARAMETERS}", "fileCrc": mavlink_crc32(parameters.encode())}
    return {GENERAL: _compact({"version": 1, "metadataTypes": [entry]}), PARAMETERS: parameters}


def mavlink_crc32(data: bytes) -> int:
    """CRC32 as MAVLink's file transfer has it: polynomial 0xEDB88320, begun at 0, not inverted at the end."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _describe(parameter: Parameter) -> dict[str, object]:
    """The entry of one parameter."""
    described: dict[str, object] = {
        "name": parameter.name, "type": "Float", "shortDesc": parameter.text, "group": parameter.group,
        "min": 0.0 if parameter.off_at_zero else parameter.least, "max": parameter.greatest,
        "default": parameter.default,
        "decimalPlaces": 0 if parameter.step and parameter.step % 1.0 == 0.0 else _MOST_DECIMALS,
    }
    if parameter.unit:
        described["units"] = parameter.unit
    if parameter.step:
        described["increment"] = parameter.step
    if parameter.read_only:
        described["readOnly"] = True
    return described


def _compact(content: dict[str, object]) -> str:
    return json.dumps(content, separators=(",", ":"), ensure_ascii=True) + "\n"
