/* What the parts of the example share: tables of numbers, the library's functions, one replay. */
#ifndef MEPC_REPLAY_H
#define MEPC_REPLAY_H

#include "mepc.h"

#include <stddef.h>

/* Prints "mepc_replay: <text>" on standard error and ends the program with exit code 1. */
void fail(const char *format, ...);

/* Memory of zeros, or the end of the program. */
void *allocate(size_t count, size_t size);

/* A table of numbers, row after row. */
typedef struct {
    const char *file, *header;
    size_t columns, count, room; /* count: numbers in use */
    double *values;
    long *lines;                 /* line of the file of each row, from 1 */
} table;

/* Reads comma-separated values under one of the accepted headers (a list that ends with NULL); lines that are blank or
 * start with '#' are skipped. Anything else ends the program with file, line and column. */
table table_read(const char *file, const char *const *headers);

/* Adds a number at the end; ends the program with the place of input row `row` if it is not finite. */
void table_add(table *t, const table *input, size_t row, const double *values, size_t count);

/* Reads a decimal number that fills the text; returns 0 if it is none, or not finite. */
int read_number(const char *text, double *value);

/* The functions of the library that this program uses, with the prototypes of mepc.h. */
typedef struct {
    void *handle;
    int32_t (*abi_version)(void);
    const char *(*last_error)(void);
    int32_t (*state_size)(const double *props, int32_t nprops, int32_t ndir);
    int32_t (*law_new)(const double *props, int32_t nprops, int32_t ndir, int32_t nstate, mepc_law **law);
    void (*law_free)(mepc_law *law);
    int32_t (*friction)(const mepc_law *law, const double *slip_increment, double pressure, const double *mu_factor,
                        const double *state0, double *state1, double *traction, double *dtraction_dslip,
                        double *dtraction_dpressure, double *energy);
    int32_t (*friction_history)(const mepc_law *law, int64_t n, const double *slip_increment, const double *pressure,
                                const double *mu_factor, double *state, double *traction, double *dtraction_dslip,
                                double *dtraction_dpressure, double *energy);
    int32_t (*interface)(const mepc_law *law, const double *opening, const double *mu_factor, const double *state0,
                         double *state1, double *traction, double *tangent, double *energy);
    int32_t (*friction_batch)(const mepc_law *law, int64_t n, const double *slip_increment, const double *pressure,
                              const double *mu_factor, const double *state0, double *state1, double *traction,
                              double *dtraction_dslip, double *dtraction_dpressure, double *energy, int32_t *statuses,
                              int32_t threads);
} library;

/* Loads the library; ends the program if it cannot be loaded, lacks a function, or has another ABI version. */
library library_open(const char *path);

/* A law, the history it is replayed on, and the table that comes out: the columns of the history, then the results. */
typedef struct {
    library lib;
    mepc_law *law;
    size_t ndir, nstate;     /* tangential directions; numbers in the state of a point */
    table in, out;
    double series, parallel; /* springs of a patch, force per length; series 0: rigid */
    long memory_full;        /* updates that dropped a knot that mattered */
} replay;

/* Ends the program if the library refused the step of a row; `point` (or "") is part of the message. */
void check(replay *run, int32_t status, size_t row, const char *point);

/* Replays a patch: points (x,y,area,pressure) that share the rigid motion of the history. */
void replay_patch(replay *run, const table *points);

#endif
