!> Calls VFRICTION as the host does, for a block of three contacts of slave edges: prints the traction, stored and
!> dissipated energy, three lines a step.
program call_vfriction
    use history
    use explicit_contacts
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    external :: vfriction
    integer(int32), parameter :: block = points, states = 4, ends = 2, corners = 4
    type(model) :: m
    type(contacts) :: c
    real(real64), allocatable :: state(:, :, :), force(:, :), slip(:, :), along(:, :), normal(:, :)
    real(real64) :: f_normal(points), none(3 * corners * points), total(2), before(2), pressure, tau(2)
    integer(int32) :: step, ndim, flags(3), slave(ends, block), master(corners, block), k
    character(80), parameter :: names(3) = [character(80) :: 'BOLT', '', '']

    m = read_model()
    call c%place(m%ndir)
    ndim = int(c%ndim, int32)
    allocate (state(m%nstate, states, block), source=untouched)
    state(:, 1, :) = 0
    allocate (force(m%ndir, points), slip(ndim, points), along(ndim, points), normal(ndim, points))
    normal = c%host_direction(c%frame(:, 1, :))
    before = 0
    none = 0
    slave = 5
    master = 6
    do step = 1, m%nsteps
        call next_step(m, total, pressure)
        call c%move(total - before)
        before = total
        slip = c%host_slip()
        along = c%host_direction(c%along)
        f_normal = pressure * area
        force = untouched
        flags = [1_int32, step, 1_int32]
        call vfriction(force, state, block, block, block, states, ends, corners, m%ndir, ndim, m%nstate, m%nprops, &
            0_int32, 0_int32, flags, none(:4), names(1), names(2), names(3), slave, master, m%props, slip, f_normal, &
            none, f_normal, area, normal, along, none, none, none, none, none, none, none, none, none, none)
        call expect(all(state(:, 2:, :) == untouched), 'a write to a state that does not hold the memory')
        do k = 1, points
            tau = c%traction(k, force(:, k))
            call put([tau(:m%ndir), state(4:5, 1, k)])
        end do
    end do
end program
