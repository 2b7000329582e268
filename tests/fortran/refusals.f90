!> Bad input to the routines of Abaqus: what they leave, and what they give instead. Their messages go to the host.
program refusals
    use history
    use, intrinsic :: iso_c_binding, only: c_char, c_float, c_int
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    external :: uinter, vfric, vfriction
    interface
        !> VFRIC as a build of the host in single precision calls it.
        subroutine vfric_single(force, statev, step, inc, n, nfac, nslv, nmst, nfric, ndir, nstate, nprops, ntemp, npred, ntfv, &
                slvuid, mstuid, slvid, mstid, t1, t2, dt, c1, c2, c3, ltype, slip, stick, prev, normal_force, work, shp, xs, xm, &
                along, normal, props, area, ts, ps, tm, pm) bind(c, name="vfric_")
            import :: c_char, c_float, c_int
            integer(c_int) :: step, inc, n, nfac, nslv, nmst, nfric, ndir, nstate, nprops, ntemp, npred, ntfv, ltype
            integer(c_int) :: slvuid(*), mstuid(*), slvid(*), mstid(*)
            real(c_float) :: force(2, *), statev(*), t1, t2, dt, slip(3, *), stick(*), prev(*), normal_force(*), work, shp(*), xs(*)
            real(c_float) :: xm(*), along(3, *), normal(3, *), props(*), area(*), ts(*), ps(*), tm(*), pm(*)
            character(kind=c_char) :: c1(*), c2(*), c3(*)
        end subroutine
    end interface
    real(real64), parameter :: good(7) = [0.3_real64, 0.002_real64, 2.5_real64, 0.0_real64, 0.0_real64, 0.005_real64, &
        1e5_real64]
    real(real64), parameter :: turned(2, 2) = reshape([0, 1, -1, 0], [2, 2]), identity(2, 2) = reshape([1, 0, 0, 1], [2, 2])
    real(real64), parameter :: mirror(2, 2) = reshape([1, 0, 0, -1], [2, 2])
    !> Pressure on entry of the refused calls, and the stiffness of the sticking contact there: mu p chi / gcr.
    real(real64), parameter :: pressure = 50, stick = 0.3_real64 * pressure * 2.5_real64 / 0.002_real64
    real(real64) :: bad(7), none(30), nan
    character(80), parameter :: ciname = 'BOLT', other = ''

    none = 0
    call refused_interface('FEW', good, 20_int32, identity, good(7), stick)
    bad = good
    bad(7) = 0
    call refused_interface('NO-KN', bad, 84_int32, identity, 0.0_real64, stick)
    bad = good
    bad(1) = -1
    call refused_interface('NO-LAW', bad, 84_int32, identity, 0.0_real64, 0.0_real64)
    call refused_interface('MIRROR', good, 84_int32, mirror, good(7), stick)
    nan = ieee_value(nan, ieee_quiet_nan)
    call refused_interface('NOT-A-NUMBER', good, 84_int32, identity, good(7), stick, [1e-3_real64, 1e-4_real64, 0.0_real64], &
        [0.0_real64, nan, 0.0_real64])
    call refused_interface('TOO-LONG', good, 84_int32, identity, good(7), stick, [1e-3_real64, 1e-4_real64, 0.0_real64], &
        [0.0_real64, 0.0_real64, 1e200_real64])
    call refused_interface('TOO-DEEP', good, 84_int32, identity, good(7), stick, [1e308_real64, 0.0_real64, 0.0_real64], &
        none(:3))
    call turned_interface()
    call unpaired_interface()
    call refused_pairs()
    call single_precision()
    call refused_block(ciname, 0.0_real64)
    ! As many characters as a name and a number can have: more than the host's routine takes.
    call refused_block(repeat('L', 80), -tiny(1.0_real64))
    print '(a)', 'done'

contains

    subroutine call_uinter(name, props, nstate, rdisp, drdisp, drot, stress, statev, ddsddr, pnewdt, sfd, lopenclose)
        character(*), intent(in) :: name
        integer(int32), intent(in) :: nstate
        real(real64), intent(in) :: props(:), rdisp(3), drdisp(3), drot(2, 2)
        real(real64), intent(inout) :: stress(3), statev(:), ddsddr(3, 3), pnewdt, sfd
        integer(int32), intent(inout) :: lopenclose
        real(real64) :: flux(2), sed
        type(zero_outputs) :: zero
        integer(int32) :: lstate, lsdi
        character(80) :: interaction

        interaction = name
        ! A host need not clear what is written.
        ddsddr = untouched
        sfd = untouched
        zero = spoiled(3_int32)
        call uinter(stress, ddsddr, zero%dviscous, zero%dstructural, flux, zero%ddfddt, zero%ddsddt, zero%ddfddr, statev, &
            sed, sfd, zero%spd, zero%svd, zero%scd, pnewdt, rdisp, drdisp, none(:2), none(:2), none(:2), none(:2), none(:2), &
            1.0_real64, 0.0_real64, interaction, other, other, props, none(:3), none(:9), drot, 1.0_real64, 0.0_real64, &
            7_int32, 3_int32, nstate, 1_int32, int(size(props), int32), 3_int32, 2_int32, 5_int32, 1_int32, 0_int32, &
            lopenclose, lstate, lsdi, 0_int32)
        call zero%check()
    end subroutine

    !> `normal` and `tangential`: what DDSDDR must hold then.
    subroutine refused_interface(name, props, nstate, drot, normal, tangential, rdisp, drdisp)
        character(*), intent(in) :: name
        real(real64), intent(in) :: props(:), drot(2, 2), normal, tangential
        real(real64), intent(in), optional :: rdisp(3), drdisp(3)
        integer(int32), intent(in) :: nstate
        real(real64) :: stress(3), statev(84), ddsddr(3, 3), pnewdt, sfd, expected(3, 3), total(3), increment(3)
        integer(int32) :: lopenclose

        total = [1e-3_real64, 1e-4_real64, 0.0_real64]
        increment = [0.0_real64, 1e-4_real64, 0.0_real64]
        if (present(rdisp)) total = rdisp
        if (present(drdisp)) increment = drdisp
        expected = reshape([normal, 0.0_real64, 0.0_real64, 0.0_real64, tangential, 0.0_real64, 0.0_real64, 0.0_real64, &
            tangential], [3, 3])
        stress = [pressure, 3.0_real64, -2.0_real64]
        statev = 0
        pnewdt = 0.8_real64
        lopenclose = 1
        call call_uinter(name, props, nstate, total, increment, drot, stress, statev, ddsddr, pnewdt, sfd, lopenclose)
        call expect(pnewdt == 0.5_real64, 'PNEWDT of a refusal')
        call expect(all(stress == [pressure, 3.0_real64, -2.0_real64]) .and. all(statev == 0), &
            'a refusal leaves STRESS and STATEV')
        call expect(sfd == 0 .and. lopenclose == 1, 'SFD and LOPENCLOSE of a refusal')
        call expect(all(abs(ddsddr - expected) <= 1e-12_real64 * stick), 'DDSDDR of a refusal')
    end subroutine

    !> The slip directions turn by a right angle: the remembered traction turns with them, also in a state that is longer
    !> than what is used of it.
    subroutine turned_interface()
        real(real64) :: stress(3), statev(86), ddsddr(3, 3), pnewdt, sfd, slip(3), first(3)
        integer(int32) :: lopenclose

        statev = 0
        pnewdt = 1
        lopenclose = 0
        slip = [1e-3_real64, 1e-3_real64, 2e-4_real64]
        call call_uinter('BOLT', good, 86_int32, slip, slip, identity, stress, statev, ddsddr, pnewdt, sfd, lopenclose)
        first = stress
        call expect(first(1) == 100 .and. first(2) > 0 .and. first(3) > 0 .and. lopenclose == 1, 'signs of UINTER')
        call expect(ddsddr(1, 1) == good(7) .and. ddsddr(1, 2) == 0 .and. ddsddr(2, 1) > 0, 'signs of DDSDDR')
        call call_uinter('BOLT', good, 86_int32, slip, none(:3), turned, stress, statev, ddsddr, pnewdt, sfd, lopenclose)
        call expect(norm2(stress - [first(1), -first(3), first(2)]) < 1e-12_real64 * first(1), 'the traction turns')
        call expect(norm2(statev(8:9) - [-slip(3), slip(2)]) < 1e-15_real64, 'the jump turns')
        call expect(pnewdt == 1, 'no cutback')
    end subroutine

    !> A point without a partner is open, and what it held is dissipated.
    subroutine unpaired_interface()
        real(real64) :: stress(3), statev(84), ddsddr(3, 3), pnewdt, sfd, slip(3), stored
        integer(int32) :: lopenclose

        statev = 0
        pnewdt = 1
        lopenclose = -1
        slip = [1e-3_real64, 1e-3_real64, 2e-4_real64]
        call call_uinter('BOLT', good, 84_int32, slip, slip, identity, stress, statev, ddsddr, pnewdt, sfd, lopenclose)
        stored = statev(4)
        slip = [-1e36_real64, 1e36_real64, -1e36_real64]
        call call_uinter('BOLT', good, 84_int32, slip, slip, identity, stress, statev, ddsddr, pnewdt, sfd, lopenclose)
        call expect(all(stress == 0) .and. all(ddsddr == 0) .and. lopenclose == 0, 'an open point')
        call expect(stored > 0 .and. sfd == stored .and. statev(4) == 0 .and. pnewdt == 1, 'energy of an open point')
        call expect(abs(statev(8) - 1e-3_real64) < 1e-15_real64, 'the jump of an unpaired point')
    end subroutine

    !> Two contacts, of which the second names a node that is not there; then a state that is too short.
    subroutine refused_pairs()
        real(real64) :: force(2, 2), statev(84, 2), along(3, 2), slip(3, 2)

        along = spread([1.0_real64, 0.0_real64, 0.0_real64], 2, 2)
        slip = 1e-3_real64 * along
        statev = 0
        call call_vfric('NODE', [2_int32, 3_int32], 84_int32, slip, along, force, statev)
        call expect(force(1, 1) < -1 .and. abs(force(2, 1)) < 1e-9_real64, 'friction against the slip')
        call expect(all(force(:, 2) == 0), 'a contact without a node is frictionless')
        call expect(all(statev(:, 1) == 0) .and. statev(1, 2) > 0, 'the state of the node in contact')
        call call_vfric('SHORT', [1_int32, 2_int32], 23_int32, slip, along, force, statev)
        call expect(all(force == 0), 'no state, no friction')
        along(:, 1) = 0
        call call_vfric('NOWHERE', [1_int32, 2_int32], 84_int32, slip, along, force, statev)
        call expect(all(force(:, 1) == 0) .and. force(1, 2) < -1, 'slip without a direction')
        ! Without slip its direction may be anything.
        slip = 0
        along(:, 1) = nan
        along(:, 2) = 1e200_real64
        force = untouched
        call call_vfric('STILL', [1_int32, 2_int32], 84_int32, slip, along, force, statev)
        call expect(all(force == 0), 'no slip, no direction')
        slip(3, 1) = nan
        call call_vfric('NOT-A-NUMBER', [1_int32, 2_int32], 84_int32, slip, along, force, statev)
        statev(10, 2) = nan
        slip = 0
        call call_vfric('STATE', [1_int32, 2_int32], 84_int32, slip, along, force, statev)
        call expect(all(force == 0), 'no number, no friction')
    end subroutine

    subroutine call_vfric(name, slave, nstate, slip, along, force, statev)
        character(*), intent(in) :: name
        integer(int32), intent(in) :: slave(2), nstate
        real(real64), intent(in) :: slip(3, 2), along(3, 2)
        real(real64), intent(inout) :: force(2, 2), statev(84, 2)
        real(real64) :: f_normal(2), normal(3, 2)
        character(80) :: interaction

        interaction = name
        normal = spread([0.0_real64, 0.0_real64, 1.0_real64], 2, 2)
        f_normal = 200
        force = untouched
        call vfric(force, statev, 1_int32, 9_int32, 2_int32, 4_int32, 2_int32, 4_int32, 2_int32, 3_int32, nstate, 7_int32, &
            0_int32, 0_int32, 1_int32, [11_int32, 12_int32], [11_int32, 12_int32], slave, [1_int32, 1_int32], 0.0_real64, &
            0.0_real64, 1e-6_real64, interaction, other, other, 1_int32, slip, f_normal, none(:6), f_normal, 0.0_real64, &
            none, none, none, along, normal, good, [2.0_real64, 2.0_real64], none, none, none, none)
    end subroutine

    !> A host in single precision: named before anything else, and its forces are zero.
    subroutine single_precision()
        use, intrinsic :: iso_fortran_env, only: real32
        real(real32) :: force(2, 2), statev(84, 2), slip(3, 2), f_normal(2), normal(3, 2), along(3, 2), small(30), props(7)
        real(real32) :: area(2), time
        character(80) :: interaction

        interaction = 'SINGLE'
        props = real(good, real32)
        normal = spread([0.0_real32, 0.6_real32, 0.8_real32], 2, 2)
        along = spread([1.0_real32, 0.0_real32, 0.0_real32], 2, 2)
        slip = 1e-3_real32 * along
        f_normal = 200
        area = 2
        small = 0
        time = 0
        statev = 0
        force = 7
        call vfric_single(force, statev, 1_int32, 9_int32, 2_int32, 4_int32, 2_int32, 4_int32, 2_int32, 3_int32, 84_int32, &
            7_int32, 0_int32, 0_int32, 1_int32, [11_int32, 12_int32], [11_int32, 12_int32], [1_int32, 2_int32], &
            [1_int32, 1_int32], time, time, time, interaction, other, other, 1_int32, slip, f_normal, small, f_normal, time, &
            small, small, small, along, normal, props, area, small, small, small, small)
        call expect(all(force == 0) .and. all(statev == 0), 'no friction in single precision')
    end subroutine

    !> A first contact with an area that is none, under load.
    subroutine refused_block(interaction, no_area)
        character(80), intent(in) :: interaction
        real(real64), intent(in) :: no_area
        real(real64) :: force(1, 2), state(44, 1, 2), normal(2, 2), along(2, 2), slip(2, 2)

        normal = spread([0.0_real64, 1.0_real64], 2, 2)
        along = spread([1.0_real64, 0.0_real64], 2, 2)
        slip = 1e-3_real64 * along
        state = 0
        call vfriction(force, state, 2_int32, 2_int32, 2_int32, 1_int32, 1_int32, 1_int32, 1_int32, 2_int32, 44_int32, &
            7_int32, 0_int32, 0_int32, [3_int32, 4_int32, 1_int32], none(:4), interaction, other, other, [21_int32, 22_int32], &
            [31_int32, 32_int32], good, slip, none, none, [200.0_real64, 200.0_real64], [no_area, 2.0_real64], normal, &
            along, none, none, none, none, none, none, none, none, none, none)
        call expect(force(1, 1) == 0 .and. all(state(:, :, 1) == 0), 'no area, no friction')
        call expect(force(1, 2) < -1, 'the contact with an area')
    end subroutine
end program
