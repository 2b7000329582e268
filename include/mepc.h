/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * mepc: friction with memory for finite-element contact.
 *
 * Units: any consistent set (mm, N, MPa). Tractions, pressures and energies are per area; compression is positive
 * pressure; the friction traction has the sign of the slip. Arrays belong to the caller and are only used during the
 * call, except a law, which the caller makes with mepc_law_new and releases with mepc_law_free. A status is 0 on
 * success, positive for an advisory, negative for an error (mepc_last_error tells in words); outputs are written only
 * if it is not negative, and none of them may overlap another array unless that is said. Nothing unwinds or aborts.
 * Functions may be called from any number of threads (with 64 KiB of stack or more) at once; a law may be shared by them.
 */

#ifndef MEPC_H
#define MEPC_H

/* Generated from src/ffi by cbindgen: do not edit, run `make generated`. */

#include <stdint.h>

/*
 Version of this interface. A program compares it with what mepc_abi_version returns.
 */
#define MEPC_ABI_VERSION 2

/*
 Advisory status: the state array is full and a remembered knot that mattered was dropped.
 */
#define MEPC_MEMORY_FULL 1

/*
 Advisory status of mepc_iwan_identify: the model does not describe the loop. What was found is written all the same.
 */
#define MEPC_NOT_DESCRIBED 2

/*
 Status: a required pointer is null.
 */
#define MEPC_NULL_POINTER -1

/*
 Status: a property is missing or out of range.
 */
#define MEPC_BAD_PROPERTY -2

/*
 Status: the state array is too short or corrupt.
 */
#define MEPC_BAD_STATE -3

/*
 Status: an input is not finite, or a size is out of range.
 */
#define MEPC_BAD_INPUT -4

/*
 Status: a defect of the library (a caught panic).
 */
#define MEPC_INTERNAL -5

/*
 Contact status, the first number of a state: open, or never closed.
 */
#define MEPC_CONTACT_OPEN 0

/*
 Contact status: no more than a hundredth of the stiffness has slipped.
 */
#define MEPC_CONTACT_STICK 1

/*
 Contact status: part of the contact slips.
 */
#define MEPC_CONTACT_MICRO_SLIP 2

/*
 Contact status: all of it slips.
 */
#define MEPC_CONTACT_GROSS_SLIP 3

/*
 A contact law: properties checked once, and everything that follows from them.

 Made by mepc_law_new, released by mepc_law_free. Immutable: any number of threads may use one law at once.
 */
typedef struct mepc_law mepc_law;

#ifdef __cplusplus
extern "C" {
#endif /* __cplusplus */

/*
 Version of the interface that the library offers; a program built against another MEPC_ABI_VERSION must not call it.
 */
int32_t mepc_abi_version(void);

/*
 Version of the library, "major.minor.patch".
 */
const char *mepc_version(void);

/*
 What a status number means, in words; never NULL.
 */
const char *mepc_status_message(int32_t status);

/*
 This thread's last error in words: which argument, its value, what was expected. Never NULL, empty before the
 first error. The text is valid until this thread's next failing call.
 */
const char *mepc_last_error(void);

/*
 Makes a law.

 props: nprops properties in the order of the property table (see the README); zero and missing trailing entries take
 their defaults. gcr must be positive here: there is no characteristic length.
 ndir: tangential directions, 1 or 2. nstate: numbers in a state array, see mepc_state_size.
 law: receives the new law, to be released with mepc_law_free; written only on success.

 Returns 0, or MEPC_NULL_POINTER, MEPC_BAD_PROPERTY, MEPC_BAD_STATE (nstate too small or above 1000000), MEPC_BAD_INPUT (ndir, nprops).

 props points to nprops numbers, law to a writable pointer.
 */
int32_t mepc_law_new(const double *props,
                     int32_t nprops,
                     int32_t ndir,
                     int32_t nstate,
                     mepc_law **law);

/*
 Releases a law; NULL is allowed and does nothing.

 law came from mepc_law_new and is not used afterwards.
 */
void mepc_law_free(mepc_law *law);

/*
 The default number of state variables: 44 for one direction (16 knots), 84 for two (24 knots), or a negative status.

 A state may be longer (up to 64 knots of 1 + ndir numbers are used) or shorter (12 numbers and 4 knots at least).

 props points to nprops numbers.
 */
int32_t mepc_state_size(const double *props,
                        int32_t nprops,
                        int32_t ndir);

/*
 The name of state variable index (0-based); NULL past the end. Valid as long as the law.

 law is NULL or came from mepc_law_new.
 */
const char *mepc_state_name(const mepc_law *law, int32_t index);

/*
 Friction form: one contact point, one increment.

 slip_increment: [ndir] tangential slip of the increment, length. pressure: at the end of the increment, positive in
 compression; zero or less is an open contact: no traction, and the memory is cleared.
 mu_factor: one number >= 0 by which the friction coefficient is multiplied in this increment, or NULL (1).
 state0: [nstate] at the start of the increment; all zeros is the virgin state. state1: [nstate] at its end; may be
 the same array as state0, but must not overlap it otherwise.
 traction: [ndir] friction traction (force per area) with the sign of the slip.
 dtraction_dslip: [ndir*ndir] row-major consistent tangent, or NULL. dtraction_dpressure: [ndir], or NULL.
 energy: [2] per area: stored at the end, dissipated in the increment; or NULL.

 Returns 0, MEPC_MEMORY_FULL (a valid result), or a negative status; outputs are written only when it is not negative.
 A pure function of law, state0, slip_increment, pressure and mu_factor: repeat, reject and restart at will.

 law came from mepc_law_new, and arrays are as long as described.
 */
int32_t mepc_friction(const mepc_law *law,
                      const double *slip_increment,
                      double pressure,
                      const double *mu_factor,
                      const double *state0,
                      double *state1,
                      double *traction,
                      double *dtraction_dslip,
                      double *dtraction_dpressure,
                      double *energy);

/*
 Interface form: one contact point, one increment, with the normal penalty (PROPS 7, kn > 0 required).

 opening: [1+ndir] total opening at the end of the increment, lengths: normal first (positive when open), then
 tangential. mu_factor, state0, state1: as in mepc_friction.
 traction: [1+ndir]: normal (negative in compression), then friction with the sign of the tangential jump.
 tangent: [(1+ndir)*(1+ndir)] row-major d traction_i / d opening_j, not symmetric; or NULL.
 energy: [2] per area: stored at the end by friction and by the normal penalty, dissipated in the increment; or NULL.

 Returns and guarantees as mepc_friction.

 law came from mepc_law_new, and arrays are as long as described.
 */
int32_t mepc_interface(const mepc_law *law,
                       const double *opening,
                       const double *mu_factor,
                       const double *state0,
                       double *state1,
                       double *traction,
                       double *tangent,
                       double *energy);

/*
 Friction form for n points.

 Arrays hold point after point: slip_increment [n*ndir], pressure [n], mu_factor [n] or NULL, state0 and state1 [n*nstate], traction [n*ndir],
 dtraction_dslip [n*ndir*ndir] or NULL, dtraction_dpressure [n*ndir] or NULL, energy [n*2] or NULL.
 statuses: [n] or NULL. threads: 1 = this thread, 0 = as many as there are cores, otherwise that many.

 Returns the most negative status, else the largest; points that fail leave their outputs untouched, and
 mepc_last_error tells of the first point with the returned status. The result does not depend on threads.
 Where the call itself is refused (a null array, n < 0), statuses stay untouched, too.

 law came from mepc_law_new, and arrays are as long as described.
 */
int32_t mepc_friction_batch(const mepc_law *law,
                            int64_t n,
                            const double *slip_increment,
                            const double *pressure,
                            const double *mu_factor,
                            const double *state0,
                            double *state1,
                            double *traction,
                            double *dtraction_dslip,
                            double *dtraction_dpressure,
                            double *energy,
                            int32_t *statuses,
                            int32_t threads);

/*
 Interface form for n points.

 Arrays hold point after point: opening [n*(1+ndir)], mu_factor [n] or NULL, state0 and state1 [n*nstate], traction [n*(1+ndir)],
 tangent [n*(1+ndir)*(1+ndir)] or NULL, energy [n*2] or NULL. statuses, threads and the result as in
 mepc_friction_batch.

 law came from mepc_law_new, and arrays are as long as described.
 */
int32_t mepc_interface_batch(const mepc_law *law,
                             int64_t n,
                             const double *opening,
                             const double *mu_factor,
                             const double *state0,
                             double *state1,
                             double *traction,
                             double *tangent,
                             double *energy,
                             int32_t *statuses,
                             int32_t threads);

/*
 Friction form: one contact point, n increments one after the other.

 Arrays hold increment after increment: slip_increment [n*ndir], pressure [n], mu_factor [n] or NULL, traction [n*ndir],
 dtraction_dslip [n*ndir*ndir] or NULL, dtraction_dpressure [n*ndir] or NULL, energy [n*2] or NULL; each means what it
 means in mepc_friction. state: [nstate], at the start of the history on entry, at its end on return.

 Stops at the first increment that is refused: state is then the one before it, what was written for the increments
 before it stays, later rows are untouched, and mepc_last_error names the increment (from 0).
 Returns 0, MEPC_MEMORY_FULL (in some increment), or the negative status of the refused one.

 law came from mepc_law_new, and arrays are as long as described.
 */
int32_t mepc_friction_history(const mepc_law *law,
                              int64_t n,
                              const double *slip_increment,
                              const double *pressure,
                              const double *mu_factor,
                              double *state,
                              double *traction,
                              double *dtraction_dslip,
                              double *dtraction_dpressure,
                              double *energy);

/*
 Friction form: whole histories of npoints contact points, n increments each.

 Arrays hold the history of one point after that of another: slip_increment [npoints*n*ndir], pressure [npoints*n],
 mu_factor [npoints*n] or NULL, state [npoints*nstate], traction [npoints*n*ndir], dtraction_dslip
 [npoints*n*ndir*ndir] or NULL, dtraction_dpressure [npoints*n*ndir] or NULL, energy [npoints*n*2] or NULL; for each
 point as in mepc_friction_history. statuses: [npoints] or NULL. threads as in mepc_friction_batch.

 A point whose increment is refused stops there; the others go on. Returns the most negative status, else the largest,
 and mepc_last_error names the first point with it, and its increment. The result does not depend on threads.

 law came from mepc_law_new, and arrays are as long as described.
 */
int32_t mepc_friction_history_batch(const mepc_law *law,
                                    int64_t npoints,
                                    int64_t n,
                                    const double *slip_increment,
                                    const double *pressure,
                                    const double *mu_factor,
                                    double *state,
                                    double *traction,
                                    double *dtraction_dslip,
                                    double *dtraction_dpressure,
                                    double *energy,
                                    int32_t *statuses,
                                    int32_t threads);

/*
 The improved four-parameter Iwan model of a joint: forces of its steady loop.

 params: [4] F_s (force at gross slip), X_s (displacement at gross slip), k_alpha (residual stiffness), kappa
 (exponent; chi = 5/2 + kappa >= 1). amplitude: of the loop, > 0. displacement: [n]; branch: [n] +1 while the
 displacement grows, -1 while it falls. Beyond the amplitude the curve of first loading goes on. force: [n], with the
 sign of the displacement; may be the array displacement itself.

 Returns 0, or MEPC_NULL_POINTER, MEPC_BAD_PROPERTY (params), MEPC_BAD_INPUT.

 Arrays are as long as described.
 */
int32_t mepc_iwan_force(const double *params,
                        double amplitude,
                        int64_t n,
                        const double *displacement,
                        const int8_t *branch,
                        double *force);

/*
 The four parameters of the improved Iwan model from a measured loop.

 displacement, force: [n] in the order of time, cycles of one or of several amplitudes about any centre; reversals
 are found in the data, noise is allowed. A time lag between the two is found and taken out. method: 0 least squares
 over all branches at once, 1 the paper's own procedure (residual line, where the data leave it, exponent by
 logarithms: rougher). params: [4] receives F_s, X_s, k_alpha, kappa. standard_errors: [4] of the same, or NULL.
 misfit: root mean square residual over the force at the amplitude, or NULL.

 A loop that does not show gross slip cannot give these parameters and is refused with MEPC_BAD_INPUT, as is one that
 turns the wrong way, or that only a friction of more than twice the measured forces would resemble (viscous
 damping). Returns 0, MEPC_NOT_DESCRIBED (outputs are written, and must not be used without a look at the loop), or
 MEPC_NULL_POINTER, MEPC_BAD_INPUT (nothing is written; mepc_last_error tells what is wrong with the data).

 Arrays are as long as described.
 */
int32_t mepc_iwan_identify(int64_t n,
                           const double *displacement,
                           const double *force,
                           int32_t method,
                           double *params,
                           double *standard_errors,
                           double *misfit);

#ifdef __cplusplus
}  /* extern "C" */
#endif  /* __cplusplus */

#endif  /* MEPC_H */
