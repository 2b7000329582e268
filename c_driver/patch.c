/* Equilibrium of a patch with its series spring:
 *
 *     r(g) = K (g - u) + sum of A_i tau_i(g) = 0
 *
 * u is prescribed, g is the slip that the points share (plus the rotation, which does not pass through the spring).
 * Newton with the consistent tangent of the law. The law is never told of an iteration: each one starts from the states of
 * the last accepted step, so a step that fails is forgotten by not committing it. */
#include "patch.h"

#include "report.h"

#include <math.h>
#include <stdlib.h>

enum {
    MAX_ITERATIONS = 50,
    MAX_BACKTRACKS = 30,
    MAX_HALVINGS = 12
};

/* A residual below this part of the forces at hand is rounding of the sums. */
static const double TOLERANCE = 1e-13;

patch patch_read(const char *file, replay *run) {
    patch p = {.run = run, .table = csv_read(file)};
    p.x = csv_column(&p.table, "x");
    p.y = csv_column(&p.table, "y");
    p.area = csv_column(&p.table, "area");
    p.reference_pressure = csv_column(&p.table, "pressure");
    csv_note_unused(&p.table);
    for (size_t i = 0; i < p.table.rows; i++) {
        if (p.area[i] < 0.0) {
            fail("%s:%ld: column area: %s is negative", file, p.table.lines[i], csv_field(&p.table, "area", i));
        }
    }
    size_t points = p.table.rows;
    size_t ndir = (size_t)run->ndir;
    p.points = (int64_t)points;
    p.state0 = allocate(points * (size_t)run->nstate, sizeof(double)); /* all zero: virgin */
    p.state1 = allocate(points * (size_t)run->nstate, sizeof(double));
    p.increment = allocate(points * ndir, sizeof(double));
    p.pressure = allocate(points, sizeof(double));
    p.traction = allocate(points * ndir, sizeof(double));
    p.tangent = allocate(points * ndir * ndir, sizeof(double));
    p.energy = allocate(points * 2, sizeof(double));
    p.statuses = allocate(points, sizeof(int32_t));
    return p;
}

void patch_free(patch *p) {
    double *arrays[] = {p->x,         p->y,        p->area,   p->reference_pressure, p->state0, p->state1,
                        p->increment, p->pressure, p->traction, p->tangent,          p->energy};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        free(arrays[i]);
    }
    free(p->statuses);
    csv_free(&p->table);
}

static void check(const patch *p, int32_t worst, const char *where) {
    if (worst >= 0) {
        return;
    }
    int64_t i = 0;
    while (i < p->points - 1 && p->statuses[i] != worst) {
        i++;
    }
    fail("%s: point at %s:%ld: %s", where, p->table.file, p->table.lines[i], p->run->lib.last_error());
}

/* Tries the common slip increment `slip` on the way from the last accepted step to `target`, and sums up. */
static void evaluate(patch *p, const motion *target, const double slip[2], const char *where) {
    replay *run = p->run;
    int32_t ndir = run->ndir;
    double turn = target->rotation - p->at.rotation;
    for (int64_t i = 0; i < p->points; i++) {
        p->increment[i * ndir] = slip[0] - turn * p->y[i];
        if (ndir == 2) {
            p->increment[i * ndir + 1] = slip[1] + turn * p->x[i];
        }
        p->pressure[i] = target->pressure_scale * p->reference_pressure[i];
    }
    check(p,
          run->lib.friction_batch(run->law, p->points, p->increment, p->pressure, p->state0, p->state1, p->traction,
                                  p->tangent, NULL, p->energy, p->statuses, 1),
          where);

    p->force[0] = p->force[1] = p->moment = p->stored = p->dissipated_in_step = 0.0;
    p->stiffness[0][0] = p->stiffness[0][1] = p->stiffness[1][0] = p->stiffness[1][1] = 0.0;
    for (int64_t i = 0; i < p->points; i++) {
        const double *traction = p->traction + i * ndir;
        const double *tangent = p->tangent + i * ndir * ndir;
        for (int32_t a = 0; a < ndir; a++) {
            p->force[a] += p->area[i] * traction[a];
            for (int32_t b = 0; b < ndir; b++) {
                p->stiffness[a][b] += p->area[i] * tangent[a * ndir + b];
            }
        }
        if (ndir == 2) {
            p->moment += p->area[i] * (p->x[i] * traction[1] - p->y[i] * traction[0]);
        }
        p->stored += p->area[i] * p->energy[2 * i];
        p->dissipated_in_step += p->area[i] * p->energy[2 * i + 1];
    }
}

/* Keeps the step that was evaluated last. */
static void commit(patch *p, const motion *target, const double slip[2]) {
    for (int64_t i = 0; i < p->points; i++) {
        p->run->memory_full += p->statuses[i] > 0;
    }
    double *state = p->state0;
    p->state0 = p->state1;
    p->state1 = state;
    p->at = *target;
    p->slip[0] += slip[0];
    p->slip[1] += slip[1];
    p->dissipated += p->dissipated_in_step;
}

/* Residual of the step that was evaluated last; returns its length. */
static double residual(const patch *p, const motion *target, const double slip[2], double r[2]) {
    r[0] = r[1] = 0.0;
    for (int32_t a = 0; a < p->run->ndir; a++) {
        r[a] = p->run->given->series * (p->slip[a] + slip[a] - target->displacement[a]) + p->force[a];
    }
    return hypot(r[0], r[1]);
}

/* The forces that the residual is measured against. */
static double force_scale(const patch *p, const motion *target) {
    double friction = 0.0;
    for (int64_t i = 0; i < p->points; i++) {
        friction += p->run->given->props[0] * p->area[i] * fmax(p->pressure[i], 0.0);
    }
    double slip = hypot(p->slip[0], p->slip[1]);
    double displacement = hypot(target->displacement[0], target->displacement[1]);
    return friction + p->run->given->series * fmax(slip, displacement);
}

/* The Newton correction -J^-1 r with J = K I + d force / d slip. */
static void newton_direction(const patch *p, const double r[2], double direction[2]) {
    double series = p->run->given->series;
    double a = series + p->stiffness[0][0];
    direction[0] = direction[1] = 0.0;
    if (p->run->ndir == 1) {
        direction[0] = -r[0] / a;
        return;
    }
    double b = p->stiffness[0][1];
    double c = p->stiffness[1][0];
    double d = series + p->stiffness[1][1];
    double determinant = a * d - b * c;
    direction[0] = -(d * r[0] - b * r[1]) / determinant;
    direction[1] = -(a * r[1] - c * r[0]) / determinant;
}

/* Goes from `slip` along `direction` until the residual is smaller than `length`, halving the way; 0 if it never is. */
static int line_search(patch *p, const motion *target, const double direction[2], double slip[2], double r[2],
                       double *length, const char *where) {
    double way = 1.0;
    for (int i = 0; i < MAX_BACKTRACKS; i++) {
        double trial[2] = {slip[0] + way * direction[0], slip[1] + way * direction[1]};
        double r_trial[2];
        evaluate(p, target, trial, where);
        double length_trial = residual(p, target, trial, r_trial);
        if (length_trial < *length) {
            for (int a = 0; a < 2; a++) {
                slip[a] = trial[a];
                r[a] = r_trial[a];
            }
            *length = length_trial;
            return 1;
        }
        way *= 0.5;
    }
    return 0;
}

/* Finds the common slip increment of a step and leaves it evaluated, not committed; 0 if Newton does not get there. */
static int solve(patch *p, const motion *target, double slip[2], int *iterations, const char *where) {
    double r[2];
    double direction[2];
    slip[0] = slip[1] = 0.0;
    evaluate(p, target, slip, where);
    double length = residual(p, target, slip, r);
    double tolerance = TOLERANCE * force_scale(p, target);
    if (!isfinite(length)) {
        return 0; /* overflow */
    }
    if (length <= tolerance) {
        return 1; /* nothing moves: rounding must not count as a slip */
    }
    for (int i = 0; !(length <= tolerance); i++) {
        newton_direction(p, r, direction);
        if (i == MAX_ITERATIONS || !line_search(p, target, direction, slip, r, &length, where)) {
            return 0;
        }
        (*iterations)++;
    }
    /* One more correction takes the last digits; it is kept unless it only adds rounding. */
    double best[2] = {slip[0], slip[1]};
    newton_direction(p, r, direction);
    slip[0] += direction[0];
    slip[1] += direction[1];
    evaluate(p, target, slip, where);
    if (residual(p, target, slip, r) > length) {
        slip[0] = best[0];
        slip[1] = best[1];
        evaluate(p, target, slip, where);
    }
    return 1;
}

/* The point at `part` of the way from the last accepted motion to `target`. */
static motion between(const motion *from, const motion *target, double part) {
    motion m;
    m.displacement[0] = from->displacement[0] + part * (target->displacement[0] - from->displacement[0]);
    m.displacement[1] = from->displacement[1] + part * (target->displacement[1] - from->displacement[1]);
    m.rotation = from->rotation + part * (target->rotation - from->rotation);
    m.pressure_scale = from->pressure_scale + part * (target->pressure_scale - from->pressure_scale);
    return m;
}

int patch_advance(patch *p, const motion *target, const char *where) {
    double slip[2];
    if (!(p->run->given->series > 0.0)) { /* rigid: the slip is prescribed, nothing to solve */
        slip[0] = target->displacement[0] - p->slip[0];
        slip[1] = target->displacement[1] - p->slip[1];
        evaluate(p, target, slip, where);
        commit(p, target, slip);
        return 0;
    }
    motion start = p->at;
    int iterations = 0;
    int halvings = 0;
    double done = 0.0; /* part of the step that is committed */
    while (done < 1.0) {
        double end = done + ldexp(1.0, -halvings);
        motion goal = end < 1.0 ? between(&start, target, end) : *target;
        if (solve(p, &goal, slip, &iterations, where)) {
            commit(p, &goal, slip);
            done = end;
        } else if (++halvings > MAX_HALVINGS) {
            fail("%s: no equilibrium: Newton does not converge, not even for 1/%d of the step", where,
                 1 << MAX_HALVINGS);
        }
    }
    return iterations;
}

void patch_count(const patch *p, long count[CONTACT_KINDS]) {
    for (int kind = 0; kind < CONTACT_KINDS; kind++) {
        count[kind] = 0;
    }
    for (int64_t i = 0; i < p->points; i++) {
        int kind = (int)p->state0[i * p->run->nstate];
        if (kind >= 0 && kind < CONTACT_KINDS) {
            count[kind]++;
        }
    }
}
