!> The FE program's side of the friction routine: what a host keeps for a contact point, when and how it calls `fric`.
!> - STATEV and TAU are committed when a step is accepted: `now` goes in, `next` comes out, and a trial that is not
!>   accepted is forgotten by not keeping `next`.
!> - The routine is called for closed points only, and LM goes in as it came out.
module fric_host
    use, intrinsic :: iso_fortran_env, only: int32, real64
    use mepc, only: fric, mepc_contact_open
    use text_table, only: fail, whole
    implicit none
    private
    public :: model, contact_point, step, respond, contact_status

    !> Relative motion flag LM.
    integer(int32), parameter :: slipping = 0, sticking = 1, open = 2
    integer, parameter :: mu = 1, gcr = 2, method = 4, reference_pressure = 5, fraction = 6, cohesion = 12, lagrange = 2

    !> What all points share.
    type :: model
        integer(int32) :: ndir = 1, nstate = 0
        real(real64), allocatable :: props(:)
        real(real64) :: length = 0                !< characteristic length of the contact face
    end type

    !> What the host keeps for a point.
    type :: contact_point
        integer(int32) :: number = 1, lm = open
        real(real64) :: position(3) = 0, pressure = 0, tau(2) = 0
        real(real64) :: slip(2) = 0               !< the part that does not come back
        real(real64) :: sed = 0                   !< stored energy per area
        real(real64) :: stiffness = 0             !< of the multiplier, method 2 only
        real(real64), allocatable :: statev(:)
    end type

    type :: step
        integer(int32) :: increment = 0
        real(real64) :: time = 0, dtime = 0
        character(:), allocatable :: place        !< "file:line: ", for messages
    end type

contains

    !> Tries a step of one point: slip increment and pressure at its end; `tangent` is d traction / d slip, `dissipated`
    !> the energy per area that the step dissipates.
    subroutine respond(m, s, now, dgam, pressure, next, tangent, dissipated)
        type(model), intent(in) :: m
        type(step), intent(in) :: s
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: dgam(2), pressure
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), dissipated
        type(contact_point) :: closed
        real(real64), parameter :: zero(2) = 0

        if (pressure <= 0) then ! what was stored is lost
            next = now
            next%lm = open
            next%pressure = 0
            next%tau = 0
            next%sed = 0
            tangent = 0
            dissipated = now%sed
            return
        end if
        closed = now
        if (now%lm == open) then
            ! The closing, an increment of its own and without slip: LM = 2 tells the routine that the point was open, and
            ! it clears its memory. What it reports in SFD was counted when the point opened.
            call call_fric(m, s, now, zero, zero, pressure, closed, tangent, dissipated)
            closed%lm = merge(sticking, slipping, nint(property(m, method)) == lagrange)
            closed%pressure = 0
            closed%tau = 0
            closed%sed = 0
            closed%stiffness = multiplier_stiffness(m, pressure)
        end if
        if (nint(property(m, method)) == lagrange) then
            call hold_or_slip(m, s, closed, dgam, pressure, next, tangent, dissipated)
        else
            call call_fric(m, s, closed, dgam, zero, pressure, next, tangent, dissipated)
        end if
    end subroutine

    !> Method 2: the routine sticks rigidly and leaves the traction to the host's Lagrange multiplier. Under a prescribed
    !> slip that is undetermined, so this host puts a stiff spring between the prescribed slip and that of the contact: the
    !> multiplier is the spring's traction. The contact sticks while the routine answers LM = 1; with LM = 0 it slips by
    !> the DGAM that leaves the spring with the TAU that the routine returns. The increment is repeated until both agree.
    subroutine hold_or_slip(m, s, now, dgam, pressure, next, tangent, dissipated)
        type(model), intent(in) :: m
        type(step), intent(in) :: s
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: dgam(2), pressure
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), dissipated
        real(real64), parameter :: identity(2, 2) = reshape([1, 0, 0, 1], [2, 2])
        real(real64) :: k, trial(2), slip(2), taulm(2)
        type(contact_point) :: start
        integer :: i

        k = now%stiffness
        trial = now%tau + k * dgam ! the multiplier if nothing slips
        start = now
        slip = dgam
        taulm = now%tau            ! with LM = 0 what it was when the point last stuck
        do i = 1, 10
            if (start%lm == sticking) then
                slip = 0
                taulm = trial
            end if
            call call_fric(m, s, start, slip, taulm, pressure, next, tangent, dissipated)
            if (next%lm == sticking .and. start%lm == sticking) then
                next%tau = trial
                tangent = k * identity
                exit
            else if (next%lm == slipping) then
                if (norm2(trial - k * slip - next%tau) <= 1e-13_real64 * norm2(trial)) then
                    ! At rest the spring, else spring and contact in series (one stiffness of DDTDDG is zero).
                    tangent = k / (k + tangent(1, 1) + tangent(2, 2)) * tangent
                    if (.not. norm2(slip) > 0) tangent = k * identity
                    exit
                end if
                ! Friction is along the motion: the trial, the slip and the traction have one direction.
                slip = (1 - norm2(next%tau) / max(norm2(trial), tiny(k))) * trial / k
            end if
            start%lm = next%lm
        end do
        if (i > 10) call fail(s%place // "point " // whole(int(now%number)) // ": stick and slip (LM) do not settle")
        next%sed = dot_product(next%tau, next%tau) / (2 * k) ! in the spring; the rigid contact stores none
    end subroutine

    !> Stiffness of that spring: a thousand times that of the standard penalty. Never zero, because we divide by it.
    real(real64) function multiplier_stiffness(m, pressure)
        type(model), intent(in) :: m
        real(real64), intent(in) :: pressure
        real(real64) :: p, critical
        p = property(m, reference_pressure)
        if (p <= 0) p = pressure
        critical = property(m, gcr)
        if (critical <= 0) critical = m%length * merge(property(m, fraction), 0.005_real64, property(m, fraction) > 0)
        multiplier_stiffness = max(1000 * (property(m, cohesion) + property(m, mu) * p) / critical, 1e-100_real64)
    end function

    !> A property by its number in the table; a trailing one that is missing is zero.
    real(real64) function property(m, number)
        type(model), intent(in) :: m
        integer, intent(in) :: number
        property = 0
        if (number <= size(m%props)) property = m%props(number)
    end function

    !> What the contact does: 0 open, else the first state variable.
    integer function contact_status(point)
        type(contact_point), intent(in) :: point
        contact_status = mepc_contact_open
        if (point%lm /= open) contact_status = nint(point%statev(1))
    end function

    !> Calls the routine with all its arguments.
    subroutine call_fric(m, s, now, dgam, taulm, pressure, next, tangent, sfd)
        type(model), intent(in) :: m
        type(step), intent(in) :: s
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: dgam(2), taulm(2), pressure
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), sfd
        integer(int32), parameter :: kstep = 1, noel = 0, mcrd = 3, npred = 1
        real(real64), parameter :: drot(2, 2) = reshape([1, 0, 0, 1], [2, 2]) ! small motions: the slip directions stay
        real(real64), parameter :: ddpddh = 0                                 ! the pressure is prescribed
        character(80), parameter :: ciname = "REPLAY", slname = "SLAVE", msname = "MASTER"
        real(real64) :: ddtddg(m%ndir, m%ndir), ddtddp(m%ndir), dslip(m%ndir), ddtddt(m%ndir, 2), pnewdt
        real(real64) :: temp(2), predef(2, npred)

        next = now
        next%pressure = pressure
        ddtddg = 0
        ddtddp = 0
        dslip = 0
        ddtddt = 0
        temp = 0
        predef = 0
        sfd = 0
        pnewdt = 1
        call fric(next%lm, next%tau, ddtddg, ddtddp, dslip, next%sed, sfd, ddtddt, pnewdt, next%statev, dgam, taulm, &
            pressure, pressure - now%pressure, ddpddh, now%slip, kstep, s%increment, [s%time, s%time], s%dtime, noel, &
            ciname, slname, msname, now%number, now%number, now%number, now%position, now%position, drot, temp, predef, &
            m%ndir, mcrd, npred, m%nstate, m%length, m%props, int(size(m%props), int32))
        if (pnewdt < 1) call fail(s%place // "point " // whole(int(now%number)) // &
            ": fric refuses the increment (PNEWDT < 1), its reason is above")
        next%slip(:m%ndir) = now%slip(:m%ndir) + dslip
        tangent = 0
        tangent(:m%ndir, :m%ndir) = ddtddg
    end subroutine
end module
