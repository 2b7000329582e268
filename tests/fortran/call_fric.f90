!> Calls FRIC as the host does: prints the traction, stored and dissipated energy, DDTDDG by rows, DDTDDP.
program call_fric
    use history
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    external :: fric
    type(model) :: m
    real(real64), allocatable :: tau(:), ddtddg(:, :), ddtddp(:), dslip(:), ddtddt(:, :), statev(:), dgam(:)
    real(real64) :: sed, sfd, pnewdt, before(2), slip(2), pressure, old_pressure, total, turnover
    integer(int32) :: lm, step, i
    character(80), parameter :: ciname = 'BOLT', slname = 'PLATE', msname = 'WASHER'
    real(real64), parameter :: none(3) = 0
    real(real64), parameter :: identity(2, 2) = reshape([1, 0, 0, 1], [2, 2])

    m = read_model()
    allocate (tau(m%ndir), ddtddg(m%ndir, m%ndir), ddtddp(m%ndir), dslip(m%ndir), ddtddt(m%ndir, 2), dgam(m%ndir))
    allocate (statev(m%nstate), source=0.0_real64)
    before = 0
    old_pressure = 0
    total = 0
    turnover = 0
    do step = 1, m%nsteps
        call next_step(m, slip, pressure)
        dgam = slip(:m%ndir) - before(:m%ndir)
        lm = 0
        pnewdt = 1
        call fric(lm, tau, ddtddg, ddtddp, dslip, sed, sfd, ddtddt, pnewdt, statev, dgam, none(:2), pressure, &
            pressure - old_pressure, 0.0_real64, none(:2), 1_int32, step, none(:2), 1.0_real64, 0_int32, ciname, &
            slname, msname, 1_int32, 7_int32, 1_int32, none, none, identity, none(:2), none(:2), m%ndir, 3_int32, &
            1_int32, m%nstate, 0.0_real64, m%props, m%nprops)
        call expect(pnewdt == 1, 'a cutback')
        total = total + sfd
        turnover = turnover + abs(sfd)
        call expect(abs(total - statev(5)) <= 1e-12_real64 * turnover, 'SFD against the state')
        call expect(all(ddtddt == 0), 'DDTDDT')
        call put([tau, sed, statev(5), (ddtddg(i, :), i=1, m%ndir), ddtddp])
        before = slip
        old_pressure = pressure
    end do
end program
