!> Using the law from Fortran: three load cycles with growing amplitude at one contact point, through the module `mepc`.
!> Prints the loop's corners, and the energy that each cycle dissipates beside its closed form.
program module_demo
    use, intrinsic :: iso_fortran_env, only: error_unit, int32, real64
    use mepc
    implicit none

    integer(int32), parameter :: ndir = 1                      ! tangential directions
    real(real64), parameter :: mu = 0.3_real64                 ! friction coefficient
    real(real64), parameter :: gcr = 0.002_real64              ! critical slip, mm
    real(real64), parameter :: chi = 2.5_real64                ! exponent of the backbone
    real(real64), parameter :: pressure = 50.0_real64          ! MPa
    real(real64), parameter :: amplitudes(3) = [0.5_real64, 1.0_real64, 2.0_real64] * gcr
    integer, parameter :: steps = 25                           ! per branch

    type(c_ptr) :: law
    real(real64), allocatable :: state(:), new_state(:)
    real(real64) :: slip, traction(ndir), stiffness(ndir, ndir), energy(2), dissipated
    integer(int32) :: nstate
    integer :: i

    ! The law: checked once, then shared by all points.
    nstate = mepc_state_size([mu, gcr, chi], 3_int32, ndir)
    call check(mepc_law_new([mu, gcr, chi], 3_int32, ndir, nstate, law))

    ! The state of one point: all zeros is the virgin state.
    allocate (state(nstate), new_state(nstate), source=0.0_real64)
    slip = 0
    dissipated = 0

    print "(a)", "mepc " // mepc_version()
    print "(a)", "   slip [mm]  traction [MPa]  stiffness [MPa/mm]  stored [N/mm]"
    do i = 1, size(amplitudes)
        call move_to(amplitudes(i))
        dissipated = 0
        call move_to(-amplitudes(i))
        call move_to(amplitudes(i))
        print "(2(a, es13.6), a)", "  cycle dissipates ", dissipated, " N/mm, closed form ", &
            closed_form(amplitudes(i) / gcr) * mu * pressure * gcr, " N/mm"
    end do
    call mepc_law_free(law)

contains

    !> Slides to a position in equal steps and prints the end.
    subroutine move_to(target)
        real(real64), intent(in) :: target
        real(real64) :: increment(ndir)
        integer :: k

        increment = (target - slip) / steps
        do k = 1, steps
            call check(mepc_friction(law, increment, pressure, state, new_state, traction, stiffness, energy=energy))
            state = new_state ! the step is accepted
            dissipated = dissipated + energy(2)
        end do
        slip = target
        print "(f12.6, f16.6, es20.6, es15.6)", slip, traction(1), stiffness(1, 1), energy(1)
    end subroutine

    !> Dissipation of a cycle of amplitude a gcr, per mu p gcr.
    pure real(real64) function closed_form(a)
        real(real64), intent(in) :: a
        if (a <= 1) then
            closed_form = 4 * a + 4 * a * (1 - a)**chi - 8 / (chi + 1) * (1 - (1 - a)**(chi + 1))
        else
            closed_form = 4 * (a - 2 / (chi + 1))
        end if
    end function

    !> Stops at an error of the library; positive statuses are remarks.
    subroutine check(status)
        integer(int32), intent(in) :: status
        if (status < 0) then
            write (error_unit, "(a)") "module_demo: " // mepc_last_error()
            stop 1, quiet=.true.
        end if
    end subroutine
end program
