!> A worked example of the Abaqus-shaped routine `fric`, in the role of the FE program: a table in, a table out.
program fric_replay
    use, intrinsic :: iso_fortran_env, only: int32, real64
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use fric_host, only: model, contact_point, step, respond, contact_status
    use mepc, only: mepc_state_size, mepc_last_error
    use text_table, only: table, read_table, print_table, read_number, fail
    implicit none

    character(*), parameter :: usage = new_line("a") // &
        "usage: fric_replay point PROPS HISTORY.csv [--nstate N] [--length L]  time,slip_1[,slip_2],pressure" // &
        new_line("a") // &
        "       fric_replay patch PROPS PATCH.csv HISTORY.csv [--nstate N] [--length L] [--series K] [--parallel K]" // &
        new_line("a") // &
        "               x,y,area,pressure and time,displacement_1[,displacement_2,rotation][,pressure_scale]" // &
        new_line("a") // &
        "PROPS are the properties mu,gcr,exponent,... of the README's table; gcr = 0 needs the length L of a contact face." // &
        new_line("a") // &
        "A row is the end of a step, the first one from zero slip and pressure. The table goes to standard output."

    integer, parameter :: max_iterations = 100, max_halvings = 40
    character(len=59), parameter :: point_headers(2) = [character(59) :: "time,slip_1,pressure", "time,slip_1,slip_2,pressure"]
    character(len=59), parameter :: patch_headers(4) = [character(59) :: "time,displacement_1", &
        "time,displacement_1,pressure_scale", "time,displacement_1,displacement_2,rotation", &
        "time,displacement_1,displacement_2,rotation,pressure_scale"]

    !> Contact points under one rigid tangential motion, behind a spring K; see `solve`.
    type :: patch
        real(real64), allocatable :: x(:), y(:), area(:), pressure(:)
        type(contact_point), allocatable :: now(:), next(:)   ! at the last accepted step; on trial
        real(real64) :: way(2) = 0, turn = 0, scale = 1       ! prescribed: displacement, rotation, factor
        real(real64) :: force(2) = 0, stiffness(2, 2) = 0, moment = 0, stored = 0, dissipated = 0, limit = 0
    end type

    type(model) :: m
    type(table) :: history
    real(real64) :: series, parallel

    call read_arguments()
    if (argument(1) == "point") then
        call replay_point()
    else
        call replay_patch(read_table(argument(3), ["x,y,area,pressure"]))
    end if

contains

    !> Argument number i; empty past the last.
    function argument(i) result(text)
        integer, intent(in) :: i
        character(:), allocatable :: text
        integer :: length
        call get_command_argument(i, length=length)
        allocate (character(len=length) :: text)
        call get_command_argument(i, text)
    end function

    !> Reads the history and the properties; ends the program if the command line is wrong.
    subroutine read_arguments()
        character(:), allocatable :: list
        real(real64) :: value, nstate
        integer :: i, files, comma

        files = merge(2, 1, argument(1) == "patch")
        if (argument(1) /= "point" .and. files == 1 .or. command_argument_count() < 2 + files) then
            call fail("wrong command line" // usage, 2)
        end if
        series = 0
        parallel = 0
        nstate = 0
        do i = 3 + files, command_argument_count(), 2
            if (.not. read_number(argument(i + 1), value) .or. value < 0) value = -1
            select case (argument(i))
            case ("--nstate")
                nstate = value
            case ("--length")
                m%length = value
            case ("--series")
                series = value
            case ("--parallel")
                parallel = value
            case default
                value = -1
            end select
            if (value < 0 .or. nstate > 1e6_real64) call fail("wrong command line at '" // argument(i) // "'" // usage, 2)
        end do
        allocate (m%props(0))
        list = argument(2) // ","
        do while (len(list) > 0)
            comma = index(list, ",")
            if (.not. read_number(list(:comma - 1), value)) then
                call fail("wrong command line at '" // argument(2) // "'" // usage, 2)
            end if
            m%props = [m%props, value]
            list = list(comma + 1:)
        end do
        if (files == 1) then
            history = read_table(argument(3), point_headers)
        else
            history = read_table(argument(4), patch_headers)
        end if
        m%ndir = merge(2, 1, index(history%header, "_2") > 0)
        m%nstate = mepc_state_size(m%props, int(size(m%props), int32), m%ndir)
        if (m%nstate < 0) call fail("PROPS: " // mepc_last_error())
        if (nstate > 0) m%nstate = int(nstate, int32)
    end subroutine

    type(step) function step_at(row)
        integer, intent(in) :: row
        step_at%increment = int(row, int32)
        step_at%time = history%values(1, row)
        step_at%dtime = step_at%time - history%values(1, max(row - 1, 1))
        step_at%place = history%place(row)
    end function

    type(contact_point) function virgin_point(number)
        integer, intent(in) :: number
        virgin_point%number = int(number, int32)
        allocate (virgin_point%statev(m%nstate), source=0.0_real64)
    end function

    !> One point under prescribed slip and pressure.
    subroutine replay_point()
        type(contact_point) :: now, next
        real(real64) :: results(m%ndir + 3, size(history%values, 2)), increment(2), tangent(2, 2), dissipated, total
        integer :: row, n

        n = m%ndir
        now = virgin_point(1)
        total = 0
        increment = 0
        do row = 1, size(history%values, 2)
            increment(:n) = history%values(2:1 + n, row)
            if (row > 1) increment(:n) = increment(:n) - history%values(2:1 + n, row - 1)
            call respond(m, step_at(row), now, increment, history%values(2 + n, row), next, tangent, dissipated)
            now = next ! the step is accepted
            total = total + dissipated
            results(:, row) = [now%tau(:n), now%sed, total, real(contact_status(now), real64)]
        end do
        call print_table(history, trim(merge("traction_1           ", "traction_1,traction_2", n == 1)) // &
            ",stored_energy,dissipated_energy,status", results)
    end subroutine

    !> Points that share a rigid tangential motion.
    subroutine replay_patch(points)
        type(table), intent(in) :: points
        type(patch) :: p
        real(real64) :: results(6 + 3 * m%ndir, size(history%values, 2)), at(2), rotation, slip(2), dissipated
        integer :: row, i, n, iterations, contacts(0:3)

        n = m%ndir
        p%x = points%values(1, :)
        p%y = points%values(2, :)
        p%area = points%values(3, :)
        p%pressure = points%values(4, :)
        p%now = [(virgin_point(i), i=1, size(p%x))]
        p%next = p%now
        do i = 1, size(p%x)
            p%now(i)%position(1:2) = [p%x(i), p%y(i)]
        end do
        at = 0
        rotation = 0
        dissipated = 0
        do row = 1, size(history%values, 2)
            associate (in => history%values(:, row)) ! time, displacement, [rotation], [scale]
                p%way(:n) = in(2:1 + n) - at(:n)
                if (n == 2) p%turn = in(4) - rotation
                if (modulo(size(in), 2) == 1) p%scale = in(size(in))
                slip = p%way
                iterations = 0
                if (series > 0) then
                    call solve(p, step_at(row), slip, iterations)
                else
                    call evaluate(p, step_at(row), slip) ! rigid: the slip is prescribed
                end if
                p%now = p%next ! the step is accepted
                at = at + slip
                rotation = rotation + p%turn
                dissipated = dissipated + p%dissipated
                contacts = 0
                do i = 1, size(p%now)
                    associate (status => contacts(contact_status(p%now(i))))
                        status = status + 1
                    end associate
                end do
                results(:, row) = [at(:n), p%force(:n) + parallel * in(2:1 + n), [(p%moment, i=2, n)], p%stored, dissipated, &
                    real([contacts, iterations], real64)]
            end associate
        end do
        call print_table(history, &
            trim(merge("slip_1,force_1                      ", "slip_1,slip_2,force_1,force_2,moment", n == 1)) // &
            ",stored_energy,dissipated_energy,open,stick,micro_slip,gross_slip,iterations", results)
    end subroutine

    !> Tries a common slip increment, and sums up over the points.
    subroutine evaluate(p, s, slip)
        type(patch), intent(inout) :: p
        type(step), intent(in) :: s
        real(real64), intent(in) :: slip(2)
        real(real64) :: increment(2), tangent(2, 2), dissipated
        integer, parameter :: shear_limit = 3
        integer :: i

        p%force = 0
        p%stiffness = 0
        p%moment = 0
        p%stored = 0
        p%dissipated = 0
        p%limit = 0
        do i = 1, size(p%x)
            increment = slip + p%turn * [-p%y(i), p%x(i)]
            call respond(m, s, p%now(i), increment, p%scale * p%pressure(i), p%next(i), tangent, dissipated)
            associate (point => p%next(i))
                p%force = p%force + p%area(i) * point%tau
                p%stiffness = p%stiffness + p%area(i) * tangent
                p%moment = p%moment + p%area(i) * (p%x(i) * point%tau(2) - p%y(i) * point%tau(1))
                p%stored = p%stored + p%area(i) * point%sed
                p%dissipated = p%dissipated + p%area(i) * dissipated
                if (contact_status(point) > 0) p%limit = p%limit + p%area(i) * point%statev(shear_limit)
            end associate
        end do
    end subroutine

    !> Equilibrium of the patch with its spring: the displacement u is prescribed beyond the spring, and the slip g that
    !> the points share follows from r(g) = K (g - u) + sum of A_i tau_i(g) = 0 by Newton's method with the routine's
    !> tangent. Every trial starts from the last accepted step.
    subroutine solve(p, s, slip, iterations)
        type(patch), intent(inout) :: p
        type(step), intent(in) :: s
        real(real64), intent(out) :: slip(2)
        integer, intent(out) :: iterations
        real(real64) :: r(2), before(2), direction(2), start(2), spring, part, a, b, c, d
        integer :: halving

        slip = 0
        call evaluate(p, s, slip)
        spring = series * norm2(p%way)
        do iterations = 0, merge(max_iterations, -1, ieee_is_finite(spring))
            r = series * (slip - p%way) + p%force
            ! A residual below this part of the forces at hand is rounding of the sums.
            if (norm2(r) <= 1e-13_real64 * (p%limit + spring)) return
            ! -J^-1 r with J = K I + d force / d slip, by elimination.
            a = series + p%stiffness(1, 1)
            b = p%stiffness(1, 2)
            c = p%stiffness(2, 1) / a
            d = series + p%stiffness(2, 2)
            direction(2) = -(r(2) - c * r(1)) / (d - c * b)
            direction(1) = -(r(1) + b * direction(2)) / a
            ! Half of the way again and again until the residual falls: the stiffness jumps where the motion turns.
            start = slip
            before = r
            part = 1
            do halving = 1, max_halvings
                slip = start + part * direction
                if (.not. all(ieee_is_finite(slip))) exit
                call evaluate(p, s, slip)
                r = series * (slip - p%way) + p%force
                if (norm2(r) < norm2(before)) exit
                part = part / 2
            end do
            if (.not. norm2(r) < norm2(before)) exit
        end do
        call fail(s%place // "no equilibrium: Newton's method does not converge")
    end subroutine
end program
