"""What a PARAM_ERROR means, in words, and whether the parameter table would have said the same."""

from protocol import dialect
from protocol.parameter_table import Parameter

Table = dict[str, Parameter]


def foreseen(table: Table, name: str, value: float, error: int) -> bool:
    """Whether the table says by itself that setting `name` to `value` is refused with this MAV_PARAM_ERROR."""
    parameter = table.get(name)
    if parameter is None:
        return error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
    if error == dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE:
        return parameter.problem_with(value) is not None
    if error == dialect.MAV_PARAM_ERROR_READ_ONLY:
        return parameter.read_only
    return error == dialect.MAV_PARAM_ERROR_PERMISSION_DENIED and parameter.disarmed_only


def explain(table: Table, name: str, value: float, error: int, text: str | None = None) -> str:
    """One line on why the vehicle answered the setting of `name` to `value` with this MAV_PARAM_ERROR.

    `text` is a warning that the vehicle sent along: it speaks for a limit that is not in the table.
    """
    if error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST:
        return f"{name}: the kite has no such parameter"
    if error == dialect.MAV_PARAM_ERROR_READ_ONLY:
        return f"{name}: refused by the kite: it is read-only"
    if error == dialect.MAV_PARAM_ERROR_PERMISSION_DENIED:
        return f"{name}: refused by the kite: it can be set only while disarmed"
    if error == dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE:
        problem = table[name].problem_with(value) if name in table else None
        reason = problem.removeprefix(f"{name} = ") if problem else text or f"it does not take the value {value:g}"
        return f"{name}: refused by the kite: {reason}"
    return f"{name}: refused by the kite with PARAM_ERROR {error}"
