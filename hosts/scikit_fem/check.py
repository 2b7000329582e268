# SPDX-License-Identifier: MIT OR Apache-2.0
"""Checks the host on the small mesh: closed forms, convergence, a host's worst day. Exit code 1 if one fails."""

import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import run  # before numpy: it sets the number of threads
import host
import numpy as np
from mepc import Law, MepcError

STEPS = 24
MU_N = run.MU * host.LOAD
failures = []


def expect(what, value, bound):
    """The value must not exceed the bound (a NaN fails)."""
    good = bool(value <= bound)
    print(f"{'ok    ' if good else 'FAILED'} {what}: {value:.3g}, at most {bound:.3g}")
    if not good:
        failures.append(what)


def expect_same(what, *runs):
    """Bit-identical equilibria; compared as bytes, so that -0 and NaN count."""
    ends = {tuple(step.displacement.tobytes() + step.state.tobytes() for step in done) for done in runs}
    expect(f"{what}, differing results", len(ends) - 1, 0)


def expect_refused(what, call, *words):
    """The library's own words must reach the user, as an exception."""
    try:
        call()
        text = "nothing was raised"
    except MepcError as error:
        text = str(error)
    print(f"       {text}")
    expect(f"{what}, words missing from the message", sum(word not in text for word in words), 0)


def references(bodies):
    """Coulomb's limit, balance of reactions, energy."""
    for method in run.METHODS:
        area_error = []
        for steps in (STEPS, 2 * STEPS):
            table = run.loop(bodies, host.follow(bodies, Law(**run.properties(method)), run.history(steps)))
            area, dissipated = run.cycle(table, steps)
            area_error.append(abs(area / dissipated - 1))
        expect(f"{method}: plateau against mu N", abs(run.plateau(table, steps) - 1), 1e-6)
        unbalanced = np.abs(table["force_1"] + table["reaction_1"]).max()
        expect(f"{method}: reaction against force, over mu N", unbalanced / MU_N, 1e-9)
        expect(f"{method}: force beyond mu N, over mu N", np.abs(table["force_1"]).max() / MU_N - 1, 1e-9)
        expect(f"{method}: loop area against the library's dissipation", area_error[0], 1e-3)
        # The trapezoidal rule's error falls to a quarter.
        expect(f"{method}: the same, twice the steps over once", area_error[1] / area_error[0], 0.4)


def closed_form(x, chi):
    """Force over mu N of rigid bodies: the virgin curve, then Masing's branches (gross slip at both ends)."""
    def backbone(s):
        return 1 - np.clip(1 - s, 0, None) ** chi

    s, a = x / run.GCR, run.AMPLITUDE / run.GCR
    down, up = 1 - 2 * backbone((a - s) / 2), 2 * backbone((s + a) / 2) - 1
    return np.concatenate([backbone(s[:STEPS + 1]), down[STEPS + 1:3 * STEPS + 1], up[3 * STEPS + 1:]])


def bodies_alone(bodies):
    """What the condensed bodies know in closed form."""
    (x0, y0, z0), (x1, y1, z1) = host.CUBE
    area = (x1 - x0) * (y1 - y0)
    expect("contact area", abs(bodies.area.sum() / area - 1), 1e-12)
    # Without Poisson's ratio a cube pressed on a fixed bottom is a bar.
    bar = host.assemble(5, poisson=0).stiffness[-1, -1]
    expect("cube as a bar: stiffness against E A/h", abs(bar / (host.YOUNG * area / (z1 - z0)) - 1), 1e-10)
    # Fully integrated displacement elements are too stiff, the less so the finer the (nested) mesh.
    finer = host.assemble(2.5).stiffness[-3, -3]
    expect("cube in shear: stiffness, elements halved over once", finer / bodies.stiffness[-3, -3], 1)
    moved = np.zeros(len(bodies.stiffness))
    moved[3 * len(bodies.area):] = np.tile([1, 2, 3], len(bodies.area) + 1)
    forces = np.abs(bodies.stiffness @ moved).max()
    expect("cube moved as a whole: forces over stiffness", forces / bodies.stiffness.max(), 1e-12)


def rigid_limit():
    """Bodies 10^4 times as stiff: whatever the pressure distribution, the loop is the law's own."""
    bodies = host.assemble(5, young=1e4 * host.YOUNG)
    a = run.AMPLITUDE / run.GCR
    for method, chi in (("memory", run.CHI), ("penalty", 1)):
        # The proportional rule: the same critical slip under every pressure.
        done = host.follow(bodies, Law(**run.properties(method, reference_pressure=0)), run.history(STEPS))
        table = run.loop(bodies, done)
        error = np.abs(table["force_1"] / MU_N - closed_form(table["displacement_1"], chi)).max()
        expect(f"{method}, rigid bodies: loop against the closed form, over mu N", error, 1e-3)
        cycle = 4 * MU_N * run.GCR * (a - 2 / (chi + 1))
        sunk = -done[-1].displacement[-1] * host.KN * bodies.area.sum() / host.LOAD
        expect(f"{method}, rigid bodies: approach against N/(kn A)", abs(sunk - 1), 1e-2)
        expect(f"{method}, rigid bodies: dissipation per cycle", abs(run.cycle(table, STEPS)[1] / cycle - 1), 1e-4)


def penalty_limit(bodies):
    """chi = 1 is the standard penalty method."""
    one, other = (run.loop(bodies, host.follow(bodies, Law(**props), run.history(STEPS)))["force_1"]
                  for props in (run.properties("memory", chi=1), run.properties("penalty")))
    expect("memory with chi = 1 against the penalty method, over mu N", np.abs(one - other).max() / MU_N, 1e-9)


def quadratic(bodies):
    """|R_k+1| <= C |R_k|^2/|R_0| in the last two iterations that end above rounding."""
    rounding = 1e-9  # N: some ten times what is left of residuals that have converged
    done = host.follow(bodies, Law(**run.properties("memory")), run.history(STEPS)[:STEPS + 1])
    table = run.loop(bodies, done)
    for slip in ("micro_slip", "gross_slip"):
        # The virgin branch, all points in the wanted state before and after; the step in the middle of those.
        all_slip = table[slip] == len(bodies.area)
        steps = [k for k in range(1, STEPS) if all_slip[k] and all_slip[k - 1]]
        step = steps[len(steps) // 2]
        (norms,) = done[step].residuals
        print(f"       {len(bodies.area)} points, {slip}, x = {table['displacement_1'][step]:.6f} mm, |R| (N): "
              + " ".join(f"{norm:.2e}" for norm in norms))
        above = [norm for norm in norms if norm > rounding]
        ratios = [above[k + 1] * above[0] / above[k] ** 2 for k in (len(above) - 3, len(above) - 2)]
        expect(f"{slip}: C of the last two iterations", max(ratios), 1)


def line_search(bodies):
    """Almost rigid stick: Newton alone cycles between stick and slip, with the line search every step converges."""
    law, targets = Law(**run.properties("penalty", gcr=1e-6, reference_pressure=0)), run.history(4)
    done = host.follow(bodies, law, targets)
    expect("penalty, gcr 1 nm: plateau against mu N", abs(run.plateau(run.loop(bodies, done), 4) - 1), 1e-6)
    try:
        host.follow(bodies, law, targets, trials=1)
        converged = 1
    except host.NoEquilibrium as error:
        print(f"       without line search: {error}")
        converged = 0
    expect("the same without line search, runs that converge", converged, 0)


def worst_day(bodies):
    """Restart, rejected steps, threads."""
    law, targets = Law(**run.properties("memory")), run.history(STEPS)
    whole = host.follow(bodies, law, targets)

    half = 2 * STEPS  # in the middle of a branch
    with tempfile.TemporaryDirectory() as directory:
        file = Path(directory) / "restart.npz"
        np.savez(file, displacement=whole[half].displacement, state=whole[half].state)
        with np.load(file) as saved:
            begin = host.Equilibrium(saved["displacement"], saved["state"])
    rest = host.follow(bodies, Law(**run.properties("memory")), targets[half + 1:], begin)
    expect_same("restart from a file", whole[half + 1:], rest)

    # Steps that need more iterations than their halves: with no more than those allowed the host gives the step up and
    # cuts it in two. That must end where the two halves end that never saw a rejected step.
    rejected = 0
    for before, target in zip(whole, targets[1:]):
        middle = (before.displacement[-3] + target) / 2
        halves = host.follow(bodies, law, [middle, target], before)
        most = max(len(norms) - 1 for step in halves for norms in step.residuals)
        cut = host.advance(bodies, law, before, target, most=most)
        if len(cut.residuals) == 3:
            rejected += 1
            expect_same(f"step to {target:.6f} rejected, then its halves", [cut], halves[1:])
            expect("the same, dissipation", abs(cut.dissipated - sum(step.dissipated for step in halves)), 0)
    expect("steps rejected, fewer than 2", max(0, 2 - rejected), 0)
    wild = whole[:1]
    for target in targets[1:]:
        attempt, _ = host.newton(bodies, law, wild[-1], 1e3 * run.AMPLITUDE, most=1)
        if attempt is not None:
            raise SystemExit("the wild trial converged: it must be wilder")
        wild.append(host.advance(bodies, law, wild[-1], target))
    expect_same("a wild trial rejected before every step", whole, wild)

    for threads in (2, 0):
        threaded = Law(**run.properties("memory"), threads=threads)
        expect_same(f"threads = {threads} and 1", whole, host.follow(bodies, threaded, targets))
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda _: host.follow(bodies, law, targets), range(4)))
    expect_same("four runs at once with one law", whole, *together)
    opening = np.random.default_rng(1).normal(0, run.GCR, (20000, 3))
    answers = {b"".join(array.tobytes() for array in law.interface(law.virgin(len(opening)), opening))
               for law in (Law(**run.properties("memory"), threads=threads) for threads in (1, 2, 0))}
    expect("20000 points with 1, 2 and all threads, differing results", len(answers) - 1, 0)


def refusals():
    """Our message, as a Python exception."""
    props = run.properties("memory")
    law = Law(**props)
    state = law.virgin(1)
    state[0, 1] = np.nan
    expect_refused("no critical slip", lambda: Law(mu=run.MU), "gcr")
    expect_refused("a property out of range", lambda: Law(**run.properties("memory", chi=0.5)), "exponent", "0.5")
    expect_refused("no normal stiffness", lambda: Law(**props | {"kn": 0}).interface(law.virgin(1), np.zeros((1, 3))), "kn")
    expect_refused("too few state variables", lambda: Law(**props, nstate=5), "nstate", "5")
    expect_refused("a state of another length", lambda: law.interface(np.zeros((1, 44)), np.zeros((1, 3))), "state")
    expect_refused("a corrupt state", lambda: law.interface(state, np.zeros((1, 3))), "state", "Pressure")
    expect_refused("an infinite opening", lambda: law.interface(law.virgin(1), np.full((1, 3), np.inf)), "opening")


def main():
    bodies = host.assemble(5)
    bodies_alone(bodies)
    references(bodies)
    rigid_limit()
    penalty_limit(bodies)
    quadratic(bodies)
    quadratic(host.assemble(2))
    line_search(bodies)
    worst_day(bodies)
    refusals()
    print(f"{len(failures)} failed" + "".join(f"\n  {what}" for what in failures))
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
