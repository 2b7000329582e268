/* Contact points under one rigid tangential motion: the state of all of them, and one equilibrium step. */
#ifndef PATCH_H
#define PATCH_H

#include "csv.h"
#include "replay.h"

/* What is prescribed at the end of a step. */
typedef struct {
    double displacement[2]; /* beyond the series spring */
    double rotation;        /* small, about the origin */
    double pressure_scale;  /* multiplies the pressures of the patch */
} motion;

typedef struct {
    replay *run;
    csv_table table;
    int64_t points;
    double *x;
    double *y;
    double *area;
    double *reference_pressure;

    /* At the last accepted step. */
    motion at;
    double slip[2]; /* common to all points */
    double dissipated;
    double *state0;

    /* Of the step being tried: input and output of the library, point after point. */
    double *increment;
    double *pressure;
    double *state1;
    double *traction;
    double *tangent;
    double *energy;
    int32_t *statuses;

    /* Sums over the points of the step being tried. */
    double force[2];
    double stiffness[2][2]; /* d force / d common slip */
    double moment;
    double stored;
    double dissipated_in_step;
} patch;

/* Reads the patch file. All points are virgin and without slip. */
patch patch_read(const char *file, replay *run);
void patch_free(patch *p);

/* Moves the patch to `target` and commits the new state. Returns the number of Newton corrections that it took.
 * `where` begins the message should there be no equilibrium. */
int patch_advance(patch *p, const motion *target, const char *where);

/* Number of points per kind of contact. */
void patch_count(const patch *p, long count[CONTACT_KINDS]);

#endif
