!> Contact points under one rigid tangential motion, with a spring in series: equilibrium
!>
!>     r(g) = K (g - u) + sum of A_i tau_i(g) = 0
!>
!> u is prescribed, g is the slip that the points share (plus the rotation, which does not pass through the spring).
!> Newton with the tangent of the friction routine; every trial starts from the last accepted step.
module friction_patch
    use, intrinsic :: iso_fortran_env, only: real64
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use csv, only: csv_table, csv_read
    use friction_host, only: friction_model, contact_point, step_info, virgin_point, touch, respond, &
        contact_status
    use mepc, only: mepc_contact_open, mepc_contact_gross_slip
    use replay_text, only: fail, whole
    implicit none
    private
    public :: patch, motion, new_patch

    integer, parameter :: max_iterations = 50
    integer, parameter :: max_backtracks = 30
    integer, parameter :: max_halvings = 12

    !> A residual below this part of the forces at hand is rounding of the sums.
    real(real64), parameter :: tolerance = 1e-13_real64

    !> What is prescribed at the end of a step.
    type :: motion
        real(real64) :: displacement(2) = 0     !< beyond the series spring
        real(real64) :: rotation = 0            !< small, about the origin
        real(real64) :: pressure_scale = 0      !< multiplies the pressures of the patch
    end type

    type :: patch
        type(friction_model) :: model
        real(real64) :: series = 0              !< stiffness of the series spring, 0: rigid
        real(real64), allocatable :: x(:), y(:), area(:), reference_pressure(:)

        ! At the last accepted step.
        type(motion) :: at
        real(real64) :: slip(2) = 0             !< common to all points
        real(real64) :: dissipated = 0
        type(contact_point), allocatable :: now(:)

        ! Of the step being tried: the points, and the sums over them.
        type(contact_point), allocatable :: next(:)
        real(real64) :: force(2) = 0
        real(real64) :: stiffness(2, 2) = 0     !< d force / d common slip
        real(real64) :: moment = 0
        real(real64) :: stored = 0
        real(real64), private :: dissipated_in_step = 0
    contains
        procedure :: advance
        procedure :: counts
        procedure, private :: evaluate, commit, residual, force_scale, correction, line_search, solve
    end type

contains

    !> Reads the patch file. All points are virgin and without slip.
    function new_patch(file, model, series) result(p)
        character(*), intent(in) :: file
        type(friction_model), intent(in) :: model
        real(real64), intent(in) :: series
        type(patch) :: p
        type(csv_table) :: table
        integer :: i

        table = csv_read(file)
        p%model = model
        p%series = series
        allocate (p%x, source=table%column("x"))
        allocate (p%y, source=table%column("y"))
        allocate (p%area, source=table%column("area"))
        allocate (p%reference_pressure, source=table%column("pressure"))
        call table%note_unused()
        allocate (p%now(table%rows))
        do i = 1, table%rows
            if (p%area(i) < 0) then
                call fail(table%where_row(i) // ": column area: " // table%field("area", i) // " is negative")
            end if
            p%now(i) = virgin_point(model, i, p%x(i), p%y(i))
        end do
        p%next = p%now
    end function

    !> Moves the patch to `target` and commits. `iterations`: the Newton corrections that it took.
    subroutine advance(p, target, step, iterations)
        class(patch), intent(inout) :: p
        type(motion), intent(in) :: target
        type(step_info), intent(in) :: step
        integer, intent(out) :: iterations
        type(motion) :: start, goal
        real(real64) :: slip(2), done, end
        integer :: halvings
        logical :: found

        iterations = 0
        if (p%series <= 0) then ! rigid: the slip is prescribed, nothing to solve
            call close_points(p, target, step)
            slip = target%displacement - p%slip
            call p%evaluate(target, step, slip)
            call p%commit(target, slip)
            return
        end if
        start = p%at
        halvings = 0
        done = 0 ! part of the step that is committed
        do while (done < 1)
            end = done + 0.5_real64**halvings
            goal = target
            if (end < 1) goal = between(start, target, end)
            call close_points(p, goal, step)
            call p%solve(goal, step, slip, iterations, found)
            if (found) then
                call p%commit(goal, slip)
                done = end
            else
                halvings = halvings + 1
                if (halvings > max_halvings) call fail(step%place // &
                    ": no equilibrium: Newton does not converge, not even for 1/" // whole(2**max_halvings) // &
                    " of the step")
            end if
        end do
    end subroutine

    !> The touching of points that were open, an increment of its own (see friction_host).
    subroutine close_points(p, target, step)
        type(patch), intent(inout) :: p
        type(motion), intent(in) :: target
        type(step_info), intent(in) :: step
        integer :: i
        do i = 1, size(p%now)
            call touch(p%model, step, target%pressure_scale * p%reference_pressure(i), p%now(i))
        end do
    end subroutine

    !> Tries the common slip increment `slip` on the way from the last accepted step to `target`, and sums up.
    subroutine evaluate(p, target, step, slip)
        class(patch), intent(inout) :: p
        type(motion), intent(in) :: target
        type(step_info), intent(in) :: step
        real(real64), intent(in) :: slip(2)
        real(real64) :: turn, increment(2), tangent(2, 2), stored, dissipated
        integer :: i

        turn = target%rotation - p%at%rotation
        p%force = 0
        p%stiffness = 0
        p%moment = 0
        p%stored = 0
        p%dissipated_in_step = 0
        do i = 1, size(p%now)
            increment = slip + turn * [-p%y(i), p%x(i)]
            call respond(p%model, step, p%now(i), increment, target%pressure_scale * p%reference_pressure(i), p%next(i), &
                tangent, stored, dissipated)
            p%force = p%force + p%area(i) * p%next(i)%tau
            p%stiffness = p%stiffness + p%area(i) * tangent
            p%moment = p%moment + p%area(i) * (p%x(i) * p%next(i)%tau(2) - p%y(i) * p%next(i)%tau(1))
            p%stored = p%stored + p%area(i) * stored
            p%dissipated_in_step = p%dissipated_in_step + p%area(i) * dissipated
        end do
    end subroutine

    !> Keeps the step that was evaluated last.
    subroutine commit(p, target, slip)
        class(patch), intent(inout) :: p
        type(motion), intent(in) :: target
        real(real64), intent(in) :: slip(2)
        p%now = p%next
        p%at = target
        p%slip = p%slip + slip
        p%dissipated = p%dissipated + p%dissipated_in_step
    end subroutine

    !> Residual of the step that was evaluated last.
    function residual(p, target, slip) result(r)
        class(patch), intent(in) :: p
        type(motion), intent(in) :: target
        real(real64), intent(in) :: slip(2)
        real(real64) :: r(2)
        r = p%series * (p%slip + slip - target%displacement) + p%force
    end function

    !> The forces that the residual is measured against.
    real(real64) function force_scale(p, target)
        class(patch), intent(in) :: p
        type(motion), intent(in) :: target
        real(real64) :: friction
        friction = sum(p%model%props(1) * p%area * max(target%pressure_scale * p%reference_pressure, 0.0_real64))
        force_scale = friction + p%series * max(length(p%slip), length(target%displacement))
    end function

    !> The Newton correction -J^-1 r with J = K I + d force / d slip.
    function correction(p, r) result(direction)
        class(patch), intent(in) :: p
        real(real64), intent(in) :: r(2)
        real(real64) :: direction(2), a, b, c, d

        a = p%series + p%stiffness(1, 1)
        direction = [-r(1) / a, 0.0_real64]
        if (p%model%ndir == 1) return
        b = p%stiffness(1, 2)
        c = p%stiffness(2, 1)
        d = p%series + p%stiffness(2, 2)
        direction = -[d * r(1) - b * r(2), a * r(2) - c * r(1)] / (a * d - b * c)
    end function

    !> Goes from `slip` along `direction` until the residual is smaller than it is, halving the way.
    subroutine line_search(p, target, step, direction, slip, r, found)
        class(patch), intent(inout) :: p
        type(motion), intent(in) :: target
        type(step_info), intent(in) :: step
        real(real64), intent(in) :: direction(2)
        real(real64), intent(inout) :: slip(2), r(2)
        logical, intent(out) :: found
        real(real64) :: way, trial(2), r_trial(2)
        integer :: i

        way = 1
        do i = 1, max_backtracks
            trial = slip + way * direction
            call p%evaluate(target, step, trial)
            r_trial = p%residual(target, trial)
            found = length(r_trial) < length(r)
            if (found) then
                slip = trial
                r = r_trial
                return
            end if
            way = 0.5_real64 * way
        end do
    end subroutine

    !> Finds the common slip increment of a step and leaves it evaluated, not committed; `found` is false if Newton does not
    !> get there.
    subroutine solve(p, target, step, slip, iterations, found)
        class(patch), intent(inout) :: p
        type(motion), intent(in) :: target
        type(step_info), intent(in) :: step
        real(real64), intent(out) :: slip(2)
        integer, intent(inout) :: iterations
        logical, intent(out) :: found
        real(real64) :: r(2), best(2), limit
        integer :: i

        slip = 0
        call p%evaluate(target, step, slip)
        r = p%residual(target, slip)
        limit = tolerance * p%force_scale(target)
        found = .false.
        if (.not. ieee_is_finite(length(r))) return ! overflow
        found = length(r) <= limit
        if (found) return ! nothing moves: rounding must not count as a slip
        do i = 1, max_iterations
            found = length(r) <= limit
            if (found) exit
            call p%line_search(target, step, p%correction(r), slip, r, found)
            if (.not. found) return
            iterations = iterations + 1
        end do
        found = length(r) <= limit
        if (.not. found) return
        ! One more correction takes the last digits; it is kept unless it only adds rounding.
        best = slip
        slip = slip + p%correction(r)
        call p%evaluate(target, step, slip)
        if (length(p%residual(target, slip)) > length(r)) then
            slip = best
            call p%evaluate(target, step, slip)
        end if
    end subroutine

    pure real(real64) function length(vector)
        real(real64), intent(in) :: vector(2)
        length = hypot(vector(1), vector(2))
    end function

    !> The point at `part` of the way from one motion to another.
    function between(from, to, part) result(m)
        type(motion), intent(in) :: from, to
        real(real64), intent(in) :: part
        type(motion) :: m
        m%displacement = from%displacement + part * (to%displacement - from%displacement)
        m%rotation = from%rotation + part * (to%rotation - from%rotation)
        m%pressure_scale = from%pressure_scale + part * (to%pressure_scale - from%pressure_scale)
    end function

    !> Number of points per contact status.
    function counts(p) result(count)
        class(patch), intent(in) :: p
        integer :: count(mepc_contact_open:mepc_contact_gross_slip)
        integer :: i, status
        count = 0
        do i = 1, size(p%now)
            status = contact_status(p%now(i))
            count(status) = count(status) + 1
        end do
    end function
end module
