// SPDX-License-Identifier: MIT OR Apache-2.0
// A batch of points with one increment each; tractions against mu p [1 - (1 - s)^2.5].
#include <cmath>
#include <cstdio>
#include <memory>
#include <mepc.h>
#include <vector>

int main()
{
    const double props[] = {0.3, 0.002, 2.5, 0, 100};
    const int32_t nstate = mepc_state_size(props, 5, 2);
    mepc_law *made = nullptr;
    if (nstate < 0 || mepc_law_new(props, 5, 2, nstate, &made) < 0) {
        std::fprintf(stderr, "%s\n", mepc_last_error());
        return 1;
    }
    const std::unique_ptr<mepc_law, void (*)(mepc_law *)> law(made, mepc_law_free);
    const std::size_t points = 50;
    std::vector<double> slip(2 * points), pressure(points, 100.0), state(nstate * points), traction(2 * points);
    for (std::size_t k = 0; k < points; ++k) {
        slip[2 * k] = 0.6 * 0.002 * k / points; // a direction of 3 to 4, so that the length is a decimal number
        slip[2 * k + 1] = 0.8 * 0.002 * k / points;
    }
    if (mepc_friction_batch(law.get(), points, slip.data(), pressure.data(), nullptr, state.data(), state.data(),
                            traction.data(), nullptr, nullptr, nullptr, nullptr, 1) < 0) {
        std::fprintf(stderr, "%s\n", mepc_last_error());
        return 1;
    }
    for (std::size_t k = 0; k < points; ++k) {
        const double exact = 30 * (1 - std::pow(1 - double(k) / points, 2.5));
        const double found = std::hypot(traction[2 * k], traction[2 * k + 1]);
        if (std::fabs(found - exact) > 1e-10) {
            std::fprintf(stderr, "point %zu: %.12g, expected %.12g\n", k, found, exact);
            return 1;
        }
    }
    std::puts("50 points");
}
