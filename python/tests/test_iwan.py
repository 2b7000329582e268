# SPDX-License-Identifier: MIT OR Apache-2.0
"""The joint model: closed forms, and parameters found again."""

import numpy as np
import pytest

import mepc
from mepc import Iwan, MepcError

JOINT = Iwan(F_s=266.78, X_s=0.0041, k_alpha=3280.7, kappa=-0.842)
AMPLITUDE = 0.02


def backbone(x):
    return JOINT.F_s * (1 - (1 - np.minimum(x / JOINT.X_s, 1)) ** JOINT.chi) + JOINT.k_alpha * x


def test_forces_are_masings():
    x, force = JOINT.loop(AMPLITUDE, 101)
    peak = backbone(AMPLITUDE)
    up, down = force[:101], force[101:]
    np.testing.assert_allclose(up, -peak + 2 * backbone((x[:101] + AMPLITUDE) / 2), atol=1e-10 * peak)
    np.testing.assert_allclose(down, -up, atol=1e-10 * peak)
    assert JOINT.chi == 2.5 - 0.842


def test_wrong_branches_are_refused():
    for branch in (0, 2, 257, np.nan, 1.5):
        with pytest.raises(MepcError, match="branch"):
            JOINT.force([0.0], branch, AMPLITUDE)
    with pytest.raises(MepcError, match="amplitude"):
        JOINT.force([0.0], 1, -1.0)
    with pytest.raises(MepcError):
        Iwan(-1.0, 0.004, 0.0, 0.0).force([0.0], 1, 1.0)


@pytest.mark.parametrize("method, noise, allowed", [("least_squares", 0.0, 1e-6), ("least_squares", 0.005, 0.05)])
def test_parameters_are_found_again(method, noise, allowed):
    x, force = JOINT.loop(AMPLITUDE)
    force = force + noise * np.abs(force).max() * np.random.default_rng(1).standard_normal(force.size)
    found = mepc.identify(x, force, method)
    assert found.described
    for name in ("F_s", "X_s", "k_alpha", "kappa"):
        assert abs(getattr(found.joint, name) / getattr(JOINT, name) - 1) < allowed, name
    assert found.standard_errors.shape == (4,)
    # The misfit is the noise, over the largest force.
    assert abs(found.misfit - noise) < 0.2 * noise + 1e-6


def test_the_papers_procedure_is_rougher():
    found = mepc.identify(*JOINT.loop(AMPLITUDE), method="paper")
    assert abs(found.joint.F_s / JOINT.F_s - 1) < 0.01


def test_refusals_of_data():
    x, force = JOINT.loop(AMPLITUDE)
    with pytest.raises(MepcError, match="shapes"):
        mepc.identify(x, force[1:])
    with pytest.raises(MepcError, match="method"):
        mepc.identify(x, force, "by eye")
    with pytest.raises(MepcError, match="gross slip"):
        mepc.identify(*JOINT.loop(0.3 * JOINT.X_s))


def test_calibration_by_the_tool():
    mu, area = 0.3, 361.52
    loops, preloads = [], [300.0, 700.0, 1100.0]
    for preload in preloads:
        # A contact of gcr = 3e-3 mm, chi = 2.5, behind a spring of 2e5 N/mm, beside one of 3000 N/mm.
        force_c = np.linspace(0, 1, 400)[:-1] * mu * preload
        slip = 3e-3 * (1 - (1 - force_c / (mu * preload)) ** 0.4)
        x = slip + force_c / 2e5

        def first(u, x=x, force_c=force_c, limit=mu * preload):
            return np.interp(u, x, force_c, right=limit) + 3000 * u

        up = np.linspace(-0.02, 0.02, 400)
        rise = -first(0.02) + 2 * first((up + 0.02) / 2)
        loops.append((np.concatenate([up, up[::-1]]), np.concatenate([rise, -rise])))
    found = mepc.calibrate(loops, preloads, area)
    assert abs(found["mu"] / mu - 1) < 0.02
    assert abs(found["gcr"] / 3e-3 - 1) < 0.1
    assert abs(found["K_e"] / 2e5 - 1) < 0.1
    with pytest.raises(MepcError, match="area"):
        mepc.calibrate(loops, preloads, -1.0)
    with pytest.raises(MepcError, match="3 loops and 2 preloads"):
        mepc.calibrate(loops, preloads[:2], area)
