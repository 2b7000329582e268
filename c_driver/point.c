/* Mode point: the shortest complete use of the friction form. */
#include "replay.h"

#include "csv.h"
#include "report.h"

#include <stdlib.h>

void replay_point(const options *given) {
    csv_table history = csv_read(given->history);
    double *time = csv_time(&history);
    int32_t ndir = csv_has(&history, "slip_2") ? 2 : 1;
    double *slip[2] = {csv_column(&history, "slip_1"), ndir == 2 ? csv_column(&history, "slip_2") : NULL};
    double *pressure = csv_column(&history, "pressure");
    csv_note_unused(&history);

    replay run = replay_begin(given, ndir);
    double *state = allocate((size_t)run.nstate, sizeof *state); /* all zero: virgin */
    double dissipated = 0.0;
    for (size_t row = 0; row < history.rows; row++) {
        double increment[2] = {0.0, 0.0};
        for (int32_t i = 0; i < ndir; i++) {
            increment[i] = slip[i][row] - (row > 0 ? slip[i][row - 1] : 0.0);
        }
        double traction[2];
        double energy[2]; /* stored at the end, dissipated in the increment */
        /* The step is known to be final, so the new state may overwrite the old one, and no tangent is needed. */
        int32_t status =
            run.lib.friction(run.law, increment, pressure[row], state, state, traction, NULL, NULL, energy);
        if (status < 0) {
            fail("%s:%ld: step %lu: %s", history.file, history.lines[row], (unsigned long)row + 1,
                 run.lib.last_error());
        }
        run.memory_full += status > 0;
        dissipated += energy[1];

        replay_put(&run, time[row]);
        for (int32_t i = 0; i < ndir; i++) {
            replay_put(&run, slip[i][row]);
        }
        replay_put(&run, pressure[row]);
        for (int32_t i = 0; i < ndir; i++) {
            replay_put(&run, traction[i]);
        }
        replay_put(&run, energy[0]);
        replay_put(&run, dissipated);
        replay_put(&run, state[0]);
    }
    replay_end(&run, ndir == 1 ? "time,slip_1,pressure,traction_1,stored_energy,dissipated_energy,status"
                               : "time,slip_1,slip_2,pressure,traction_1,traction_2,stored_energy,dissipated_energy,status");

    free(state);
    free(time);
    free(slip[0]);
    free(slip[1]);
    free(pressure);
    csv_free(&history);
}
