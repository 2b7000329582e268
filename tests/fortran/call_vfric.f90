!> Calls VFRIC as the host does, for three of five slave nodes in an order of their own: prints the traction, stored and
!> dissipated energy, three lines a step.
program call_vfric
    use history
    use explicit_contacts
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    external :: vfric
    integer(int32), parameter :: nodes = 5
    !> Which slave node is contact k; the other two are open.
    integer(int32), parameter :: slave(points) = [4, 1, 5], uid(nodes) = [104, 101, 102, 107, 103]
    type(model) :: m
    type(contacts) :: c
    real(real64), allocatable :: statev(:, :), force(:, :), slip(:, :), along(:, :), normal(:, :)
    real(real64) :: area_slave(nodes), f_normal(points), none(30), total(2), before(2), pressure, tau(2)
    integer(int32) :: step, ndim, facets(4, points), k
    character(80), parameter :: names(3) = [character(80) :: 'BOLT', 'PLATE', 'WASHER']

    m = read_model()
    call c%place(m%ndir)
    ndim = int(c%ndim, int32)
    allocate (statev(m%nstate, nodes), source=0.0_real64)
    statev(:, [2, 3]) = untouched
    allocate (force(m%ndir, points), slip(ndim, points), along(ndim, points), normal(ndim, points))
    area_slave = untouched
    area_slave(slave) = area
    normal = c%host_direction(c%frame(:, 1, :))
    before = 0
    none = 0
    facets = 1
    do step = 1, m%nsteps
        call next_step(m, total, pressure)
        call c%move(total - before)
        before = total
        slip = c%host_slip()
        along = c%host_direction(c%along)
        f_normal = pressure * area
        force = untouched
        call vfric(force, statev, 1_int32, step, int(points, int32), 4_int32, nodes, 4_int32, m%ndir, ndim, m%nstate, &
            m%nprops, 0_int32, 0_int32, 1_int32, uid, uid, slave, facets, 0.0_real64, 0.0_real64, 1e-6_real64, names(1), &
            names(2), names(3), 1_int32, slip, f_normal, none, f_normal, 0.0_real64, none, none, none, along, normal, &
            m%props, area_slave, none, none, none, none)
        call expect(all(statev(:, [2, 3]) == untouched), 'a write to the state of a node that is not in contact')
        do k = 1, points
            tau = c%traction(k, force(:, k))
            call put([tau(:m%ndir), statev(4:5, slave(k))])
        end do
    end do
end program
