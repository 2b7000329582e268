!> What the callers share: a history from standard input, results to standard output.
!>
!> Input, list-directed: ndir nstate nprops nsteps, the properties, then per step the total slip and the pressure.
!> Output: per step and point one line of numbers.
module history
    use, intrinsic :: iso_fortran_env, only: int32, real64, output_unit
    implicit none
    private
    public :: model, read_model, next_step, put, expect, zero_outputs, spoiled

    !> Normal stiffness that the callers divide a pressure by: a power of two, so that nothing is rounded.
    real(real64), parameter, public :: normal_stiffness = 1048576.0_real64
    !> A number that nobody may touch.
    real(real64), parameter, public :: untouched = -7.25e77_real64

    type :: model
        integer(int32) :: ndir, nstate, nprops, nsteps
        real(real64), allocatable :: props(:)
    end type

    !> The outputs of UINTER that are always zero.
    type :: zero_outputs
        real(real64), allocatable :: dviscous(:, :), dstructural(:, :), ddfddt(:, :), ddsddt(:, :), ddfddr(:, :)
        real(real64) :: spd = untouched, svd = untouched, scd = untouched
    contains
        procedure :: check => check_zeros
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

    !> What a host hands over for them that does not clear what is written; NDIR components.
    function spoiled(ndir) result(zero)
        integer(int32), intent(in) :: ndir
        type(zero_outputs) :: zero
        allocate (zero%dviscous(ndir, ndir), zero%dstructural(ndir, ndir), source=untouched)
        allocate (zero%ddfddr(2, ndir), source=untouched)
        allocate (zero%ddfddt(2, 2), zero%ddsddt(ndir, 2), source=untouched)
    end function

    subroutine check_zeros(zero)
        class(zero_outputs), intent(in) :: zero
        call expect(all(zero%dviscous == 0) .and. all(zero%dstructural == 0) .and. all(zero%ddfddt == 0) .and. &
            all(zero%ddsddt == 0) .and. all(zero%ddfddr == 0), 'derivatives that are zero')
        call expect(zero%spd == 0 .and. zero%svd == 0 .and. zero%scd == 0, 'energies that are zero')
    end subroutine

    subroutine expect(condition, what)
        logical, intent(in) :: condition
        character(*), intent(in) :: what
        if (condition) return
        write (output_unit, '(2a)') 'unexpected: ', what
        error stop 1
    end subroutine
end module
