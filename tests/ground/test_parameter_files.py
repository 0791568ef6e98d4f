"""Parameter files: ours come back as they were, the other ground stations' are read, broken ones are named by line."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.parameters.file import STYLES, ParameterFileError, format_value, read_parameter_file, write_parameter_file
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32

numbers = st.floats(width=32, allow_nan=False, allow_infinity=False)
names = st.text("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_", min_size=1, max_size=16).filter(lambda name: name.strip("_"))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("parameters") / "kite.param"


@pytest.mark.parametrize("style", STYLES)
@given(values=st.dictionaries(names, numbers, min_size=1))
def test_what_is_saved_is_loaded(path, style, values):
    write_parameter_file(path, values, ["as flown"], style, 7)
    read = read_parameter_file(path)
    assert list(read) == list(values)
    assert {name: entry.value for name, entry in read.items()} == values


@given(numbers)
def test_a_value_is_written_in_as_few_digits_as_bring_it_back(value):
    text = format_value(value)
    assert float32(float(text)) == value
    assert len(text) <= len(f"{value:.9g}") or abs(value) < 1e9


@pytest.mark.parametrize(("value", "text"), [(0.1, "0.1"), (20.0, "20"), (-5.0, "-5"), (1.8393972, "1.8393972")])
def test_values_read_well(value, text):
    assert format_value(float32(value)) == text


@pytest.mark.parametrize("text", [
    "# MAVProxy\nINNER_P          2.500000\n\nOUTER_L          6.1  # faster\n",
    "\ufeff#NOTE: Mission Planner\r\nINNER_P,2.5\r\nOUTER_L,6.1\r\n",
    "# Onboard parameters for Vehicle 1\n#\n# Vehicle-Id Component-Id Name Value Type\n"
    "1\t1\tINNER_P\t2.500000000000000000\t9\n1\t1\tOUTER_L\t6.099999904632568359\t9\n",
])
def test_the_files_of_other_ground_stations_are_read(path, text):
    path.write_text(text, "utf-8")
    read = read_parameter_file(path)
    assert {name: entry.value for name, entry in read.items()} == {"INNER_P": 2.5, "OUTER_L": float32(6.1)}
    assert [text.splitlines()[entry.line - 1].replace("\t", " ").count(name) for name, entry in read.items()] == [1, 1]


@pytest.mark.parametrize(("content", "said"), [
    (b"INNER_P 2\nOUTER_L\n", ":2: 'OUTER_L' is not a parameter: expected NAME value"),
    (b"INNER_P 2\nOUTER_L six\n", ":2: 'six' is not a number"),
    (b"INNER_P nan\n", ":1: 'nan' is not a finite number"),
    (b"INNER_P 1e39\n", ":1: '1e39' is not a finite number"),
    (b"# twice\nINNER_P 2\nINNER_P 3\n", ":3: INNER_P is already given in line 2"),
    (b"A_NAME_THAT_IS_TOO_LONG 2\n", ":1: 'A_NAME_THAT_IS_TOO_LONG' is not a parameter name"),
    (b"# nothing\n", ": holds no parameters"),
    (b"\xff\xfe\x00\x80", ": not a text file"),
])
def test_a_broken_file_is_named_with_its_line(path, content, said):
    path.write_bytes(content)
    with pytest.raises(ParameterFileError) as caught:
        read_parameter_file(path)
    assert f"{path}{said}" in str(caught.value) and "\n" not in str(caught.value)


def test_a_file_that_cannot_be_written_leaves_nothing_behind(tmp_path):
    defaults = {name: parameter.default for name, parameter in load_parameters().items()}
    with pytest.raises(ParameterFileError, match="cannot write"):
        write_parameter_file(tmp_path, defaults, ["onto a folder"])
    assert not Path(f"{tmp_path}.part").exists()
    with pytest.raises(ParameterFileError, match="cannot read: No such file"):
        read_parameter_file(tmp_path / "none.param")
