/* Mode patch: reads the history, advances the patch row by row, writes the table. */
#include "patch.h"

#include "report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* The columns of a patch history; those that are absent are NULL. */
typedef struct {
    csv_table table;
    double *time;
    double *displacement[2];
    double *rotation;
    double *pressure_scale;
} patch_history;

static double *column_if_there(const csv_table *table, const char *name) {
    return csv_has(table, name) ? csv_column(table, name) : NULL;
}

static patch_history read_history(const char *file) {
    patch_history h = {.table = csv_read(file)};
    h.time = csv_time(&h.table);
    h.displacement[0] = csv_column(&h.table, "displacement_1");
    h.displacement[1] = column_if_there(&h.table, "displacement_2");
    h.rotation = column_if_there(&h.table, "rotation");
    h.pressure_scale = column_if_there(&h.table, "pressure_scale");
    if (h.rotation != NULL && h.displacement[1] == NULL) {
        fail("%s:%ld: column displacement_2: missing in the header, rotation needs two directions", file,
             h.table.header_line);
    }
    csv_note_unused(&h.table);
    return h;
}

static void free_history(patch_history *h) {
    free(h->time);
    free(h->displacement[0]);
    free(h->displacement[1]);
    free(h->rotation);
    free(h->pressure_scale);
    csv_free(&h->table);
}

static motion motion_at(const patch_history *h, size_t row) {
    motion m = {{h->displacement[0][row], 0.0}, 0.0, 1.0};
    if (h->displacement[1] != NULL) {
        m.displacement[1] = h->displacement[1][row];
    }
    if (h->rotation != NULL) {
        m.rotation = h->rotation[row];
    }
    if (h->pressure_scale != NULL) {
        m.pressure_scale = h->pressure_scale[row];
    }
    return m;
}

static void put_row(const patch *p, double time, int turns, int iterations, const char *where) {
    replay *run = p->run;
    size_t first = run->count;
    long count[CONTACT_KINDS];
    replay_put(run, time);
    for (int32_t a = 0; a < run->ndir; a++) {
        replay_put(run, p->at.displacement[a]);
    }
    if (turns) {
        replay_put(run, p->at.rotation);
    }
    for (int32_t a = 0; a < run->ndir; a++) {
        replay_put(run, p->slip[a]);
    }
    for (int32_t a = 0; a < run->ndir; a++) {
        replay_put(run, p->force[a] + run->given->parallel * p->at.displacement[a]);
    }
    if (turns) {
        replay_put(run, p->moment);
    }
    replay_put(run, p->stored);
    replay_put(run, p->dissipated);
    patch_count(p, count);
    for (int kind = 0; kind < CONTACT_KINDS; kind++) {
        replay_put(run, (double)count[kind]);
    }
    replay_put(run, iterations);
    for (size_t i = first; i < run->count; i++) {
        if (!isfinite(run->values[i])) { /* a sum or product here: what the library gives is finite */
            fail("%s: the result is not a finite number", where);
        }
    }
}

void replay_patch(const options *given) {
    patch_history history = read_history(given->history);
    int two = history.displacement[1] != NULL;
    int turns = history.rotation != NULL;
    replay run = replay_begin(given, two ? 2 : 1);
    patch p = patch_read(given->patch, &run);

    for (size_t row = 0; row < history.table.rows; row++) {
        char where[1024];
        motion target = motion_at(&history, row);
        snprintf(where, sizeof where, "%s:%ld: step %lu", history.table.file, history.table.lines[row],
                 (unsigned long)row + 1);
        int iterations = patch_advance(&p, &target, where);
        put_row(&p, history.time[row], turns, iterations, where);
    }
    patch_free(&p);
    char header[256];
    snprintf(header, sizeof header,
             "time,displacement_1%s%s,slip_1%s,force_1%s%s,stored_energy,dissipated_energy,open,stick,micro_slip,"
             "gross_slip,iterations",
             two ? ",displacement_2" : "", turns ? ",rotation" : "", two ? ",slip_2" : "", two ? ",force_2" : "",
             turns ? ",moment" : "");
    replay_end(&run, header);
    free_history(&history);
}
