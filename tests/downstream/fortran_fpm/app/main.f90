! SPDX-License-Identifier: MIT OR Apache-2.0
!> Three increments of one point; tractions against Masing's rules on f(s) = 1 - (1 - s)**2.5.
program consumer
    use, intrinsic :: iso_c_binding, only: c_double
    use mepc
    implicit none
    real(c_double), parameter :: props(5) = [0.3d0, 0.002d0, 2.5d0, 0d0, 100d0]
    real(c_double), parameter :: slip(3) = [0.001d0, -0.0015d0, 0.0005d0]
    real(c_double), allocatable :: state(:), next(:)
    real(c_double) :: traction(1), exact(3)
    type(c_ptr) :: law = c_null_ptr
    integer :: i

    exact(1) = 30 * f(0.5d0)
    exact(2) = exact(1) - 60 * f(0.375d0)
    exact(3) = exact(2) + 60 * f(0.125d0)
    if (mepc_abi_version() /= mepc_abi) error stop "another interface version"
    allocate (state(mepc_state_size(props, size(props), 1)), source=0d0)
    allocate (next, mold=state)
    if (mepc_law_new(props, size(props), 1, size(state), law) < 0) error stop mepc_last_error()
    do i = 1, size(slip)
        if (mepc_friction(law, slip(i:i), 100d0, state0=state, state1=next, traction=traction) < 0) &
            error stop mepc_last_error()
        if (abs(traction(1) - exact(i)) > 1d-10) error stop "a wrong traction"
        state = next
    end do
    print "(a, f10.6)", "traction", traction(1)
    call mepc_law_free(law)

contains

    pure function f(s)
        real(c_double), intent(in) :: s
        real(c_double) :: f
        f = 1 - (1 - s)**2.5d0
    end function
end program
