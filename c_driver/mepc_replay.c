/* A worked example of the library's C interface: a table of numbers in, a table out. */
#include "mepc_replay.h"

#include <dlfcn.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "usage: mepc_replay point     LIBRARY PROPS HISTORY.csv [--nstate N]  time,slip_1[,slip_2],pressure\n"
    "       mepc_replay history   LIBRARY PROPS HISTORY.csv [--nstate N]  the same, all steps in one call\n"
    "       mepc_replay interface LIBRARY PROPS HISTORY.csv [--nstate N]  time,opening,jump_1[,jump_2]\n"
    "       mepc_replay patch     LIBRARY PROPS PATCH.csv HISTORY.csv [--nstate N] [--series K] [--parallel K]\n"
    "               x,y,area,pressure and time,displacement_1[,displacement_2,rotation][,pressure_scale]\n"
    "LIBRARY is the path of libmepc.so, PROPS the properties mu,gcr,exponent,... of the README's table.\n"
    "A row is the end of a step, the first one from zero slip and pressure. The table goes to standard output.\n";

static void fail_usage(const char *word) {
    fprintf(stderr, "mepc_replay: wrong command line at '%s'\n%s", word, usage);
    exit(2);
}

/* The headers of each kind of replay: first those with one direction. */
enum { POINT, HISTORY, INTERFACE, PATCH, KINDS };
static const char *const names[KINDS] = {"point", "history", "interface", "patch"};
static const char *const headers[KINDS][5] = {
    {"time,slip_1,pressure", "time,slip_1,slip_2,pressure"},
    {"time,slip_1,pressure", "time,slip_1,slip_2,pressure"},
    {"time,opening,jump_1", "time,opening,jump_1,jump_2"},
    {"time,displacement_1", "time,displacement_1,pressure_scale", "time,displacement_1,displacement_2,rotation",
     "time,displacement_1,displacement_2,rotation,pressure_scale"},
};
static const char *const results[KINDS][2] = {
    {"traction_1,stored_energy,dissipated_energy,status", "traction_1,traction_2,stored_energy,dissipated_energy,status"},
    {"traction_1,stored_energy,dissipated_energy", "traction_1,traction_2,stored_energy,dissipated_energy"},
    {"normal_traction,traction_1,stored_energy,dissipated_energy,status",
     "normal_traction,traction_1,traction_2,stored_energy,dissipated_energy,status"},
    {"slip_1,force_1,stored_energy,dissipated_energy,open,stick,micro_slip,gross_slip,iterations",
     "slip_1,slip_2,force_1,force_2,moment,stored_energy,dissipated_energy,open,stick,micro_slip,gross_slip,iterations"},
};

void check(replay *run, int32_t status, size_t row, const char *point) {
    if (status < 0) {
        fail("%s:%ld: %s%s", run->in.file, run->in.lines[row], point, run->lib.last_error());
    }
    run->memory_full += status == MEPC_MEMORY_FULL;
}

/* One point: friction form (step by step, or all steps in one call) or interface form. */
static void replay_point(replay *run, int kind) {
    size_t n = run->ndir, rows = run->in.count / run->in.columns, components = kind == INTERFACE ? 1 + n : n;
    double *state = allocate(run->nstate, sizeof(double)); /* zeros: virgin */
    double *increment = allocate(rows * n, sizeof(double)), *pressure = allocate(rows, sizeof(double));
    double *traction = allocate(rows * components, sizeof(double)), *energy = allocate(rows * 2, sizeof(double));
    double dissipated = 0.0;
    int32_t status = 0;
    for (size_t k = 0; k < rows; k++) {
        const double *in = run->in.values + k * run->in.columns; /* time, slip, pressure; or time, opening, jumps */
        for (size_t i = 0; i < n; i++) {
            increment[k * n + i] = in[1 + i] - (k > 0 ? in[1 + i - run->in.columns] : 0.0);
        }
        pressure[k] = in[1 + n];
        energy[2 * k] = NAN;
    }
    if (kind == HISTORY) { /* stops at a step that is refused; rows from there on are not written */
        status = run->lib.friction_history(run->law, (int64_t)rows, increment, pressure, NULL, state, traction, NULL, NULL,
                                           energy);
        run->memory_full += status == MEPC_MEMORY_FULL;
    }
    for (size_t k = 0; k < rows; k++) {
        const double *in = run->in.values + k * run->in.columns;
        /* These steps are known to be final, so the new state may overwrite the old one; no tangent is needed (NULL), nor a
         * factor on mu. A solver that iterates keeps the old state until the step is accepted: see patch.c. */
        if (kind == POINT) {
            status = run->lib.friction(run->law, increment + k * n, pressure[k], NULL, state, state, traction + k * n, NULL,
                                       NULL, energy + 2 * k);
        } else if (kind == INTERFACE) {
            status = run->lib.interface(run->law, in + 1, NULL, state, state, traction + k * components, NULL,
                                        energy + 2 * k);
        }
        if (isnan(energy[2 * k]) || kind != HISTORY) {
            check(run, status, k, "");
        }
        dissipated += energy[2 * k + 1]; /* energy: stored at the end, dissipated in the increment */
        table_add(&run->out, &run->in, k, in, run->in.columns);
        table_add(&run->out, &run->in, k, traction + k * components, components);
        table_add(&run->out, &run->in, k, energy + 2 * k, 1);
        table_add(&run->out, &run->in, k, &dissipated, 1);
        table_add(&run->out, &run->in, k, state, kind != HISTORY); /* the contact status */
    }
    double *arrays[] = {state, increment, pressure, traction, energy};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        free(arrays[i]);
    }
}

/* Checks the properties once and for all. */
static void make_law(replay *run, char *list, double nstate) {
    double props[64];
    int32_t nprops = 0;
    for (char *entry = list, *comma = list; comma != NULL; entry = comma + 1) {
        comma = strchr(entry, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        if (nprops == 64 || !read_number(entry, &props[nprops++])) {
            fail_usage(entry);
        }
    }
    int32_t ndir = (int32_t)run->ndir;
    int32_t size = nstate > 0.0 ? (int32_t)nstate : run->lib.state_size(props, nprops, ndir);
    if (size < 0 || run->lib.law_new(props, nprops, ndir, size, &run->law) < 0) {
        fail("PROPS or --nstate: %s", run->lib.last_error());
    }
    run->nstate = (size_t)size;
}

int main(int argc, char **argv) {
    static const char *const patch_headers[] = {"x,y,area,pressure", NULL};
    int kind = 0;
    while (argc > 1 && kind < KINDS && strcmp(argv[1], names[kind]) != 0) {
        kind++;
    }
    int files = kind == PATCH ? 2 : 1;
    if (argc < 4 + files || kind == KINDS) {
        fail_usage(argc > 1 ? argv[1] : "");
    }
    replay run = {0};
    double nstate = 0.0;
    for (int i = 4 + files; i < argc; i += 2) {
        double *value = strcmp(argv[i], "--nstate") == 0     ? &nstate
                        : strcmp(argv[i], "--series") == 0   ? &run.series
                        : strcmp(argv[i], "--parallel") == 0 ? &run.parallel
                                                             : NULL;
        if (value == NULL || i + 1 == argc || !read_number(argv[i + 1], value) || *value < 0.0 || nstate > 1e6) {
            fail_usage(argv[i]);
        }
    }
    run.in = table_read(argv[3 + files], headers[kind]);
    run.ndir = run.in.header == headers[kind][0] || strstr(run.in.header, "_2") == NULL ? 1 : 2;
    run.lib = library_open(argv[2]);
    make_law(&run, argv[3], nstate);
    table points = {0};
    if (kind == PATCH) {
        points = table_read(argv[4], patch_headers);
        replay_patch(&run, &points);
    } else {
        replay_point(&run, kind);
    }
    /* The table is complete: a run that fails leaves no half one. Seventeen digits: a reader gets the numbers back. */
    size_t columns = run.out.count / (run.in.count / run.in.columns);
    printf("%s,%s\n", run.in.header, results[kind][run.ndir - 1]);
    for (size_t i = 0; i < run.out.count; i++) {
        printf("%.17g%c", run.out.values[i], (i + 1) % columns == 0 ? '\n' : ',');
    }
    if (fflush(stdout) != 0 || ferror(stdout)) {
        fail("standard output: %s", strerror(errno));
    }
    if (run.memory_full > 0) {
        fprintf(stderr, "mepc_replay: note: a knot that mattered was dropped in %ld updates, a longer state keeps it\n",
                run.memory_full);
    }
    run.lib.law_free(run.law);
    dlclose(run.lib.handle);
    table *tables[] = {&run.in, &run.out, &points};
    for (size_t i = 0; i < 3; i++) {
        free(tables[i]->values);
        free(tables[i]->lines);
    }
    return 0;
}
