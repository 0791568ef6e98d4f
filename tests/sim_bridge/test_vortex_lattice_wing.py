"""The vortex lattice against what is known of wings, and against another implementation."""

import math
from itertools import pairwise

import numpy as np
import pytest

from sim_bridge.plants.vortex_lattice.influence import of_rays, of_segments
from sim_bridge.plants.vortex_lattice.wing_flow import WingFlow
from sim_bridge.plants.vortex_lattice.wing_geometry import ArcWing, Rows, Surface, panels
from sim_bridge.plants.vortex_lattice.wing_points import find_pose, four_points, share_out

KITE = ArcWing(span_m=4.6, arc_rad=2.8, root_chord_m=1.2, tip_chord_m=0.85, tip_sweep_m=0.3, camber=0.06,
               bridle_height_m=4.0, bridle_forward_m=0.25, steering_twist_rad=0.35)
ORIGIN = np.array([0.0, 0.0, 3.6])
DENSITY = 1.2
MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # of velocity and rotation, of force and moment, in y = 0


def size(vector):
    return math.sqrt(float(vector @ vector))


def elliptic_wing(aspect_ratio, strips=32, rows=3):
    """A flat wing of span 2 with a straight quarter-chord line."""
    angle = math.pi / strips * np.arange(strips + 1)
    span, middle = np.cos(angle), np.cos(angle[:-1] + 0.5 * math.pi / strips)
    chord = 8.0 / (math.pi * aspect_ratio) * np.sqrt(1.0 - span**2) + 1e-9
    edge = np.stack([0.25 * chord, span, 0.0 * span], axis=-1)
    surface = Surface(edge, chord[:, None] * np.array([-1.0, 0.0, 0.0]), np.tile([0.0, 0.0, 1.0], (strips + 1, 1)),
                      0.0, 0.0 * span, (span[:-1] - middle) / (span[:-1] - span[1:]))
    return WingFlow(panels(surface, Rows.cosine(rows)))


def kite_flow(strips=16, rows=3, profile_drag=0.0, greatest_lift=1e9):
    return WingFlow(panels(KITE.surface(strips, ORIGIN), Rows.cosine(rows)), profile_drag, greatest_lift)


def onset(speed, attack_deg, slip_deg=0.0):
    attack, slip = math.radians(attack_deg), math.radians(slip_deg)
    return speed * np.array([-math.cos(attack) * math.cos(slip), math.sin(slip), math.sin(attack) * math.cos(slip)])


def loads(flow, velocity, rotation=(0.0, 0.0, 0.0), steering=0.0):
    flow.lay_wake(velocity / np.linalg.norm(velocity))
    return flow.find_loads(np.concatenate([velocity, rotation]), steering, DENSITY).copy()


def far_drag(flow):
    """Drag from the wake far behind (Trefftz's plane): half the wash there, on the circulation of each strip."""
    along, grid = flow.wake, flow.panels
    edge = grid.nodes[-1]
    strength = flow.circulation.reshape(grid.rows, grid.strips).sum(axis=0)
    trailing = np.append(0.0, strength) - np.append(strength, 0.0)
    line = edge[1:] - edge[:-1]
    points = edge[:-1] + grid.meeting[:, None] * line
    arm = points[:, None] - edge
    arm -= (arm @ along)[..., None] * along
    wash = np.sum(trailing[:, None] * np.cross(along, arm) / np.sum(arm**2, axis=-1)[..., None], axis=1) / (2 * math.pi)
    return 0.5 * DENSITY * np.sum(strength * (np.cross(wash, line) @ along))


@pytest.mark.parametrize("aspect_ratio, below", [(6.0, 0.075), (12.0, 0.03), (24.0, 0.012)])
def test_an_elliptic_wing_nears_the_lift_slope_and_the_drag_of_lifting_line_theory(aspect_ratio, below):
    """Lifting-line theory neglects the chord: the slope lies below, the less so the more slender the wing is."""
    flow, attack = elliptic_wing(aspect_ratio), math.radians(2.0)
    velocity = onset(1.0, 2.0)
    force = loads(flow, velocity)[:3]
    pressure = 0.5 * DENSITY * np.sum(flow.panels.strip_area)
    lift = force @ np.array([math.sin(attack), 0.0, math.cos(attack)]) / pressure
    exact = 2.0 * math.pi * aspect_ratio / (aspect_ratio + 2.0)
    assert (1.0 - below) * exact < lift / attack < exact
    drag = lift**2 / (math.pi * 4.0 / np.sum(flow.panels.strip_area))
    assert force @ velocity / pressure == pytest.approx(drag, rel=0.02)
    assert far_drag(flow) / pressure == pytest.approx(drag, rel=0.01)


def test_a_round_wing_has_its_exact_lift_slope():
    """1.790 for aspect ratio 4/pi: P. F. Jordan, "Exact solutions for lifting surfaces" (1973)."""
    flow = elliptic_wing(4.0 / math.pi, strips=40, rows=4)
    lift = loads(flow, onset(1.0, 0.5))[2] / (0.5 * DENSITY * np.sum(flow.panels.strip_area))
    assert lift / math.radians(0.5) == pytest.approx(1.790, rel=0.01)


@pytest.mark.parametrize("slip_deg", [0.0, 8.0])
def test_the_arcs_drag_is_what_its_wake_carries_away(slip_deg):
    flow = kite_flow()
    force = loads(flow, onset(18.0, 8.0, slip_deg))[:3]
    assert force @ flow.wake == pytest.approx(far_drag(flow), rel=0.01)


@pytest.mark.parametrize("attack_deg, slip_deg, p, q, r", [
    (2.0, 0.0, 0.0, 0.0, 0.0), (8.0, 6.0, 0.0, 0.0, 0.0), (5.0, 0.0, 1.0, 0.0, 0.0), (5.0, 0.0, 0.0, 0.8, 0.0),
    (6.0, 0.0, 0.0, 0.0, 1.5), (6.0, -4.0, 0.5, 0.3, -1.0)])
def test_aerosandbox_finds_the_same_on_the_same_lattice(attack_deg, slip_deg, p, q, r):
    """Its model: panels of equal length, legs that all leave straight aft, forces on the bound vortices only."""
    asb = pytest.importorskip("aerosandbox")
    strips, rows = 12, 3
    surface = KITE._replace(camber=0.0).surface(strips, ORIGIN)._replace(meeting=np.full(strips, 0.5))
    places = Rows((np.arange(rows) + 0.25) / rows, (np.arange(rows) + 0.75) / rows)
    flow = WingFlow(panels(surface, places))
    turned = np.array([-1.0, -1.0, 1.0])  # its axes: x aft, y right
    sections = [asb.WingXSec(xyz_le=turned * edge, chord=float(-chord[0]), airfoil=asb.Airfoil("naca0010"))
                for edge, chord in zip(surface.leading_edge, surface.chord, strict=True)]
    airplane = asb.Airplane(wings=[asb.Wing(xsecs=sections)], xyz_ref=[0.0, 0.0, 0.0], s_ref=5.0, c_ref=1.0, b_ref=4.0)
    point = asb.OperatingPoint(velocity=18.0, alpha=attack_deg, beta=slip_deg, p=p, q=q, r=r)
    theirs = asb.VortexLatticeMethod(airplane, point, spanwise_resolution=1, chordwise_resolution=rows,
                                     chordwise_spacing_function=np.linspace).run()
    velocity = turned * np.array(point.compute_freestream_velocity_geometry_axes())
    flow.find_loads(np.concatenate([velocity, [p, -q, -r]]), 0.0, point.atmosphere.density())
    bound = flow.forces[: strips * rows]
    moment = np.sum(np.cross(flow.solved.middle[: strips * rows], bound), axis=0)
    force = turned * np.array(theirs["F_g"])
    assert np.sum(bound, axis=0) == pytest.approx(force, abs=1e-5 * size(force))
    theirs_moment = turned * np.array(theirs["M_g"])
    assert moment == pytest.approx(theirs_moment, abs=1e-5 * size(theirs_moment))


def test_finer_lattices_change_less_and_less_and_the_flown_one_is_near_their_limit():
    def at(strips, rows):
        flow = kite_flow(strips, rows, profile_drag=0.09)
        return loads(flow, onset(18.0, 9.0, 3.0), (0.3, 0.4, 1.0), 0.4)

    series = [at(strips, rows) for strips, rows in ((6, 1), (12, 2), (24, 4), (48, 8))]
    changes = [np.abs(second - first) for first, second in pairwise(series)]
    assert np.linalg.norm(changes[1]) < 0.5 * np.linalg.norm(changes[0])
    assert np.linalg.norm(changes[2]) < 0.5 * np.linalg.norm(changes[1])
    assert at(16, 3) == pytest.approx(series[-1], abs=0.02 * size(series[-1][:3]))


def test_a_mirrored_flow_makes_mirrored_loads():
    flow, velocity, rotation = kite_flow(profile_drag=0.09), onset(18.0, 8.0, 5.0), np.array([0.5, 0.3, -1.2])
    one = loads(flow, velocity, rotation, 0.6)
    other = loads(flow, MIRROR[:3] * velocity, MIRROR[3:] * rotation, -0.6)
    assert other == pytest.approx(MIRROR * one, abs=1e-7 * size(one))


def test_the_flow_damps_all_rotations_turns_the_nose_into_it_and_follows_the_steering():
    flow, velocity = kite_flow(profile_drag=0.09), onset(18.0, 8.0)
    level = loads(flow, velocity)
    for axis in range(3):
        rotation = np.zeros(3)
        rotation[axis] = 0.5
        assert (loads(flow, velocity, rotation) - level)[3 + axis] < 0.0
    slipping = loads(flow, onset(18.0, 8.0, 3.0))  # the flow goes to +y, so the nose should turn to -y
    assert slipping[5] < 0.0
    steered = loads(flow, velocity, steering=0.5) - level
    assert steered[5] > 0.0 and steered[1] > 0.0


def test_yaw_about_the_bridle_point_is_damped_without_any_profile_drag():
    flow = WingFlow(panels(KITE.surface(16, np.zeros(3)), Rows.cosine(3)))
    velocity = onset(18.0, 8.0)
    up = np.array([math.sin(math.radians(8.0)), 0.0, math.cos(math.radians(8.0))])
    assert (loads(flow, velocity, 0.5 * up) - loads(flow, velocity))[3:] @ up < -5.0


def test_in_any_flow_the_forces_are_finite_and_no_section_lifts_more_than_it_can():
    random = np.random.default_rng(3)
    flow = kite_flow(profile_drag=0.09, greatest_lift=1.8)
    flow.follow(np.zeros(3))
    for _ in range(300):
        velocity = random.normal(size=3) * random.choice([0.01, 3.0, 40.0])
        flow.follow(velocity)
        found = flow.find_loads(np.concatenate([velocity, random.normal(size=3)]), random.uniform(-1, 1), DENSITY)
        assert np.isfinite(found).all()
        assert np.max(np.abs(flow.section_lift)) <= 1.8 + 1e-9
    for velocity in (onset(20.0, 0.0), -onset(20.0, 0.0), onset(20.0, 90.0), onset(20.0, 0.0, 90.0)):
        flow.follow(velocity)
        assert np.isfinite(flow.find_loads(np.append(velocity, np.zeros(3)), 0.0, DENSITY)).all()


def test_a_wake_that_lags_the_flow_by_what_is_allowed_changes_little():
    flow, velocity = kite_flow(), onset(18.0, 8.0)
    exact = loads(flow, velocity)
    flow.lay_wake(onset(1.0, 8.0 + math.degrees(0.009)))
    flow.follow(velocity)
    lagging = flow.find_loads(np.append(velocity, np.zeros(3)), 0.0, DENSITY)
    assert not np.array_equal(lagging, exact)  # follow has left it where it was
    assert lagging == pytest.approx(exact, abs=0.003 * size(exact))


def test_long_straight_vortices_induce_what_the_books_say():
    points = np.array([[0.0, 0.5, 0.0]])
    line = of_segments(points, np.array([[-1e4, 0.0, 0.0]]), np.array([[1e4, 0.0, 0.0]]))[0, 0]
    assert line == pytest.approx([0.0, 0.0, 1.0 / math.pi], rel=1e-6)  # 1 / (2 pi h)
    ray = of_rays(points, np.zeros((1, 3)), np.array([1.0, 0.0, 0.0]))[0, 0]
    assert ray == pytest.approx([0.0, 0.0, 0.5 / math.pi], rel=1e-6)


def test_four_points_are_the_wing_to_all_forces_and_motions():
    points, masses = KITE.masses(2.2)
    corners, axes, centre = four_points(points, masses)
    mass = 0.55

    def second_moments(offsets, weights):
        return (weights[:, None] * offsets).T @ offsets

    assert np.sum(masses) == pytest.approx(4 * mass)
    assert corners.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    wanted = second_moments(points - centre, masses)
    assert second_moments(corners, np.full(4, mass)) == pytest.approx(wanted, abs=1e-9)

    frame, pose, motion, out = np.eye(3), np.zeros((4, 3)), np.zeros(6), np.zeros((4, 3))
    turn = np.array([0.3, -0.7, 1.1])
    x = corners + np.array([1.0, 2.0, 3.0])
    find_pose(x, np.cross(turn, corners) + np.array([4.0, 5.0, 6.0]), mass, axes, np.zeros(3), frame, pose, motion)
    assert frame == pytest.approx(np.eye(3), abs=1e-9)
    assert motion == pytest.approx([-4.0, -5.0, -6.0, *turn])
    applied = np.array([10.0, -20.0, 300.0, 7.0, -8.0, 9.0])
    share_out(x, mass, frame, pose, applied, out)
    assert out.sum(axis=0) == pytest.approx(applied[:3])
    assert np.cross(corners, out).sum(axis=0) == pytest.approx(applied[3:])
