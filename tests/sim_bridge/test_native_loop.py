"""The compiled loop flies the same as its sources, to the last bit, and is used only where it fits."""

import json
import os
import random
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path
from typing import Any

import pytest

from protocol.parameter_table import load_parameters
from sim_bridge.equipment.error_settings import QUANTITIES
from sim_bridge.native.choice import COMPILED, INTERPRETED, VARIABLE, loop_in_use, misfit_of_build
from sim_bridge.native.modules import ABOUT, BUILD, MODULES, ROOT, source_of
from sim_bridge.runtimes.interpreter import micropython_command
from sim_bridge.scenario.scenario import load_scenario, scenario_names

PACKAGES = ("firmware_py", "kite_analysis", "protocol", "sim_bridge")
RANDOM_FLIGHTS = 60
BAD_DAY: dict[str, Any] = {
    "link.control.jitter_s": 0.03, "link.control.loss": 0.05, "link.control.loss_burst": 4.0,
    "link.control.duplicate": 0.1, "link.control.reorder": 0.1, "sensors.noise_rad": 0.002,
    "sensors.course_noise_rad": 0.05, "sensors.airspeed_noise": 0.05, "sensors.resolution_rad": 0.0005,
    "sensors.rate_hz": 37.0, "wind.gusts": "dryden", "wind.turbulence_intensity": 0.2, "actuator.lag_s": 0.05}
WEATHER: dict[str, Any] = {
    "wind.profile": "explog", "wind.gusts": "von-karman", "wind.turbulence_intensity": 0.15, "wind.step_s": 3.0,
    "wind.step_m_s": 1.0, "wind.lull_start_s": 5.0, "wind.lull_length_s": 2.0, "wind.lull_to": 0.5,
    "wind.turn_start_s": 2.0, "wind.turn_by_deg": 20.0}
BLIND: dict[str, Any] = {f"sensors.{quantity}": False for quantity in (
    "course", "heading", "distance", "airspeed", "steering")}
WRONG = {"noise": 0.01, "wander": 0.02, "wander_time_s": 3.0, "bias": -0.01, "scale": 0.97, "lag_s": 0.053,
         "dropout": 0.05, "dropout_s": 0.08}
BAD_INPUTS: dict[str, Any] = {
    **{f"errors.{quantity}.{key}": value for quantity in QUANTITIES for key, value in WRONG.items()},
    "sensors.noise_rad": 0.002, "sensors.rate_hz": 41.0, "sensors.resolution_rad": 0.0005,
    "actuator.backlash": 0.03, "actuator.dead_band": 0.015, "actuator.lag_s": 0.05, "actuator.rate_limit_per_s": 1.5}
LOOSE: dict[str, Any] = {"actuator.backlash": 0.05, "actuator.dead_band": 0.02}
# What random flights vary, and how far: enough for kites that fly well, badly and not at all.
VARIED: dict[str, tuple[float, float]] = {
    "link.control.delay_s": (0.0, 0.4), "link.control.jitter_s": (0.0, 0.05), "link.control.loss": (0.0, 0.5),
    "link.control.duplicate": (0.0, 0.3), "link.control.reorder": (0.0, 0.3),
    "link.control.rate_bytes_s": (1500.0, 9000.0), "sensors.noise_rad": (0.0, 0.01), "sensors.rate_hz": (5.0, 200.0),
    "sensors.course_noise_rad": (0.0, 0.2), "sensors.airspeed_noise": (0.0, 0.3),
    "actuator.dead_time_s": (0.0, 0.3), "actuator.rate_limit_per_s": (0.1, 10.0), "actuator.saturation": (0.1, 1.0),
    "actuator.lag_s": (0.0, 0.2), "wind.turbulence_intensity": (0.0, 0.5), "wind.speed_m_s": (0.0, 15.0),
    "start.offset_rad": (-0.5, 0.5), "start.course_error_rad": (-3.0, 3.0), "plant.offset_rad_s": (-0.3, 0.3),
    "actuator.backlash": (0.0, 0.2), "actuator.dead_band": (0.0, 0.1), "errors.position.noise": (0.0, 0.005),
    "errors.position.dropout": (0.0, 0.5), "errors.course.lag_s": (0.0, 0.3), "errors.heading.wander": (0.0, 0.3),
    "errors.airspeed.scale": (0.5, 1.5), "errors.steering.bias": (-0.1, 0.1)}


def flights() -> list[dict[str, Any]]:
    """All scenarios; bad links, sensors and weather; random ones; and talkative ground stations."""
    found: list[dict[str, Any]] = [{"scenario": name, "seconds": 12.0} for name in scenario_names()]
    for name in ("small-kite", "v3-flight", "small-kite-paper", "v3-flight-paper"):
        for change in (BAD_DAY, WEATHER, BLIND, BAD_INPUTS, LOOSE):
            found.append({"scenario": name, "seconds": 15.0, "set": change})
        found.append({"scenario": name, "seconds": 30.0, "set": {"sensors.steering": False},
                      "param": {"K_ADAPT": 1.0, "TURN_K": 1.2 * load_scenario(name).parameter("TURN_K"),
                                "GAIN_TAU": 0.2}})
    found += [_random_flight(random.Random(seed), seed) for seed in range(RANDOM_FLIGHTS)]
    return found + [{"scenario": name, "seconds": 25.0, "talk": seed}
                    for seed, name in enumerate(("small-kite", "v3-flight", "paper-delay-tuned") * 3)]


def _random_flight(chosen: random.Random, seed: int) -> dict[str, Any]:
    changes: dict[str, Any] = {"run.seed": seed}
    changes |= {key: chosen.uniform(*bounds) for key, bounds in VARIED.items() if chosen.random() < 0.25}
    changes |= {key: value for key, value in BLIND.items() if chosen.random() < 0.15}
    parameters = {}
    for name, entry in load_parameters().items():
        if chosen.random() < 0.05 and not (entry.read_only or name in ("SYSTEM_ID", "LOOP_HZ")):
            value = chosen.uniform(entry.least, entry.greatest)
            steps = round((value - entry.least) / entry.step) if entry.step else 0
            parameters[name] = entry.least + steps * entry.step if entry.step else value
    name = chosen.choice([name for name in scenario_names() if load_scenario(name).plant_kind == "turning-rate"])
    return {"scenario": name, "seconds": 8.0, "set": changes, "param": parameters}


def outcome(loop: str, asked: list[dict[str, Any]]) -> subprocess.Popen[str]:
    """A process that flies what is `asked` with `loop`."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.sim_bridge.flown_to_the_bit", loop], cwd=ROOT, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**os.environ, VARIABLE: ""})
    assert process.stdin is not None
    process.stdin.write(json.dumps(asked))
    process.stdin.close()
    return process


def results(process: subprocess.Popen[str], loop: str) -> list[str]:
    """What the flights came to, all flown with `loop`."""
    assert process.stdout is not None
    text = process.stdout.read()
    assert process.wait() == 0
    loops, fingerprints = zip(*json.loads(text), strict=True)
    assert set(loops) == {loop}
    return list(fingerprints)


def run_kite_sitl(folder: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """`kite-sitl` of the packages in `folder`."""
    return subprocess.run(
        [sys.executable, "-m", "sim_bridge.cli.main", *words], cwd=folder, text=True, capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": str(folder), VARIABLE: "", **environment})


@pytest.fixture
def built() -> None:
    """The compiled loop of these sources."""
    if misfit := misfit_of_build():
        pytest.skip(f"the compiled loop {misfit}: make compiled")


@pytest.fixture
def copy(tmp_path, built) -> Path:
    """The packages and the build, in a folder of their own."""
    for name in (*PACKAGES, BUILD.name):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def test_the_compiled_loop_flies_what_the_sources_fly_to_the_last_bit(built):
    asked = flights()
    processes = {loop: outcome(loop, asked) for loop in (COMPILED, INTERPRETED)}
    compiled, interpreted = (results(process, loop) for loop, process in processes.items())
    differing = [flight for flight, ours, theirs in zip(asked, compiled, interpreted, strict=True) if ours != theirs]
    assert not differing
    assert len(set(compiled)) > 0.9 * len(asked)  # they are not all refused


def test_micropython_flies_what_the_compiled_loop_flies_in_every_scenario(built):
    if not micropython_command():
        pytest.skip("no MicroPython interpreter on this platform")
    asked = [{"scenario": name, "seconds": 10.0} for name in scenario_names()]
    here = outcome(COMPILED, asked)
    there = outcome(INTERPRETED, [flight | {"runtime": "micropython"} for flight in asked])
    for flight, ours, theirs in zip(asked, results(here, COMPILED), results(there, INTERPRETED), strict=True):
        assert ours == theirs, flight["scenario"]


def test_a_logged_flight_is_repeated_to_the_bit_by_the_other_loop(copy):
    logged = run_kite_sitl(copy, "run", "small-kite", "--duration", "15", "--log", "log", "--interpreted", "--json")
    again = run_kite_sitl(copy, "rerun", "log", "--json")
    assert json.loads(logged.stdout)["loop"] == INTERPRETED
    assert json.loads(again.stdout)["loop"] == COMPILED
    assert json.loads(again.stdout)["same"] is True


def test_a_sweep_gives_the_same_file_compiled_interpreted_and_resumed(copy):
    def sweep(out: str, *more: str) -> bytes:
        done = run_kite_sitl(copy, "sweep", "small-kite", "--over", "param.INNER_P=2:8:3", "--over",
                             "wind.turbulence_intensity=0,0.2", "--duration", "12", "--out", out, "--json", *more)
        assert done.returncode == 0, done.stderr
        return (copy / out).read_bytes()

    whole = sweep("compiled.csv")
    assert whole == sweep("interpreted.csv", "--interpreted")
    head, *rows = whole.splitlines(keepends=True)
    (copy / "resumed.csv").write_bytes(b"".join([head, *rows[:4], rows[4][:11]]))  # as a kill leaves it
    assert whole == sweep("resumed.csv")


def test_the_workers_of_a_dask_cluster_fly_the_compiled_loop_too(built, tmp_path):
    distributed = pytest.importorskip("distributed")
    command = ("sweep", "v3-flight", "--over", "param.INNER_P=1:4:4", "--duration", "10", "--json", "--out")
    alone = run_kite_sitl(ROOT, *command, str(tmp_path / "alone.csv"), "--interpreted")
    with distributed.LocalCluster(host="127.0.0.1", n_workers=2, threads_per_worker=1, dashboard_address=None,
                                  env={VARIABLE: ""}) as cluster, distributed.Client(cluster) as client:
        address = cluster.scheduler_address
        flown = run_kite_sitl(ROOT, *command, str(tmp_path / "dask.csv"), "--scheduler", address)
        loops = set(client.run(loop_in_use).values())
    assert (alone.returncode, flown.returncode) == (0, 0), flown.stderr
    assert (tmp_path / "dask.csv").read_bytes() == (tmp_path / "alone.csv").read_bytes()
    assert loops == {COMPILED}


def test_a_build_of_other_sources_is_not_used_and_that_is_said(copy):
    source = copy / "firmware_py" / "sphere.py"
    source.write_text(source.read_text("utf-8") + "\n# a change\n", "utf-8")
    flown = run_kite_sitl(copy, "run", "small-kite", "--duration", "11", "--json")
    assert json.loads(flown.stdout)["loop"] == INTERPRETED
    line, = flown.stderr.splitlines()
    assert "firmware_py/sphere.py has changed" in line and "make compiled" in line


def test_each_source_that_the_build_depends_on_is_in_its_fingerprint(built):
    sources = json.loads(ABOUT.read_text("utf-8"))["sources"]
    assert {source_of(module).relative_to(ROOT).as_posix() for module in MODULES} <= sources.keys()
    assert {"firmware_py/control/interface.py", "sim_bridge/plants/interface.py", "sim_bridge/native/primitives.h",
            "kite_analysis/figure_eight.py"} <= sources.keys()


@pytest.mark.parametrize("content", ["", "{}", '{"suffix": ".none", "modules": {}, "sources": {}}'])
def test_a_build_that_is_broken_or_for_another_python_is_not_used(copy, content):
    (copy / BUILD.name / ABOUT.name).write_text(content, "utf-8")
    flown = run_kite_sitl(copy, "run", "small-kite", "--duration", "11", "--json")
    assert json.loads(flown.stdout)["loop"] == INTERPRETED
    assert len(flown.stderr.splitlines()) == 1 and "the compiled loop" in flown.stderr


def test_without_a_build_nothing_is_said_and_flights_are_interpreted(copy):
    shutil.rmtree(copy / BUILD.name)
    flown = run_kite_sitl(copy, "run", "small-kite", "--duration", "11", "--json")
    assert json.loads(flown.stdout)["loop"] == INTERPRETED
    assert not flown.stderr


def test_the_environment_and_the_option_force_the_sources(copy):
    for words, environment in (((), {VARIABLE: INTERPRETED}), (("--interpreted",), {})):
        flown = run_kite_sitl(copy, "run", "small-kite", "--duration", "11", "--json", *words, **environment)
        assert json.loads(flown.stdout)["loop"] == INTERPRETED
        assert not flown.stderr


def test_where_no_compiler_works_a_line_says_so_and_what_was_built_stays(copy):
    before = (copy / BUILD.name / ABOUT.name).read_bytes()
    done = subprocess.run(
        [sys.executable, "-m", "sim_bridge.native.build"], cwd=copy, text=True, capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": str(copy), "CC": "/bin/false"})
    assert done.returncode == 1 and not done.stderr
    *_, line = done.stdout.splitlines()
    assert line.startswith("the loop is not compiled: the C compiler failed") and "interpreted" in line
    assert (copy / BUILD.name / ABOUT.name).read_bytes() == before


def test_without_mypyc_a_line_says_what_to_install(copy):
    script = ("import sys; sys.modules['mypyc'] = None\n"
              "from sim_bridge.native.build import main\nsys.exit(main())")
    done = subprocess.run([sys.executable, "-c", script], cwd=copy, text=True, capture_output=True, check=False)
    assert done.returncode == 1 and not done.stderr
    assert "pip install 'kitepilot[compiled]'" in done.stdout.splitlines()[-1]


def wheel_of(folder: Path) -> set[str]:
    """The files of the wheel that pip makes of the sources in `folder`, its own name among them."""
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / name)
    out = folder / "wheels"
    done = subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(out), "."],
        cwd=folder, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    wheel, = out.glob("*.whl")
    return {wheel.name, *zipfile.ZipFile(wheel).namelist()}


def test_a_wheel_carries_the_build_of_the_sources_that_it_has(copy):
    files = wheel_of(copy)
    assert f"{BUILD.name}/{ABOUT.name}" in files
    assert not any(name.endswith("none-any.whl") for name in files)


def test_a_wheel_leaves_out_the_build_of_other_sources(copy):
    source = copy / "firmware_py" / "sphere.py"
    source.write_text(source.read_text("utf-8") + "\n# a change\n", "utf-8")
    files = wheel_of(copy)
    assert "firmware_py/sphere.py" in files
    assert not any(name.startswith(BUILD.name) for name in files)
    assert any(name.endswith("none-any.whl") for name in files)


def test_the_library_fuses_no_multiplication_with_an_addition(built):
    library, = BUILD.glob(f"*__mypyc{sysconfig.get_config_var('EXT_SUFFIX')}")
    if shutil.which("objdump") is None:
        pytest.skip("no objdump here")
    listing = subprocess.run(["objdump", "-d", str(library)], text=True, capture_output=True, check=True).stdout
    assert "mulsd" in listing or "fmul" in listing
    assert not any(word in listing for word in ("vfmadd", "vfmsub", "vfnmadd", "fmadd", "fmsub"))
