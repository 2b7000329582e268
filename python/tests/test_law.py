# SPDX-License-Identifier: MIT OR Apache-2.0
"""The law through the package. Expected values: closed forms, Masing's rules, finite differences, plain Coulomb."""

import pickle
import threading

import numpy as np
import pytest

import mepc
from mepc import Law, MepcError, MepcWarning
from mepc._library import LIBRARY, reals

MU, GCR, PRESSURE = 0.3, 0.002, 100.0
LIMIT = MU * PRESSURE


def f(s):
    return 1 - (1 - np.minimum(s, 1)) ** 2.5


def law(**more):
    return Law(**({"mu": MU, "gcr": GCR, "reference_pressure": PRESSURE, "ndir": 1} | more))


SLIP = np.array([0.5, -0.75, 0.25]) * GCR
MASING = LIMIT * np.array([f(0.5), f(0.5) - 2 * f(0.375), f(0.5) - 2 * f(0.375) + 2 * f(0.125)])


def walk(shape, seed, length=0.4):
    return length * GCR * np.random.default_rng(seed).standard_normal(shape)


def test_history_in_one_direction_is_masings():
    for slip in (SLIP, SLIP[:, None], list(SLIP)):
        done = law().history(slip, PRESSURE)
        assert done.traction.shape == np.shape(slip)
        np.testing.assert_allclose(done.traction.ravel(), MASING, atol=1e-12 * LIMIT)
        assert done.state.shape == (44,)
        assert done.energy.shape == (3, 2)
        assert done.dtraction_dslip is None and done.dtraction_dpressure is None


def test_history_in_two_directions_along_a_line():
    along = np.array([0.6, 0.8])
    done = law(ndir=2).history(SLIP[:, None] * along, np.full(3, PRESSURE), tangents=True)
    np.testing.assert_allclose(done.traction, MASING[:, None] * along, atol=1e-10 * LIMIT)
    assert done.dtraction_dslip.shape == (3, 2, 2)
    stiffness = LIMIT / GCR * 2.5 * (1 - 0.5) ** 1.5
    np.testing.assert_allclose(along @ done.dtraction_dslip[0] @ along, stiffness, rtol=1e-9)


def test_history_of_many_points_is_that_of_each():
    for ndir in (1, 2):
        one = law(ndir=ndir)
        slip = walk((7, 40, ndir), seed=1)
        pressure = PRESSURE * (1 + 0.3 * np.sin(np.arange(40)))
        factor = np.linspace(0.5, 1.5, 7)[:, None]
        state = one.history(walk((7, 5, ndir), seed=2), PRESSURE).state
        for threads in (1, 2, 0):
            many = law(ndir=ndir, threads=threads).history(slip, pressure, factor, state=state, tangents=True)
            for k in range(7):
                alone = one.history(slip[k], pressure, factor[k], state=state[k], tangents=True)
                for a, b in zip(alone, many):
                    np.testing.assert_array_equal(a, b[k])


def test_updates_are_the_steps_of_a_history():
    for ndir in (1, 2):
        one = law(ndir=ndir)
        slip, pressure = walk((5, 30, ndir), seed=3), PRESSURE * (1 + 0.2 * np.cos(np.arange(30)))
        done = one.history(slip, pressure, tangents=True)
        states = one.virgin(5)
        for k in range(30):
            now = one.update(states, slip[:, k], pressure[k])
            states = now.state
            np.testing.assert_array_equal(now.traction, done.traction[:, k])
            np.testing.assert_array_equal(now.energy, done.energy[:, k])
            np.testing.assert_array_equal(now.dtraction_dslip, done.dtraction_dslip[:, k])
            np.testing.assert_array_equal(now.dtraction_dpressure, done.dtraction_dpressure[:, k])
        np.testing.assert_array_equal(states, done.state)


def test_shapes_follow_the_input():
    two = law(ndir=2)
    done = two.update(two.virgin(3, 4), np.zeros((3, 4, 2)), PRESSURE)
    assert done.traction.shape == (3, 4, 2) and done.state.shape == (3, 4, 84)
    assert done.dtraction_dslip.shape == (3, 4, 2, 2) and done.dtraction_dpressure.shape == (3, 4, 2)
    assert done.energy.shape == (3, 4, 2) and done.statuses.shape == (3, 4)
    point = two.update(two.virgin(), [0.0, 1e-4], PRESSURE, tangents=False)
    assert point.traction.shape == (2,) and point.dtraction_dslip is None
    one = law()
    assert one.update(one.virgin(), 1e-4, PRESSURE).traction.shape == ()
    assert one.update(one.virgin(6), np.zeros(6), PRESSURE).dtraction_dslip.shape == (6,)
    assert one.update(one.virgin(6), np.zeros((6, 1)), PRESSURE).dtraction_dslip.shape == (6, 1, 1)
    assert one.update(one.virgin(0), np.zeros(0), PRESSURE).traction.shape == (0,)
    assert one.history(np.zeros((4, 1)), PRESSURE).traction.shape == (4, 1)
    assert one.history(np.zeros((4, 3)), PRESSURE).traction.shape == (4, 3)
    assert one.history(np.zeros((2, 4, 3)), PRESSURE).state.shape == (2, 4, 44)


def test_states_are_left_alone_and_outputs_may_be_used_again():
    one = law(ndir=2)
    states, slip = one.virgin(9), walk((9, 2), seed=4)
    first = one.update(states, slip, PRESSURE)
    assert not states.any()
    expected = one.update(first.state, slip, PRESSURE)
    again = one.update(first.state, slip, PRESSURE, out=first)  # the state at the start is written over
    for a, b, mine in zip(again, expected, first):
        np.testing.assert_array_equal(a, b)
        assert a is mine
    with pytest.raises(MepcError, match=r"out.traction .*\(8, 2\)"):
        one.update(one.virgin(8), slip[:8], PRESSURE, out=first)


def test_contiguous_arrays_are_not_copied():
    array = np.zeros((5, 2))
    assert reals("array", array) is array
    # Others are taken, too.
    one = law(ndir=2)
    slip = walk((9, 2), seed=5)
    expected = one.update(one.virgin(9), slip, PRESSURE).traction
    np.testing.assert_array_equal(one.update(one.virgin(9), np.asfortranarray(slip), PRESSURE).traction, expected)
    wide = np.zeros((9, 4))
    wide[:, ::2] = slip
    np.testing.assert_array_equal(one.update(one.virgin(9), wide[:, ::2], PRESSURE).traction, expected)


def test_gross_slip_follows_pressure_and_factor():
    one = law()
    pressure = np.array([50.0, 100.0, 200.0])
    done = one.update(one.virgin(3), np.full(3, 50 * GCR), pressure, [1.0, 0.5, 2.0])
    np.testing.assert_allclose(done.traction, MU * pressure * [1.0, 0.5, 2.0], rtol=1e-12)
    status = one.state_names.index("ContactStatus")
    np.testing.assert_array_equal(done.state[:, status], 3)
    np.testing.assert_allclose(done.dtraction_dpressure, MU * np.array([1.0, 0.5, 2.0]), rtol=1e-12)


def test_work_is_stored_or_dissipated():
    slip = np.diff(1.4 * GCR * np.sin(np.linspace(0, 4 * np.pi, 4001)))
    done = law().history(slip, PRESSURE)
    mean = (done.traction + np.concatenate([[0], done.traction[:-1]])) / 2
    work = mean @ slip
    assert done.energy[:, 1].min() > -1e-14 * LIMIT * GCR
    assert abs(work - done.energy[:, 1].sum() - done.energy[-1, 0]) < 1e-5 * work


@pytest.mark.parametrize("ndir", [1, 2])
def test_tangents_are_derivatives(ndir):
    one = law(ndir=ndir)
    start = one.history(walk((20, ndir), seed=6, length=0.2), PRESSURE).state
    slip, step = walk(ndir, seed=7, length=0.2), 1e-6
    here = one.update(start, slip, 90.0)
    for i in range(ndir):
        d = np.zeros(ndir)
        d[i] = step * GCR
        ahead, back = (one.update(start, slip + s * d, 90.0).traction for s in (1, -1))
        np.testing.assert_allclose(here.dtraction_dslip[:, i], (ahead - back) / (2 * d[i]), atol=1e-4 * LIMIT / GCR)
    ahead, back = (one.update(start, slip, 90.0 + s * 1e-4).traction for s in (1, -1))
    np.testing.assert_allclose(here.dtraction_dpressure, (ahead - back) / 2e-4, atol=1e-4 * MU)


def test_interface_form():
    kn = 1e5
    two = law(ndir=2, kn=kn, gap0=1e-3)
    opening = np.array([[-0.002, 0, 0], [-0.0005, 0.001, 0], [0.003, 0.001, 0], [-0.002, 0.03, 0.04]])
    done = two.interface(two.virgin(4), opening)
    assert done.tangent.shape == (4, 3, 3) and done.energy.shape == (4, 2)
    np.testing.assert_allclose(done.traction[:, 0], [-100, 0, 0, -100], rtol=1e-12)
    assert not done.traction[1:3].any()
    np.testing.assert_allclose(done.tangent[0, 0], [kn, 0, 0])
    # Dragged far: gross slip along (3, 4).
    np.testing.assert_allclose(done.traction[3, 1:], [0.6 * LIMIT, 0.8 * LIMIT], rtol=1e-9)
    np.testing.assert_allclose(two.interface(two.virgin(4), opening, np.full(4, 0.5)).traction[3, 1:],
                               [0.3 * LIMIT, 0.4 * LIMIT], rtol=1e-9)
    # The normal spring: kn closure^2 / 2.
    np.testing.assert_allclose(done.energy[0, 0], kn * 0.001**2 / 2, rtol=1e-12)
    with pytest.raises(MepcError, match="kn"):
        law(ndir=2).interface(two.virgin(4), opening)


def test_properties_by_name_and_as_an_array():
    named = Law(mu=0.4, gcr=0.003, exponent=1.5, method="penalty", cohesion=2, tau_max=50, ndir=1)
    np.testing.assert_array_equal(named.props, [0.4, 0.003, 1.5, 1, 0, 0, 0, 0, 0, 0, 0, 2, 50])
    again = Law.from_props(named.props, ndir=1)
    np.testing.assert_array_equal(again.history(SLIP, PRESSURE).traction, named.history(SLIP, PRESSURE).traction)
    # Penalty: a straight line to the limit, min(c + mu p, tau_max).
    limit = 2 + 0.4 * 100
    np.testing.assert_allclose(named.history([0.001], 100.0).traction, [limit / 3], rtol=1e-12)
    np.testing.assert_allclose(named.history([0.1], 1000.0).traction, [50], rtol=1e-12)
    assert repr(named) == "Law(mu=0.4, gcr=0.003, exponent=1.5, method=1, cohesion=2, tau_max=50, ndir=1)"
    assert mepc.PROPERTIES[:3] == ("mu", "gcr", "exponent") and len(mepc.PROPERTIES) == 16
    run_in = Law(mu=0.2, gcr=0.001, mu_late=0.6, slip_late=0.1, ndir=1)
    done = run_in.history([10.0, 1e-3], 100.0)  # the coefficient is that of the slip length before the increment
    np.testing.assert_allclose(done.traction, [20, 60], rtol=1e-12)
    segalman = Law(mu=0.3, gcr=0.002, backbone="segalman", exponent=1.5, beta=0.2, ndir=1)
    q, beta, s = 1.5, 0.2, 0.5
    exact = ((1 + beta) * q * s - s**q) / (q - 1 + beta * q)
    np.testing.assert_allclose(segalman.history([0.001], 100.0).traction, [LIMIT * exact], rtol=1e-12)


def test_state_names():
    names = law(ndir=2).state_names
    assert len(names) == 84 and len(set(names)) == 84
    assert names[:4] == ["ContactStatus", "Pressure", "ShearLimit", "StoredEnergy"]
    assert names[12:15] == ["Knot1_R", "Knot1_u1", "Knot1_u2"]


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: Law(mu=-0.1, gcr=GCR), ("mu", "-0.1")),
        (lambda: Law(mu=0.3, gcr=np.nan), ("gcr", "NaN")),
        (lambda: Law(mu=0.3, gcr=GCR, exponent=0.5), ("exponent", "0.5")),
        (lambda: Law(mu=0.3, gcr=GCR, mu_late=0.5), ("slip_late",)),
        (lambda: Law(mu=0.3, gcr=GCR, method="stick"), ("method", "'stick'", "'penalty'")),
        (lambda: Law(mu=0.3, gcr=GCR, ndir=3), ("ndir", "3")),
        (lambda: Law(mu=0.3, gcr=GCR, nstate=10), ("nstate", "10")),
        (lambda: law().update(law().virgin(3), [0, 0, 0], [1, -1, np.inf]), ("point 2", "pressure", "inf")),
        (lambda: law().update(np.ones((1, 44)), [0], 1.0), ("state",)),
        (lambda: law().update(np.zeros((1, 43)), [0], 1.0), ("states", "(1, 43)", "44")),
        (lambda: law(ndir=2).update(law(ndir=2).virgin(3), np.zeros(3), 1.0), ("slip", "(3,)", "(3, 2)")),
        (lambda: law().update(law().virgin(3), np.zeros(3), np.zeros(2)), ("pressure", "(2,)", "(3,)")),
        (lambda: law().history([0, np.nan], 1.0), ("slip_increment", "1")),
        (lambda: law(ndir=2).history(np.zeros((4, 3)), 1.0), ("slip", "(4, 3)")),
        (lambda: law().history(0.1, 1.0), ("slip",)),
        (lambda: law().history([0.1], 1.0, -1.0), ("mu_factor", "-1")),
        (lambda: law(kn=1).interface(law().virgin(2), np.zeros((2, 3))), ("opening", "(2, 3)", "(2, 2)")),
    ],
)
def test_refusals_name_the_argument(make, words):
    with pytest.raises(MepcError) as caught:
        make()
    text = str(caught.value)
    assert all(word in text for word in words), text
    assert caught.value.status < 0
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (str(copy), copy.status) == (text, caught.value.status)


def test_the_refused_point_is_named():
    one = law()
    pressure = np.full((2, 3), PRESSURE)
    pressure[1, 0] = np.nan
    with pytest.raises(MepcError) as caught:
        one.update(one.virgin(2, 3), np.zeros((2, 3)), pressure)
    assert caught.value.point == 3
    history = np.full((4, 5), PRESSURE)
    history[2, 3] = np.nan
    with pytest.raises(MepcError) as caught:
        one.history(np.zeros((4, 5)), history)
    assert caught.value.point == 2 and "3" in str(caught.value)


def test_a_full_memory_is_told():
    short = law(nstate=20)
    slip = np.diff(0.9 * GCR * (-0.9) ** np.arange(30), prepend=0)
    with pytest.warns(MepcWarning, match="full"):
        short.history(slip, PRESSURE)


def test_a_law_travels_and_is_shared():
    one = law(ndir=2, mu=0.25, threads=2)
    copy = pickle.loads(pickle.dumps(one))
    slip = walk((50, 2), seed=8)
    expected = one.history(slip, PRESSURE).traction
    np.testing.assert_array_equal(copy.history(slip, PRESSURE).traction, expected)
    found = [None] * 8

    def run(k):
        found[k] = one.history(slip, PRESSURE).traction

    threads = [threading.Thread(target=run, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for traction in found:
        np.testing.assert_array_equal(traction, expected)


def test_the_call_is_the_librarys():
    """Bit for bit what mepc_friction gives, called by hand."""
    import ctypes

    one = law(ndir=2)
    slip, state = walk((20, 2), seed=9), one.virgin()
    traction = np.empty((20, 2))
    for k in range(20):
        status = LIBRARY.mepc_friction(
            one._law, slip[k].ctypes.data_as(ctypes.c_void_p), ctypes.c_double(PRESSURE), None,
            state.ctypes.data_as(ctypes.c_void_p), state.ctypes.data_as(ctypes.c_void_p),
            traction[k].ctypes.data_as(ctypes.c_void_p), None, None, None)
        assert status >= 0
    np.testing.assert_array_equal(one.history(slip, PRESSURE).traction, traction)
