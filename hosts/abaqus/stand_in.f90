!> Stands in for Abaqus in the link test of `make abaqus`: calls the routines by their symbols and compares with the law's
!> closed form. -DEXPLICIT: those of Abaqus/Explicit instead of Abaqus/Standard.
!>
!> It has a routine called mepc_version of its own: if the objects did not hide theirs, linking would fail.
program stand_in
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    real(real64), parameter :: props(7) = [0.3_real64, 0.002_real64, 2.5_real64, 0.0_real64, 0.0_real64, 0.005_real64, &
        1e5_real64]
    real(real64), parameter :: pressure = 100, slip = 0.001_real64
    real(real64), parameter :: none(30) = 0
    integer(int32), parameter :: one = 1, none_of(4) = 1
    character(80), parameter :: name = 'BOLT'
    real(real64) :: traction

    interface
        subroutine mepc_version() bind(c, name='mepc_version')
        end subroutine
    end interface

    ! mu p f(s) at first loading.
    traction = props(1) * pressure * (1 - (1 - slip / props(2))**props(3))
    call mepc_version()
#ifdef EXPLICIT
    call pairs()
    call block()
#else
    call friction()
    call surfaces()
#endif
    print '(a)', 'as expected'

contains

    subroutine compare(what, value, expected)
        character(*), intent(in) :: what
        real(real64), intent(in) :: value, expected
        if (abs(value - expected) <= 1e-12_real64 * abs(expected)) return
        print '(2a, 2es25.16)', what, ': ', value, expected
        error stop 1
    end subroutine

#ifdef EXPLICIT
    subroutine pairs()
        external :: vfric
        real(real64) :: force(2), statev(64), n(3), s(3)
        statev = 0
        n = [0, 0, 1]
        s = [0.6_real64, 0.8_real64, 0.0_real64]
        call vfric(force, statev, one, one, one, 4_int32, one, 4_int32, 2_int32, 3_int32, 64_int32, 7_int32, 0_int32, &
            0_int32, one, none_of, none_of, [one], none_of, 0.0_real64, 0.0_real64, 1e-6_real64, name, name, name, one, &
            slip * s, none(:1), none(:3), [2 * pressure], 0.0_real64, none, none, none, s, n, props, [2.0_real64], none, &
            none, none, none)
        call compare('vfric', force(1), -2 * traction)
    end subroutine

    subroutine block()
        external :: vfriction
        real(real64) :: force(2), state(64), n(3), s(3)
        state = 0
        n = [0, 0, 1]
        s = [0.6_real64, 0.8_real64, 0.0_real64]
        call vfriction(force, state, one, one, one, one, one, 4_int32, 2_int32, 3_int32, 64_int32, 7_int32, 0_int32, &
            0_int32, none_of(:3), none(:4), name, name, name, none_of, none_of, props, slip * s, none(:1), none(:3), &
            [2 * pressure], [2.0_real64], n, s, none, none, none, none, none, none, none, none, none, none)
        call compare('vfriction', force(1), -2 * traction)
    end subroutine
#else
    subroutine friction()
        external :: fric
        real(real64) :: tau(1), ddtddg(1, 1), ddtddp(1), dslip(1), sed, sfd, ddtddt(1, 2), pnewdt, statev(25)
        integer(int32) :: lm
        lm = 0
        tau = 0
        pnewdt = 1
        statev = 0
        call fric(lm, tau, ddtddg, ddtddp, dslip, sed, sfd, ddtddt, pnewdt, statev, [slip], none(:1), pressure, 0.0_real64, &
            0.0_real64, none(:1), one, one, none(:2), 1.0_real64, 0_int32, name, name, name, one, one, one, none(:3), &
            none(:3), reshape([1.0_real64, 0.0_real64, 0.0_real64, 1.0_real64], [2, 2]), none(:2), none(:2), one, 3_int32, &
            one, 25_int32, 0.0_real64, props, 7_int32)
        call compare('fric', tau(1), traction)
    end subroutine

    subroutine surfaces()
        external :: uinter
        real(real64) :: stress(2), ddsddr(2, 2), amki(2, 2), amski(2, 2), flux(2), ddfddt(2, 2), ddsddt(2, 2), ddfddr(2, 2)
        real(real64) :: statev(25), sed, sfd, spd, svd, scd, pnewdt, rdisp(2)
        integer(int32) :: lopenclose, lstate, lsdi
        statev = 0
        pnewdt = 1
        lopenclose = -1
        rdisp = [pressure / props(7), slip]
        call uinter(stress, ddsddr, amki, amski, flux, ddfddt, ddsddt, ddfddr, statev, sed, sfd, spd, svd, scd, pnewdt, &
            rdisp, rdisp, none(:2), none(:2), none(:2), none(:2), none(:2), 1.0_real64, 0.0_real64, name, name, name, &
            props, none(:3), none(:9), reshape([1.0_real64, 0.0_real64, 0.0_real64, 1.0_real64], [2, 2]), 1.0_real64, &
            0.0_real64, one, 2_int32, 25_int32, one, 7_int32, 3_int32, one, one, one, 0_int32, lopenclose, lstate, lsdi, &
            0_int32)
        call compare('uinter, normal', stress(1), pressure)
        call compare('uinter, tangential', stress(2), traction)
    end subroutine
#endif
end program

subroutine mepc_version() bind(c, name='mepc_version')
end subroutine
