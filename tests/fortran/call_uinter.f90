!> Calls UINTER as the host does: prints STRESS, stored and dissipated energy, DDSDDR by rows.
program call_uinter
    use history
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    external :: uinter
    type(model) :: m
    real(real64), allocatable :: stress(:), ddsddr(:, :), statev(:), rdisp(:), drdisp(:)
    type(zero_outputs) :: zero
    real(real64) :: props(20), flux(2), sed, sfd, pnewdt, slip(2), pressure, before(3)
    real(real64) :: none(9), total, turnover
    integer(int32) :: step, ndir, lopenclose, lstate, lsdi, i
    character(80), parameter :: ciname = 'BOLT', slname = 'PLATE', msname = 'WASHER'
    real(real64), parameter :: identity(2, 2) = reshape([1, 0, 0, 1], [2, 2])

    m = read_model()
    ndir = 1 + m%ndir
    props = 0
    props(:m%nprops) = m%props
    props(7) = normal_stiffness
    allocate (stress(ndir), ddsddr(ndir, ndir), rdisp(ndir), drdisp(ndir))
    allocate (statev(m%nstate), source=0.0_real64)
    before = 0
    none = 0
    total = 0
    turnover = 0
    lopenclose = 0
    do step = 1, m%nsteps
        call next_step(m, slip, pressure)
        rdisp = [pressure / normal_stiffness, slip(:m%ndir)]
        drdisp = rdisp - before(:ndir)
        before(:ndir) = rdisp
        ! A point that slid onto another face: only DRDISP tells what happened.
        rdisp(2:) = rdisp(2:) + 10
        pnewdt = 1
        flux = untouched
        ! A host need not clear what is written.
        ddsddr = untouched
        zero = spoiled(ndir)
        lstate = -99
        lsdi = -99
        call uinter(stress, ddsddr, zero%dviscous, zero%dstructural, flux, zero%ddfddt, zero%ddsddt, zero%ddfddr, statev, &
            sed, sfd, zero%spd, zero%svd, zero%scd, pnewdt, rdisp, drdisp, none(:2), none(:2), none(:2), none(:2), none(:2), &
            1.0_real64, 0.0_real64, ciname, slname, msname, props, none(:3), none, identity, 1.0_real64, 0.0_real64, &
            7_int32, ndir, m%nstate, 1_int32, 20_int32, 3_int32, 1_int32, step, 1_int32, 0_int32, lopenclose, lstate, &
            lsdi, 0_int32)
        call expect(pnewdt == 1, 'a cutback')
        call expect(lopenclose == merge(1, 0, pressure > 0), 'LOPENCLOSE')
        call expect(lstate == -99 .and. lsdi == -99 .and. all(flux == untouched), 'LSTATE, LSDI, FLUX')
        call zero%check()
        total = total + sfd
        turnover = turnover + abs(sfd)
        call expect(abs(total - statev(5)) <= 1e-12_real64 * turnover, 'SFD against the state')
        call put([stress, sed, statev(5), (ddsddr(i, :), i=1, ndir)])
    end do
end program
