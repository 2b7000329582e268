# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the paper gives for its lap joint: Tables 1 to 4, and what follows from them."""

import numpy as np

REFERENCE = {"preload": 900, "mu": 0.3, "amplitude": 0.02}
# k_alpha (N/mm), F_s (N), X_s (mm), kappa
PRELOAD = {  # Table 2
    300: (2996.4, 89.70, 0.0032, -0.644),
    500: (3058.9, 149.02, 0.0036, -0.611),
    700: (3158.3, 208.09, 0.0039, -0.755),
    900: (3280.7, 266.78, 0.0041, -0.842),
    1100: (3351.4, 325.38, 0.0044, -0.931),
}
FRICTION = {  # Table 3; its F_s from .2 on contradicts Table 2 at the same state
    0.1: (2753.1, 89.03, 0.0032, -0.551),
    0.2: (3137.3, 150.98, 0.0037, -0.688),
    0.3: (3280.7, 219.05, 0.0041, -0.748),
    0.4: (3338.4, 307.33, 0.0048, -0.828),
    0.5: (3365.2, 393.15, 0.0053, -0.931),
}
AMPLITUDE = {  # Table 4
    0.005: (3318.6, 265.35, 0.0041, -0.909),
    0.010: (3297.2, 265.82, 0.0041, -0.864),
    0.015: (3290.1, 266.66, 0.0043, -0.828),
    0.020: (3280.7, 266.78, 0.0041, -0.842),
    0.025: (3270.9, 266.11, 0.0039, -0.930),
}


def loss(amplitude, F_s, X_s, kappa):
    """Energy per cycle of the four-parameter Iwan model, N mm."""
    chi, a = 2.5 + kappa, amplitude / X_s
    if a >= 1:
        return 4 * F_s * X_s * (a - 2 / (chi + 1))
    return F_s * X_s * (4 * a + 4 * a * (1 - a) ** chi - 8 / (chi + 1) * (1 - (1 - a) ** (chi + 1)))


def slip_and_stiffness(force, X_s):
    """X_s = gcr + force / K_e by regression: gcr (mm) and K_e (N/mm)."""
    slope, intercept = np.polyfit(force, X_s, 1)
    return intercept, 1 / slope


def regression():
    """gcr (mm) and K_e (N/mm) from X_s against mu P of Tables 2 and 3."""
    states = [(0.3 * P, row[2]) for P, row in PRELOAD.items()] + [(900 * mu, row[2]) for mu, row in FRICTION.items()]
    return slip_and_stiffness(*zip(*states))


def predict(preload, mu, amplitude):
    """What the paper's tables make one expect of a joint that is not in them."""
    P = np.array(list(PRELOAD))
    force = mu * preload
    # F_s from Table 2; X_s from Tables 2 and 3 against mu P; k_alpha linear in P (Table 2) and quadratic in mu (Table 3).
    ratio, constant = np.polyfit(0.3 * P, [row[1] for row in PRELOAD.values()], 1)
    gcr, K_e = regression()
    along_P = np.polyfit(P, [row[0] for row in PRELOAD.values()], 1)
    along_mu = np.polyfit(list(FRICTION), [row[0] for row in FRICTION.values()], 2)
    along_kappa = np.polyfit(*zip(*[(0.3 * p, row[3]) for p, row in PRELOAD.items()]), 1)
    F_s, X_s, kappa = ratio * force + constant, gcr + force / K_e, np.polyval(along_kappa, force)
    k_alpha = np.polyval(along_P, preload) + np.polyval(along_mu, mu) - np.polyval(along_mu, 0.3)
    return {
        "k_alpha_N_per_mm": k_alpha, "F_s_N": F_s, "X_s_mm": X_s, "kappa": kappa,
        "dissipation_Nmm": loss(amplitude, F_s, X_s, kappa),
    }
