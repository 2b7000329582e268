!> What the callers share: a history from standard input, results to standard output.
!>
!> Input, list-directed: ndir nstate nprops nsteps, the properties, then per step the total slip and the pressure.
!> Output: per step and point one line of numbers.
module history
    use, intrinsic :: iso_fortran_env, only: int32, real64, output_unit
    implicit none
    private
    public :: model, read_model, next_step, put, expect

    !> Normal stiffness that the callers divide a pressure by: a power of two, so that nothing is rounded.
    real(real64), parameter, public :: normal_stiffness = 1048576.0_real64
    !> A number that nobody may touch.
    real(real64), parameter, public :: untouched = -7.25e77_real64

    type :: model
        integer(int32) :: ndir, nstate, nprops, nsteps
        real(real64), allocatable :: props(:)
    end type

contains

    function read_model() result(m)
        type(model) :: m
        read (*, *) m%ndir, m%nstate, m%nprops, m%nsteps
        allocate (m%props(m%nprops))
        read (*, *) m%props
    end function

    subroutine next_step(m, slip, pressure)
        type(model), intent(in) :: m
        real(real64), intent(out) :: slip(2), pressure
        slip = 0
        read (*, *) slip(:m%ndir), pressure
    end subroutine

    subroutine put(numbers)
        real(real64), intent(in) :: numbers(:)
        write (output_unit, '(*(es25.17e3, 1x))') numbers
    end subroutine

    subroutine expect(condition, what)
        logical, intent(in) :: condition
        character(*), intent(in) :: what
        if (condition) return
        write (output_unit, '(2a)') 'unexpected: ', what
        error stop 1
    end subroutine
end module
