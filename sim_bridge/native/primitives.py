"""Teaches mypyc a few functions that it knows no machine code for, so that it does not call Python for them.

Each gives the same bits as Python's own: math.atan2 and math.atan are libm's in CPython, too; the rounding of a number
to an integer and to single precision are instructions of the processor.
"""

from mypyc.ir.ops import ERR_MAGIC, ERR_NEVER
from mypyc.ir.rtypes import float_rprimitive, int_rprimitive
from mypyc.primitives.registry import function_op


def add_primitives() -> None:
    """Have them used by all that is compiled in this process from now on."""
    for name, arguments in (("atan2", 2), ("atan", 1)):
        function_op(
            name=f"math.{name}", arg_types=[float_rprimitive] * arguments, return_type=float_rprimitive,
            c_function_name=name, error_kind=ERR_NEVER)
    function_op(
        name="builtins.round", arg_types=[float_rprimitive], return_type=int_rprimitive,
        c_function_name="kite_round", error_kind=ERR_MAGIC)
    function_op(
        name="protocol.single_precision.float32", arg_types=[float_rprimitive],
        return_type=float_rprimitive, c_function_name="kite_float32", error_kind=ERR_NEVER)
