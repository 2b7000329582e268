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

/* One point: what goes in and comes out, step after step. */
typedef struct {
    size_t rows;
    double *increment, *pressure, *state, *traction, *energy, *contact;
} point;

/* Friction form, one call for each step. The steps are known to be final, so the new state may overwrite the old one;
 * no factor on mu and no tangent is needed (NULL). A solver that iterates keeps the old state until the step is
 * accepted: see patch.c. */
static void step_by_step(replay *run, point *p) {
    size_t n = run->ndir;
    for (size_t k = 0; k < p->rows; k++) {
        int32_t status = run->lib.friction(run->law, p->increment + k * n, p->pressure[k], NULL, p->state, p->state,
                                           p->traction + k * n, NULL, NULL, p->energy + 2 * k);
        check(run, status, k, "");
        p->contact[k] = p->state[0];
    }
}

/* Friction form, all steps in one call. It stops at a step that is refused; rows from there on are not written. */
static void at_once(replay *run, point *p) {
    size_t row = 0;
    for (size_t k = 0; k < p->rows; k++) {
        p->energy[2 * k] = NAN;
    }
    int32_t status = run->lib.friction_history(run->law, (int64_t)p->rows, p->increment, p->pressure, NULL, p->state,
                                               p->traction, NULL, NULL, p->energy);
    while (row + 1 < p->rows && !isnan(p->energy[2 * row])) {
        row++;
    }
    check(run, status, row, "");
}

/* Interface form: total opening in (normal, positive when apart; then tangential), traction out in the same order. */
static void by_openings(replay *run, point *p) {
    size_t components = 1 + run->ndir;
    for (size_t k = 0; k < p->rows; k++) {
        int32_t status = run->lib.interface(run->law, run->in.values + k * run->in.columns + 1, NULL, p->state, p->state,
                                            p->traction + k * components, NULL, p->energy + 2 * k);
        check(run, status, k, "");
        p->contact[k] = p->state[0];
    }
}

static void replay_point(replay *run, int kind) {
    size_t n = run->ndir, columns = run->in.columns, rows = run->in.count / columns;
    size_t components = kind == INTERFACE ? 1 + n : n;
    double *block = allocate(rows * (n + components + 4) + run->nstate, sizeof *block), dissipated = 0.0;
    point p = {.rows = rows, .increment = block, .pressure = block + rows * n};
    p.traction = p.pressure + rows;
    p.energy = p.traction + rows * components; /* stored at the end, dissipated in the increment */
    p.contact = p.energy + rows * 2;
    p.state = p.contact + rows; /* zeros: virgin */
    for (size_t k = 0; k < rows; k++) {
        const double *in = run->in.values + k * columns; /* time, slip, pressure; or time, opening, jumps */
        for (size_t i = 0; i < n; i++) {
            p.increment[k * n + i] = in[1 + i] - (k > 0 ? in[1 + i - columns] : 0.0);
        }
        p.pressure[k] = in[1 + n];
    }
    if (kind == POINT) {
        step_by_step(run, &p);
    } else if (kind == HISTORY) {
        at_once(run, &p);
    } else {
        by_openings(run, &p);
    }
    for (size_t k = 0; k < rows; k++) {
        dissipated += p.energy[2 * k + 1];
        table_add(&run->out, &run->in, k, run->in.values + k * columns, columns);
        table_add(&run->out, &run->in, k, p.traction + k * components, components);
        table_add(&run->out, &run->in, k, p.energy + 2 * k, 1);
        table_add(&run->out, &run->in, k, &dissipated, 1);
        table_add(&run->out, &run->in, k, p.contact + k, kind != HISTORY);
    }
    free(block);
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
