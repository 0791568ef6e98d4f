/* What mypyc would otherwise do by calling Python, on boxed numbers; see primitives.py. */

#if __has_include(<CPy.h>) /* not where the library is only handed on */

#include <Python.h>
#include <CPy.h>
#include <math.h>

/* Half to even, as Python's round() to an integer does. */
static inline CPyTagged kite_round(double value) {
    double whole = rint(value);
    if (whole >= -1e15 && whole <= 1e15) {
        return (CPyTagged)(int64_t)whole << 1;
    }
    PyObject *number = PyLong_FromDouble(value);
    return number == NULL ? CPY_INT_TAG : CPyTagged_StealFromObject(number);
}

/* As protocol.single_precision.float32 does. */
static inline double kite_float32(double value) {
    return (double)(float)value;
}

#endif
