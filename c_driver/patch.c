/* Contact points under one rigid tangential motion, behind a spring K. The displacement u is prescribed beyond the
 * spring; the slip g that the points share follows from
 *
 *     r(g) = K (g - u) + sum of A_i tau_i(g) = 0
 *
 * by Newton's method with the law's tangent. Every trial starts from the states of the last accepted step, so that a
 * trial leaves no trace unless its states are kept. */
#include "mepc_replay.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { X, Y, AREA, PRESSURE, POINT_COLUMNS, SHEAR_LIMIT = 2, MAX_ITERATIONS = 100, MAX_HALVINGS = 40 };

/* A residual below this part of the forces at hand is rounding of the sums. */
static const double TOLERANCE = 1e-13;

/* A step on trial: the library's arrays, point after point, and sums over the points. */
typedef struct {
    replay *run;
    const double *points;
    const table *table;
    size_t count, row;
    double *increment, *pressure, *state0, *state1, *traction, *tangent, *energy;
    int32_t *statuses;
    double way[2], turn, scale; /* prescribed: displacement beyond the slip, rotation, factor on the pressures */
    double force[2], stiffness[2][2], moment, stored, dissipated, limit;
} trial;

/* Tries a common slip increment: one call of the library for all points, then the sums. */
static void evaluate(trial *t, const double slip[2]) {
    replay *run = t->run;
    size_t n = run->ndir;
    for (size_t i = 0; i < t->count; i++) {
        const double *point = t->points + POINT_COLUMNS * i;
        t->increment[n * i] = slip[0] - t->turn * point[Y];
        t->increment[n * i + n - 1] = n == 2 ? slip[1] + t->turn * point[X] : slip[0];
        t->pressure[i] = t->scale * point[PRESSURE];
    }
    int32_t worst = run->lib.friction_batch(run->law, (int64_t)t->count, t->increment, t->pressure, NULL, t->state0,
                                            t->state1, t->traction, t->tangent, NULL, t->energy, t->statuses, 1);
    for (size_t i = 0; worst < 0 && i < t->count; i++) {
        if (t->statuses[i] == worst) { /* the message is about the first of them */
            char place[1024];
            snprintf(place, sizeof place, "point at %s:%ld: ", t->table->file, t->table->lines[i]);
            check(run, worst, t->row, place);
        }
    }
    t->force[0] = t->force[1] = t->moment = t->stored = t->dissipated = t->limit = 0.0;
    t->stiffness[0][0] = t->stiffness[0][1] = t->stiffness[1][0] = t->stiffness[1][1] = 0.0;
    for (size_t i = 0; i < t->count; i++) {
        const double *point = t->points + POINT_COLUMNS * i, *traction = t->traction + n * i;
        for (size_t a = 0; a < n; a++) {
            t->force[a] += point[AREA] * traction[a];
            for (size_t b = 0; b < n; b++) {
                t->stiffness[a][b] += point[AREA] * t->tangent[n * n * i + n * a + b]; /* d traction_a / d slip_b */
            }
        }
        t->moment += n == 2 ? point[AREA] * (point[X] * traction[1] - point[Y] * traction[0]) : 0.0;
        t->stored += point[AREA] * t->energy[2 * i];
        t->dissipated += point[AREA] * t->energy[2 * i + 1];
        t->limit += point[AREA] * t->state1[run->nstate * i + SHEAR_LIMIT];
    }
}

/* The residual of the trial that was evaluated last; returns its length. */
static double residual(const trial *t, const double slip[2], double r[2]) {
    for (size_t a = 0; a < 2; a++) {
        r[a] = a < t->run->ndir ? t->run->series * (slip[a] - t->way[a]) + t->force[a] : 0.0;
    }
    return hypot(r[0], r[1]);
}

/* Finds the slip increment in equilibrium and leaves it evaluated; returns the number of iterations, -1 if none. */
static int solve(trial *t, double slip[2]) {
    double series = t->run->series, spring = series * hypot(t->way[0], t->way[1]), r[2];
    slip[0] = slip[1] = 0.0;
    evaluate(t, slip);
    double length = residual(t, slip, r);
    for (int iteration = 0; isfinite(spring) && iteration < MAX_ITERATIONS; iteration++) {
        if (length <= TOLERANCE * (t->limit + spring)) {
            return iteration;
        }
        /* -J^-1 r with J = K I + d force / d slip, by elimination. */
        double a = series + t->stiffness[0][0], b = t->stiffness[0][1];
        double c = t->stiffness[1][0] / a, d = series + t->stiffness[1][1];
        double second = -(r[1] - c * r[0]) / (d - c * b), direction[2] = {-(r[0] + b * second) / a, second};
        /* Half of the way again and again until the residual falls: the stiffness jumps where the motion turns. */
        double start[2] = {slip[0], slip[1]}, before = length, part = 1.0;
        for (int halving = 0; halving == 0 || !(length < before); halving++, part *= 0.5) {
            slip[0] = start[0] + part * direction[0];
            slip[1] = start[1] + part * direction[1];
            if (halving == MAX_HALVINGS || !isfinite(slip[0] + slip[1])) {
                return -1;
            }
            evaluate(t, slip);
            length = residual(t, slip, r);
        }
    }
    return -1;
}

void replay_patch(replay *run, const table *points) {
    size_t n = run->ndir, count = points->count / POINT_COLUMNS, rows = run->in.count / run->in.columns;
    trial t = {.run = run, .points = points->values, .table = points, .count = count};
    double *block = allocate(count * (3 + 2 * n + n * n + 2 * run->nstate), sizeof(double));
    t.increment = block;
    t.pressure = t.increment + count * n;
    t.traction = t.pressure + count;
    t.tangent = t.traction + count * n;
    t.energy = t.tangent + count * n * n;
    t.state0 = t.energy + count * 2; /* zeros: virgin */
    t.state1 = t.state0 + count * run->nstate;
    t.statuses = allocate(count, sizeof *t.statuses);
    double at[2] = {0.0, 0.0}, rotation = 0.0, dissipated = 0.0, slip[2];
    for (t.row = 0; t.row < rows; t.row++) {
        const double *in = run->in.values + t.row * run->in.columns; /* time, displacement, [rotation], [scale] */
        for (size_t a = 0; a < n; a++) {
            slip[a] = t.way[a] = in[1 + a] - at[a];
        }
        t.turn = n == 2 ? in[3] - rotation : 0.0;
        t.scale = run->in.columns % 2 == 1 ? in[run->in.columns - 1] : 1.0;
        int iterations = 0;
        if (run->series > 0.0) {
            iterations = solve(&t, slip);
        } else {
            evaluate(&t, slip); /* rigid: the slip is prescribed */
        }
        if (iterations < 0) {
            fail("%s:%ld: no equilibrium: Newton's method does not converge", run->in.file, run->in.lines[t.row]);
        }
        double *accepted = t.state1, contacts[4] = {0.0, 0.0, 0.0, 0.0}, total[2];
        t.state1 = t.state0;
        t.state0 = accepted;
        rotation += t.turn;
        dissipated += t.dissipated;
        for (size_t a = 0; a < n; a++) {
            at[a] += slip[a];
            total[a] = t.force[a] + run->parallel * in[1 + a];
        }
        for (size_t i = 0; i < count; i++) {
            contacts[(int)accepted[run->nstate * i]] += 1.0; /* open, stick, micro-slip, gross slip */
            run->memory_full += t.statuses[i] == MEPC_MEMORY_FULL;
        }
        table_add(&run->out, &run->in, t.row, in, run->in.columns);
        table_add(&run->out, &run->in, t.row, at, n);
        table_add(&run->out, &run->in, t.row, total, n);
        table_add(&run->out, &run->in, t.row, &t.moment, n - 1);
        double last[] = {t.stored, dissipated, contacts[0], contacts[1], contacts[2], contacts[3], iterations};
        table_add(&run->out, &run->in, t.row, last, 7);
    }
    free(block);
    free(t.statuses);
}
