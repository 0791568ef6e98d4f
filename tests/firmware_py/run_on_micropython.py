"""Runs test files under MicroPython: `micropython run_on_micropython.py ROOT FILE [FILE ...]`.

ROOT is the folder that firmware_py is in. Every function test_... of every file is run. Exit code 0 only if there
were tests and all of them passed; micropython-lib's unittest exits 0 whatever happens.
"""

import sys


def load(path):
    """A file's names, as importing it would make them."""
    names: dict = {"__name__": "test"}
    with open(path) as file:  # noqa: PTH123  MicroPython has no pathlib
        exec(compile(file.read(), path, "exec"), names)
    return names


def run(path):
    """(passed, failed) of one file; what fails is printed with its traceback."""
    passed = failed = 0
    try:
        names = load(path)
    except Exception as error:
        print("FAILED", path, "cannot be loaded")
        tell(error)
        return 0, 1
    for name in sorted(names):
        if not name.startswith("test_"):
            continue
        try:
            names[name]()
            passed += 1
        except Exception as error:
            failed += 1
            print("FAILED", path, name)
            tell(error)
    return passed, failed


def tell(error):
    """Print a traceback, on either interpreter."""
    show = getattr(sys, "print_exception", None)  # MicroPython's
    print(repr(error)) if show is None else show(error)


def main(arguments):
    """Run all files; 0 if all is well."""
    sys.path.insert(0, arguments[0])
    total = [0, 0]
    for path in arguments[1:]:
        passed, failed = run(path)
        total[0] += passed
        total[1] += failed
        if not passed and not failed:
            print("FAILED", path, "has no tests")
            total[1] += 1
    print("{} passed, {} failed".format(*total))
    return 0 if total[0] and not total[1] else 1


sys.exit(main(sys.argv[1:]))
