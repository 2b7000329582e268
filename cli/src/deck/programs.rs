//! Programs that call the library: a cycle of slip under constant pressure, printed.

use super::Deck;
use crate::numbers::exact;
use crate::props::list;

/// Slip goes to so many critical slips, in so many steps per quarter of the cycle.
const AMPLITUDE: f64 = 2.0;
const STEPS: u32 = 20;
/// The pressure of the example, where no reference pressure is given.
const PRESSURE: f64 = 100.0;

fn pressure(deck: &Deck) -> f64 {
    match deck.properties.reference_pressure {
        0.0 => PRESSURE,
        pressure => pressure,
    }
}

/// C, to be compiled with `cc friction.c -I include -L target/release -lmepc`.
pub fn c(deck: &Deck) -> String {
    let props = list(deck.props).join(", ");
    let (ndir, nstate) = (deck.directions, deck.nstate);
    let double = |value: f64| format!("{value:?}");
    let step = exact(AMPLITUDE * deck.properties.gcr / f64::from(STEPS));
    let (quarter, three) = (STEPS, 3 * STEPS);
    let total = 5 * STEPS;
    let (pressure, rule) = (double(pressure(deck)), deck.rule());
    format!(
        r#"/* Friction with memory: a cycle of slip under constant pressure.
 * {rule}.
 * Printed: slip, traction and, from the state, the contact status (0 open, 1 stick, 2 micro-slip, 3 gross slip), the
 * dissipated energy (per area) and the slip length.
 * cc friction.c -Iinclude -Ltarget/release -lmepc -Wl,-rpath,$PWD/target/release -o friction */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include "mepc.h"

#define NDIR {ndir}
#define NSTATE {nstate}

int main(void)
{{
    static const double props[] = {{{props}}};
    const double step = {step}; /* slip per increment */
    const double pressure = {pressure};
    double state[NSTATE] = {{0.0}}; /* virgin */
    double slip = 0.0;
    mepc_law *law = NULL;
    if (mepc_law_new(props, (int32_t)(sizeof props / sizeof props[0]), NDIR, NSTATE, &law) < 0) {{
        fprintf(stderr, "%s\n", mepc_last_error());
        return EXIT_FAILURE;
    }}
    for (int i = 0; i < {total}; i++) {{
        /* up to the amplitude, down to the other, up again */
        double increment[NDIR] = {{i >= {quarter} && i < {three} ? -step : step}};
        double traction[NDIR];
        if (mepc_friction(law, increment, pressure, NULL, state, state, traction, NULL, NULL, NULL) < 0) {{
            fprintf(stderr, "%s\n", mepc_last_error());
            mepc_law_free(law);
            return EXIT_FAILURE;
        }}
        slip += increment[0];
        printf("%.17g,%.17g,%g,%.17g,%.17g\n", slip, traction[0], state[0], state[4], state[5]);
    }}
    mepc_law_free(law);
    return EXIT_SUCCESS;
}}
"#
    )
}

/// Fortran, to be compiled with the module's source before it.
pub fn fortran(deck: &Deck) -> String {
    let double = |value: f64| format!("{value:e}").replace('e', "d");
    let rule = deck.rule();
    let props: Vec<String> = deck.props.iter().map(|&value| double(value)).collect();
    let props = props.join(", &\n        ");
    let (ndir, nstate) = (deck.directions, deck.nstate);
    let step = double(AMPLITUDE * deck.properties.gcr / f64::from(STEPS));
    let pressure = double(pressure(deck));
    let (quarter, three) = (STEPS, 3 * STEPS);
    let total = 5 * STEPS;
    format!(
        r#"! Friction with memory: a cycle of slip under constant pressure.
! {rule}.
! Printed: slip, traction and, from the state, the contact status (0 open, 1 stick, 2 micro-slip, 3 gross slip), the
! dissipated energy (per area) and the slip length.
! gfortran include/mepc.f90 friction.f90 -Ltarget/release -lmepc -Wl,-rpath,$PWD/target/release -o friction
program friction
    use, intrinsic :: iso_c_binding, only: c_double
    use mepc
    implicit none
    integer, parameter :: ndir = {ndir}, nstate = {nstate}
    real(c_double), parameter :: props(*) = [ &
        {props}]
    real(c_double), parameter :: step = {step} ! slip per increment
    real(c_double), parameter :: pressure = {pressure}
    real(c_double) :: state(nstate), next(nstate), increment(ndir), traction(ndir), slip
    type(c_ptr) :: law
    integer :: i

    law = c_null_ptr
    if (mepc_law_new(props, size(props), ndir, nstate, law) < 0) error stop mepc_last_error()
    state = 0 ! virgin
    slip = 0
    do i = 0, {total} - 1
        ! up to the amplitude, down to the other, up again
        increment = 0
        increment(1) = merge(-step, step, i >= {quarter} .and. i < {three})
        if (mepc_friction(law, increment, pressure, state0=state, state1=next, traction=traction) < 0) error stop mepc_last_error()
        state = next ! every increment is accepted
        slip = slip + increment(1)
        print "(es24.16e3, 4(a, es24.16e3))", slip, ",", traction(1), ",", state(1), ",", state(5), ",", state(6)
    end do
    call mepc_law_free(law)
end program
"#
    )
}
