/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Three increments of one point; tractions against Masing's rules on f(s) = 1 - (1 - s)^2.5. */
#include <math.h>
#include <mepc.h>
#include <stdio.h>
#include <stdlib.h>

static double f(double s) { return 1 - pow(1 - s, 2.5); }

int main(void)
{
    const double props[] = {0.3, 0.002, 2.5, 0, 100}; /* mu, gcr (mm), chi, memory, reference pressure (MPa) */
    const double slip[] = {0.001, -0.0015, 0.0005};
    const double exact[] = {30 * f(0.5), 30 * (f(0.5) - 2 * f(0.375)), 30 * (f(0.5) - 2 * f(0.375) + 2 * f(0.125))};
    mepc_law *law = NULL;
    int32_t nstate = mepc_state_size(props, 5, 1);
    if (mepc_abi_version() != MEPC_ABI_VERSION || nstate < 0 || mepc_law_new(props, 5, 1, nstate, &law) < 0) {
        fprintf(stderr, "%s\n", mepc_last_error());
        return EXIT_FAILURE;
    }
    double *state = calloc((size_t)nstate, sizeof *state);
    for (int i = 0; i < 3; ++i) {
        double traction;
        if (mepc_friction(law, &slip[i], 100.0, NULL, state, state, &traction, NULL, NULL, NULL) < 0 ||
            fabs(traction - exact[i]) > 1e-10) {
            fprintf(stderr, "increment %d: %.12g, expected %.12g; %s\n", i, traction, exact[i], mepc_last_error());
            return EXIT_FAILURE;
        }
        printf("%.6f ", traction);
    }
    puts(mepc_version());
    free(state);
    mepc_law_free(law);
    return EXIT_SUCCESS;
}
