!> The C interface from Fortran, through the module `mepc`: a cycle of one point, in steps and in one call.
program module_demo
    use, intrinsic :: iso_fortran_env, only: error_unit, int32, int64, real64
    use mepc
    implicit none

    integer(int32), parameter :: ndir = 1, n = 6
    real(real64), parameter :: props(5) = [0.3d0, 0.002d0, 2.5d0, 0d0, 50d0] ! mu, gcr (mm), chi, memory, p0 (MPa)
    real(real64), parameter :: slip(n) = [0.001d0, 0.001d0, -0.001d0, -0.003d0, 0.001d0, 0.003d0] ! increments, mm
    real(real64), parameter :: pressure(n) = [50d0, 50d0, 60d0, 50d0, 50d0, 50d0]
    real(real64), allocatable :: state(:), next(:)
    real(real64) :: traction(ndir), stiffness(ndir, ndir), energy(2), history(ndir, n)
    type(c_ptr) :: law
    integer(int32) :: nstate
    integer :: i

    if (mepc_abi_version() /= mepc_abi) error stop "another version of the library"
    ! The law is checked once, then shared by all points. A state of zeros is virgin.
    nstate = mepc_state_size(props, size(props, kind=int32), ndir)
    call check(mepc_law_new(props, size(props, kind=int32), ndir, nstate, law))
    allocate (state(nstate), next(nstate), source=0d0)

    print "(a)", "mepc " // mepc_version()
    print "(a)", "traction [MPa]  stiffness [MPa/mm]  stored [N/mm]  dissipated [N/mm]"
    do i = 1, n
        call check(mepc_friction(law, slip(i:i), pressure(i), state0=state, state1=next, traction=traction, &
            dtraction_dslip=stiffness, energy=energy))
        state = next ! the step is accepted
        print "(f14.8, f20.4, 2es17.8)", traction(1), stiffness(1, 1), energy
    end do

    state = 0
    call check(mepc_friction_history(law, int(n, int64), slip, pressure, state=state, traction=history))
    print "(a, es9.2)", "all steps in one call, difference of the last traction:", abs(history(1, n) - traction(1))
    call mepc_law_free(law)

contains

    !> Stops at an error of the library; positive statuses are remarks.
    subroutine check(status)
        integer(int32), intent(in) :: status
        if (status >= 0) return
        write (error_unit, "(a)") "module_demo: " // mepc_last_error()
        stop 1, quiet=.true.
    end subroutine
end program
