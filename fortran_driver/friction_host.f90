!> The FE program's side of the friction routine: what a host keeps for a contact point, when it calls `fric`, and with what.
!>
!> The rules of the house, which the routine relies on:
!> - STATEV and TAU are committed when a step is accepted. Every trial of a step starts from the committed ones, so `now` goes
!>   in, `next` comes out, and a trial that is not accepted is forgotten by not keeping `next`.
!> - The routine is called for closed points only.
!> - LM goes in as it came out.
module friction_host
    use, intrinsic :: iso_fortran_env, only: int32, real64
    use, intrinsic :: ieee_exceptions, only: ieee_flag_type, ieee_get_flag, ieee_set_flag, ieee_divide_by_zero, &
        ieee_invalid
    use mepc, only: fric, mepc_contact_open
    use replay_text, only: fail, whole
    implicit none
    private
    public :: friction_model, contact_point, step_info, virgin_point, touch, respond, contact_status, critical_slip

    !> Answers of LM.
    integer(int32), parameter :: slipping = 0, sticking = 1, frictionless = 2

    integer, parameter :: method_lagrange = 2
    integer, parameter :: rule_proportional = 1

    !> What all points share.
    type :: friction_model
        integer(int32) :: ndir = 1                 !< tangential directions, 1 or 2
        integer(int32) :: nstate = 0
        real(real64), allocatable :: props(:)
        real(real64) :: characteristic_length = 0
    end type

    !> What the host keeps for a point at the end of a step.
    type :: contact_point
        integer(int32) :: number = 1
        real(real64) :: position(3) = 0
        integer(int32) :: lm = frictionless        !< frictionless: open
        real(real64) :: pressure = 0
        real(real64) :: tau(2) = 0
        real(real64) :: slip(2) = 0                !< the part that does not come back
        real(real64) :: sed = 0                    !< stored energy density, last reported
        real(real64) :: elongation(2) = 0          !< of the multiplier's spring, method 2 only
        real(real64), allocatable :: statev(:)
    end type

    !> Which step it is and where it ends.
    type :: step_info
        integer(int32) :: increment = 0
        real(real64) :: time = 0
        real(real64) :: dtime = 0
        character(:), allocatable :: place         !< "file:line: step n", for messages
    end type

    !> What one call of the routine is given and gives besides the state of the point.
    type :: fric_arguments
        integer(int32) :: lm = slipping
        real(real64) :: dgam(2) = 0
        real(real64) :: taulm(2) = 0
        real(real64) :: ddtddg(2, 2) = 0
        real(real64) :: sfd = 0
    end type

contains

    function virgin_point(model, number, x, y) result(point)
        type(friction_model), intent(in) :: model
        integer, intent(in) :: number
        real(real64), intent(in) :: x, y
        type(contact_point) :: point
        point%number = int(number, int32)
        point%position(1:2) = [x, y]
        allocate (point%statev(model%nstate), source=0.0_real64)
    end function

    !> The closing of an open point, an increment of its own and without slip: LM = 2 tells the routine that the point was
    !> open, and it clears its memory. The slip of the step follows in `respond`, so that all of it counts.
    subroutine touch(model, step, pressure, point)
        type(friction_model), intent(in) :: model
        type(step_info), intent(in) :: step
        real(real64), intent(in) :: pressure
        type(contact_point), intent(inout) :: point
        type(contact_point) :: next
        type(fric_arguments) :: args

        if (pressure <= 0 .or. point%lm /= frictionless) return
        args%lm = frictionless
        call call_fric(model, step, point, pressure, args, next)
        ! The routine now reports as SFD what was stored when the point opened. `respond` has booked that when it happened,
        ! therefore args%sfd is not added here.
        point = next
        point%tau = 0
        point%sed = 0
        ! A multiplier holds a fresh contact until it exceeds the limit; the other methods start from LM = 0.
        point%lm = merge(sticking, slipping, is_lagrange(model))
    end subroutine

    !> Tries a step of one point: slip increment and pressure at its end. `tangent` is d traction / d slip, `stored` the
    !> stored energy density at the end, `dissipated` what the step dissipates.
    subroutine respond(model, step, now, slip_increment, pressure, next, tangent, stored, dissipated)
        type(friction_model), intent(in) :: model
        type(step_info), intent(in) :: step
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: slip_increment(2), pressure
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), stored, dissipated

        if (pressure <= 0) then
            call open_point(model, now, next, dissipated)
            tangent = 0
            stored = 0
        else if (is_lagrange(model)) then
            call respond_lagrange(model, step, now, slip_increment, pressure, next, tangent, stored, dissipated)
        else
            call respond_penalty(model, step, now, slip_increment, pressure, next, tangent, stored, dissipated)
        end if
    end subroutine

    !> What the contact does: 0 open, else the first state variable.
    integer function contact_status(point)
        type(contact_point), intent(in) :: point
        contact_status = mepc_contact_open
        if (point%lm /= frictionless) contact_status = nint(point%statev(1))
    end function

    logical function is_lagrange(model)
        type(friction_model), intent(in) :: model
        is_lagrange = nint(property(model, 4, 0.0_real64)) == method_lagrange
    end function

    !> A property by its number in the table, or the default of a trailing one that is missing.
    real(real64) function property(model, number, default)
        type(friction_model), intent(in) :: model
        integer, intent(in) :: number
        real(real64), intent(in) :: default
        property = default
        if (number <= size(model%props)) property = model%props(number)
    end function

    !> The routine is not called for an open point. What was stored is lost: it counts as dissipated.
    subroutine open_point(model, now, next, dissipated)
        type(friction_model), intent(in) :: model
        type(contact_point), intent(in) :: now
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: dissipated

        dissipated = merge(spring_energy(now), now%sed, is_lagrange(model))
        next = now
        next%lm = frictionless
        next%pressure = 0
        next%tau = 0
        next%sed = 0
        next%elongation = 0
    end subroutine

    !> Methods 0 and 1: one call with the whole slip of the step.
    subroutine respond_penalty(model, step, now, slip_increment, pressure, next, tangent, stored, dissipated)
        type(friction_model), intent(in) :: model
        type(step_info), intent(in) :: step
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: slip_increment(2), pressure
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), stored, dissipated
        type(fric_arguments) :: args

        args%lm = now%lm
        args%dgam = slip_increment
        call call_fric(model, step, now, pressure, args, next)
        tangent = args%ddtddg
        stored = next%sed
        dissipated = args%sfd
    end subroutine

    !> Method 2. The routine sticks rigidly and leaves the stress to the host's Lagrange multiplier. Under a prescribed slip
    !> that stress is undetermined, so this host puts a stiff spring between the prescribed slip and the slip of the
    !> contact: the multiplier is the force of the spring, at most mu p, and the contact slips by the rest.
    subroutine respond_lagrange(model, step, now, slip_increment, pressure, next, tangent, stored, dissipated)
        type(friction_model), intent(in) :: model
        type(step_info), intent(in) :: step
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: slip_increment(2), pressure
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), stored, dissipated
        real(real64) :: stiffness, elongation(2), lost, sfd

        stiffness = multiplier_stiffness(model, pressure)
        elongation = elongation_under(model, now, pressure)
        lost = spring_energy(now) - 0.5_real64 * stiffness * sum(elongation**2)
        call iterate_lm(model, step, now, elongation, slip_increment, pressure, stiffness, next, tangent, sfd)
        stored = spring_energy(next)
        dissipated = sfd + lost
    end subroutine

    !> Energy in the multiplier's spring of a point; the rigid contact itself stores none.
    pure real(real64) function spring_energy(point)
        type(contact_point), intent(in) :: point
        spring_energy = 0.5_real64 * dot_product(point%tau, point%elongation)
    end function

    !> Stiffness of the multiplier's spring: a thousand times that of the standard penalty with the critical slip of the
    !> properties. Never zero (mu = 0), because we divide by its square.
    real(real64) function multiplier_stiffness(model, pressure)
        type(friction_model), intent(in) :: model
        real(real64), intent(in) :: pressure
        multiplier_stiffness = max(1000 * model%props(1) * pressure / critical_slip(model), 2 * sqrt(tiny(1.0_real64)))
    end function

    !> The critical slip that the properties name, zero if they leave it to a characteristic length that is not there.
    real(real64) function critical_slip(model)
        type(friction_model), intent(in) :: model
        critical_slip = property(model, 2, 0.0_real64)
        if (critical_slip <= 0) critical_slip = property(model, 6, 0.005_real64) * model%characteristic_length
    end function

    !> Elongation of the spring after the change of pressure, before any slip. The stiffness follows the pressure, and under
    !> the dissipative rule stiffness that arrives with a rising pressure arrives unloaded: the force stays.
    function elongation_under(model, now, pressure) result(elongation)
        type(friction_model), intent(in) :: model
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: pressure
        real(real64) :: elongation(2)

        elongation = now%elongation
        if (nint(property(model, 5, 0.0_real64)) == rule_proportional) return
        if (pressure > now%pressure) elongation = elongation * (now%pressure / pressure)
    end function

    !> The LM protocol of one increment: calls the routine until its answer and the multiplier agree. The contact sticks while
    !> the routine returns LM = 1. With LM = 0 it slips by the DGAM that leaves the spring with the TAU that the routine
    !> returns. `elongation` is that of the spring before the increment.
    subroutine iterate_lm(model, step, now, elongation, slip_increment, pressure, stiffness, next, tangent, sfd)
        type(friction_model), intent(in) :: model
        type(step_info), intent(in) :: step
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: elongation(2), slip_increment(2), pressure, stiffness
        type(contact_point), intent(inout) :: next
        real(real64), intent(out) :: tangent(2, 2), sfd
        integer, parameter :: max_calls = 10
        type(fric_arguments) :: args
        real(real64) :: total(2), unbalanced(2), tolerance
        integer(int32) :: asked
        integer :: i

        tangent = 0
        sfd = 0
        total = elongation + slip_increment ! to be shared between spring and contact
        tolerance = 1e-13_real64 * model%props(1) * pressure + 4 * epsilon(1.0_real64) * stiffness * norm2(total)
        asked = now%lm
        args%taulm = now%tau
        args%dgam = slip_increment
        do i = 1, max_calls
            if (asked == sticking) then
                args%dgam = 0
                args%taulm = stiffness * total
            end if ! else TAULM stays what it was when the point last stuck
            args%lm = asked
            call call_fric(model, step, now, pressure, args, next)
            if (next%lm == sticking .and. asked == sticking) then
                next%tau = args%taulm
                next%elongation = total
                tangent = stiffness * identity()
                sfd = args%sfd
                return
            else if (next%lm == slipping) then
                unbalanced = stiffness * (total - args%dgam) - next%tau
                if (norm2(unbalanced) <= tolerance) then
                    next%elongation = next%tau / stiffness
                    tangent = stiffness * identity() ! at rest; else spring and contact in series
                    if (stiffness * norm2(args%dgam) > tolerance) then
                        tangent = stiffness * matmul(inverse(tangent + args%ddtddg), args%ddtddg)
                    end if
                    sfd = args%sfd
                    return
                end if
                ! Friction is along the motion, so the total, its two parts and the stress have one direction.
                args%dgam = (1 - norm2(next%tau) / (stiffness * norm2(total))) * total
            end if
            asked = next%lm
        end do
        call fail(step%place // ": point " // whole(int(now%number)) // &
            ": the iteration between stick and slip (LM) does not end")
    end subroutine

    pure function identity() result(matrix)
        real(real64) :: matrix(2, 2)
        matrix = reshape([1.0_real64, 0.0_real64, 0.0_real64, 1.0_real64], [2, 2])
    end function

    pure function inverse(a) result(b)
        real(real64), intent(in) :: a(2, 2)
        real(real64) :: b(2, 2)
        b(1, 1) = a(2, 2)
        b(2, 2) = a(1, 1)
        b(1, 2) = -a(1, 2)
        b(2, 1) = -a(2, 1)
        b = b / (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1))
    end function

    !> Calls the routine as the FE program does, with all its arguments. `args` holds LM, DGAM and TAULM going in, DDTDDG and
    !> SFD coming out; `next` is the point afterwards, with the LM that came out. Hosts trap the watched exceptions: a call that
    !> is not refused must raise none.
    subroutine call_fric(model, step, now, pressure, args, next)
        type(friction_model), intent(in) :: model
        type(step_info), intent(in) :: step
        type(contact_point), intent(in) :: now
        real(real64), intent(in) :: pressure
        type(fric_arguments), intent(inout) :: args
        type(contact_point), intent(inout) :: next
        integer(int32), parameter :: mcrd = 3, npred = 1, kstep = 1, surface = 0
        character(80), parameter :: ciname = "REPLAY", slname = "SLAVE", msname = "MASTER"
        real(real64) :: ddtddg(model%ndir, model%ndir), ddtddp(model%ndir), dslip(model%ndir), ddtddt(model%ndir, 2)
        real(real64) :: temp(2), predef(2, npred), drot(2, 2), ddpddh, sfd, pnewdt
        type(ieee_flag_type), parameter :: watched(2) = [ieee_divide_by_zero, ieee_invalid]
        logical :: raised(size(watched))

        next = now
        next%lm = args%lm
        next%pressure = pressure
        ddtddg = 0
        ddtddp = 0
        dslip = 0
        ddtddt = 0
        sfd = 0
        temp = 0
        predef = 0
        pnewdt = 1
        ddpddh = 0           ! the pressure is prescribed here, no contact stiffness makes it
        drot = identity()    ! small motions: the slip directions stay
        call ieee_set_flag(watched, .false.)
        call fric(next%lm, next%tau, ddtddg, ddtddp, dslip, next%sed, sfd, ddtddt, pnewdt, next%statev, args%dgam, &
            args%taulm, pressure, pressure - now%pressure, ddpddh, now%slip, kstep, step%increment, &
            [step%time, step%time], step%dtime, surface, ciname, slname, msname, now%number, now%number, now%number, &
            now%position, now%position, drot, temp, predef, model%ndir, mcrd, npred, model%nstate, &
            model%characteristic_length, model%props, int(size(model%props), int32))
        if (pnewdt < 1) then
            call fail(step%place // ": point " // whole(int(now%number)) // &
                ": the friction routine refuses the increment (PNEWDT < 1), its message is above")
        end if
        call ieee_get_flag(watched, raised)
        if (any(raised)) then
            call fail(step%place // ": point " // whole(int(now%number)) // &
                ": the friction routine raises a floating-point exception")
        end if
        next%slip(:model%ndir) = now%slip(:model%ndir) + dslip
        args%ddtddg = 0
        args%ddtddg(:model%ndir, :model%ndir) = ddtddg
        args%sfd = sfd
    end subroutine
end module
