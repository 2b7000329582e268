!> Calls UMAT as the hosts do, in the layout that the argument names (PROPS 21): prints the pressure, the traction, stored
!> and dissipated energy, the tangent by rows.
program call_umat
    use history
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    external :: umat
    type(model) :: m
    real(real64), allocatable :: stress(:), statev(:), ddsdde(:, :), stran(:), dstran(:), props(:)
    real(real64) :: slip(2), pressure, now(3), before(3), tangent(3, 3), scale, length, keep(6), none(9), opening
    integer(int32) :: step, ntens, slots(3), n, i, layout
    character(80), parameter :: cmname = 'CONTACT'
    character(8) :: argument

    call get_command_argument(1, argument)
    read (argument, *) layout
    m = read_model()
    n = 1 + m%ndir
    allocate (props(25), source=0.0_real64)
    props(:m%nprops) = m%props
    props(7) = normal_stiffness
    scale = 1
    length = 1
    select case (layout)
    case (0)
        ntens = n
        slots = [1, 2, 3]
    case (1)
        ntens = 6
        slots = [3, 6, 5]
        scale = 2
    case default
        ntens = 6
        slots = [3, 5, 6]
        length = 0.25_real64
        props(23) = length
    end select
    props(21) = layout
    props(22) = scale
    ! Given, they need not be those of the layout.
    if (m%nprops > 20) props(21:m%nprops) = m%props(21:)
    allocate (stress(ntens), ddsdde(ntens, ntens), stran(ntens), dstran(ntens))
    allocate (statev(m%nstate), source=0.0_real64)
    before = 0
    keep = untouched
    none = 0
    do step = 1, m%nsteps
        call next_step(m, slip, pressure)
        now = [-pressure / normal_stiffness, slip]
        stran = 3 ! what is in the other slots has no effect
        dstran = -2
        stran(slots(:n)) = before(:n) / (scale * length)
        dstran(slots(:n)) = (now(:n) - before(:n)) / (scale * length)
        stress = untouched
        ddsdde = untouched
        call umat(stress, statev, ddsdde, keep(1), keep(2), keep(3), keep(4), keep(5:6), keep(5:6), keep(6), stran, &
            dstran, none(:2), none(1), none(1), none(1), none(:1), none(:1), cmname, 3_int32, ntens - 3, ntens, &
            m%nstate, props, 25_int32, none(:3), none, keep(6), none(1), none, none, 11_int32, 1_int32, 1_int32, &
            1_int32, 1_int32, step)
        call expect(all(keep == untouched), 'a write to an argument that is not used')
        ! Which shear is the first one matters for what the state variables are called.
        call expect(norm2(statev(8:7 + m%ndir) - slip(:m%ndir)) <= 1e-14_real64 * norm2(slip), 'TangentialJump')
        opening = stress(slots(1)) / scale
        tangent(:n, :n) = ddsdde(slots(:n), slots(:n)) / (scale**2 * length)
        call expect(count(stress /= 0) <= n .and. count(ddsdde /= 0) <= n * n, 'something in other slots')
        call put([-opening, stress(slots(2:n)) / scale, statev(4), statev(5), (tangent(i, :n), i=1, n)])
        before = now
    end do
end program
