/* The contact-law library, loaded at run time from the path that the user gives. */
#ifndef LIBRARY_H
#define LIBRARY_H

#include "mepc.h"

/* The functions this program uses, with the names and prototypes of mepc.h. */
typedef struct {
    void *handle;
    const char *path;
    int32_t (*abi_version)(void);
    const char *(*last_error)(void);
    int32_t (*state_size)(const double *props, int32_t nprops, int32_t ndir);
    int32_t (*law_new)(const double *props, int32_t nprops, int32_t ndir, int32_t nstate, mepc_law **law);
    void (*law_free)(mepc_law *law);
    int32_t (*friction)(const mepc_law *law, const double *slip_increment, double pressure, const double *state0,
                        double *state1, double *traction, double *dtraction_dslip, double *dtraction_dpressure,
                        double *energy);
    int32_t (*friction_batch)(const mepc_law *law, int64_t n, const double *slip_increment, const double *pressure,
                              const double *state0, double *state1, double *traction, double *dtraction_dslip,
                              double *dtraction_dpressure, double *energy, int32_t *statuses, int32_t threads);
} library;

/* Loads the library; ends the program if it cannot be loaded, lacks a function, or has another ABI version. */
library library_open(const char *path);

void library_close(library *lib);

#endif
