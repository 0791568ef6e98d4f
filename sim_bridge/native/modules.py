"""Which modules make up the loop, and where its compiled build lies.

All that runs in every tick of a flight in this process is compiled, from the very files that boards and tests
interpret. What may be anybody's object there stays interpreted: boards, transports, plants with forces, ground paths.
"""

from pathlib import Path

ROOT = Path(__file__).parent.parent.parent  # that the packages lie in
BUILD = ROOT / "kitepilot_compiled"  # a folder beside them, so that nobody imports from it by accident
ABOUT = BUILD / "build.json"

MODULES = (
    "firmware_py.autopilot",
    "firmware_py.clock",
    "firmware_py.control.figure_eight",
    "firmware_py.control.gains",
    "firmware_py.control.guidance",
    "firmware_py.control.mode_laws",
    "firmware_py.control.steering",
    "firmware_py.estimation.estimator",
    "firmware_py.estimation.turn_k_estimate",
    "firmware_py.generated_enums",
    "firmware_py.mavlink.budget",
    "firmware_py.mavlink.generated_messages",
    "firmware_py.modes.mode_machine",
    "firmware_py.parameters.generated_parameters",
    "firmware_py.parameters.persistence",
    "firmware_py.parameters.values",
    "firmware_py.prediction.body_rotation",
    "firmware_py.prediction.drift",
    "firmware_py.prediction.prediction",
    "firmware_py.prediction.steering_history",
    "firmware_py.services.dispatcher",
    "firmware_py.services.inbox",
    "firmware_py.services.request",
    "firmware_py.services.telemetry",
    "firmware_py.sphere",
    "firmware_py.timing",
    "protocol.single_precision",
    "sim_bridge.equipment.actuator",
    "sim_bridge.equipment.approach",
    "sim_bridge.equipment.error_processes",
    "sim_bridge.equipment.measured_quantity",
    "sim_bridge.equipment.sensor_errors",
    "sim_bridge.equipment.sensors",
    "sim_bridge.flight.flight",
    "sim_bridge.flight.judgement",
    "sim_bridge.flight.truth_table",
    "sim_bridge.links.emulation",
    "sim_bridge.plants.tethered_truth",
    "sim_bridge.plants.truth",
    "sim_bridge.plants.turning_rate",
    "sim_bridge.runtimes.inproc",
    "sim_bridge.runtimes.tick_output",
    "sim_bridge.wind.air",
    "sim_bridge.wind.gust_process",
    "sim_bridge.wind.profile",
    "sim_bridge.wind.schedule",
    "sim_bridge.wind.turbulence",
    "sim_bridge.wind.wind",
)


def source_of(module: str) -> Path:
    """The source of a module of the packages here, or of a package itself."""
    path = ROOT.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
