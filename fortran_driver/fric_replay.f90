!> fric_replay: replays a load history through the Abaqus-shaped routine `fric`, in the role of the FE program. See --help.
program fric_replay
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
    use, intrinsic :: iso_fortran_env, only: int32, real64
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use, intrinsic :: ieee_exceptions, only: ieee_set_halting_mode, ieee_usual
    use command_line, only: options, read_options
    use csv, only: csv_table, csv_read
    use friction_host, only: friction_model, contact_point, step_info, virgin_point, touch, respond, contact_status, &
        critical_slip
    use friction_patch, only: patch, motion, new_patch
    use mepc, only: c_ptr, mepc_law_new, mepc_law_free, mepc_state_size, mepc_last_error
    use replay_text, only: fail, number, whole, text_line
    implicit none

    ! The runtime library does not tell of a full disk; the system does.
    interface
        integer(c_int) function c_creat(path, mode) bind(c, name="creat")
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int), value :: mode
        end function
        integer(c_size_t) function c_write(unit, text, length) bind(c, name="write")
            import :: c_char, c_int, c_size_t
            integer(c_int), value :: unit
            character(kind=c_char), intent(in) :: text(*)
            integer(c_size_t), value :: length
        end function
        integer(c_int) function c_close(unit) bind(c, name="close")
            import :: c_int
            integer(c_int), value :: unit
        end function
    end interface

    type(options) :: given

    ! No trap: numbers that are too large must end in a message, but the routine raises exceptions when it refuses them, and
    ! so do sums of them here. Whether a call that is not refused raises any, friction_host sees to.
    call ieee_set_halting_mode(ieee_usual, .false.)
    given = read_options()
    if (allocated(given%patch)) then
        call replay_patch(given)
    else
        call replay_point(given)
    end if
    stop, quiet=.true. ! to return from the program would set the trap again, with what was raised until then

contains

    !> One point under prescribed slip and pressure.
    subroutine replay_point(given)
        type(options), intent(in) :: given
        type(csv_table) :: history
        type(friction_model) :: model
        type(contact_point) :: now, next
        type(step_info) :: step
        real(real64), allocatable :: time(:), slip(:, :), pressure(:), results(:)
        real(real64) :: increment(2), tangent(2, 2), stored, dissipated, total
        type(text_line), allocatable :: table(:)
        integer :: row, n

        history = csv_read(given%history)
        allocate (time, source=history%time())
        n = merge(2, 1, history%has("slip_2"))
        allocate (slip(2, history%rows), source=0.0_real64)
        slip(1, :) = history%column("slip_1")
        if (n == 2) slip(2, :) = history%column("slip_2")
        allocate (pressure, source=history%column("pressure"))
        call history%note_unused()

        model = new_model(given, n)
        now = virgin_point(model, 1, 0.0_real64, 0.0_real64)
        next = now
        total = 0
        allocate (table(0:history%rows))
        table(0)%text = "time" // names("slip", n) // ",pressure" // names("traction", n) // &
            ",stored_energy,dissipated_energy,status"
        do row = 1, history%rows
            step = step_at(history, time, row)
            increment = slip(:, row)
            if (row > 1) increment = increment - slip(:, row - 1)
            call touch(model, step, pressure(row), now)
            call respond(model, step, now, increment, pressure(row), next, tangent, stored, dissipated)
            now = next ! the step is accepted
            total = total + dissipated
            results = [now%tau(:n), stored, total]
            call check_finite(results, step)
            table(row)%text = number(time(row)) // numbers(slip(:n, row)) // numbers([pressure(row)]) // numbers(results) // &
                "," // whole(contact_status(now))
        end do
        call write_output(given, table)
    end subroutine

    !> Points that share a rigid tangential motion, with springs in series and in parallel.
    subroutine replay_patch(given)
        type(options), intent(in) :: given
        type(csv_table) :: history
        type(patch) :: p
        type(step_info) :: step
        type(motion), allocatable :: motions(:)
        real(real64), allocatable :: time(:), results(:)
        type(text_line), allocatable :: table(:)
        character(:), allocatable :: line
        logical :: turns
        integer :: row, n, iterations

        history = csv_read(given%history)
        allocate (time, source=history%time())
        call read_motions(history, motions)
        n = merge(2, 1, history%has("displacement_2"))
        turns = history%has("rotation")

        p = new_patch(given%patch, new_model(given, n), given%series)
        allocate (table(0:history%rows))
        line = "time" // names("displacement", n)
        if (turns) line = line // ",rotation"
        line = line // names("slip", n) // names("force", n)
        if (turns) line = line // ",moment"
        table(0)%text = line // ",stored_energy,dissipated_energy,open,stick,micro_slip,gross_slip,iterations"
        do row = 1, history%rows
            step = step_at(history, time, row)
            call p%advance(motions(row), step, iterations)
            results = [p%slip(:n), p%force(:n) + given%parallel * p%at%displacement(:n)]
            if (turns) results = [results, p%moment]
            results = [results, p%stored, p%dissipated]
            call check_finite(results, step)
            line = number(time(row)) // numbers(p%at%displacement(:n))
            if (turns) line = line // numbers([p%at%rotation])
            table(row)%text = line // numbers(results) // wholes(p%counts()) // "," // whole(iterations)
        end do
        call write_output(given, table)
    end subroutine

    !> What the rows of a patch history prescribe; columns that are missing take their defaults.
    subroutine read_motions(history, motions)
        type(csv_table), intent(inout) :: history
        type(motion), allocatable, intent(out) :: motions(:)

        allocate (motions(history%rows))
        motions%displacement(1) = history%column("displacement_1")
        if (history%has("displacement_2")) motions%displacement(2) = history%column("displacement_2")
        if (history%has("rotation")) then
            if (.not. history%has("displacement_2")) then
                call fail(history%header_place() // &
                    ": column displacement_2: missing in the header, rotation needs two directions")
            end if
            motions%rotation = history%column("rotation")
        end if
        motions%pressure_scale = 1
        if (history%has("pressure_scale")) motions%pressure_scale = history%column("pressure_scale")
        call history%note_unused()
    end subroutine

    !> The model for a number of directions, with the state length that was asked for or that the library recommends. What is
    !> wrong with an option is told here, before the routine blames a line of the history for it.
    function new_model(given, ndir) result(model)
        type(options), intent(in) :: given
        integer, intent(in) :: ndir
        type(friction_model) :: model
        type(c_ptr) :: law
        integer(int32) :: nprops

        nprops = int(size(given%props), int32)
        model%ndir = int(ndir, int32)
        allocate (model%props, source=given%props)
        model%characteristic_length = given%characteristic_length
        model%nstate = mepc_state_size(model%props, nprops, model%ndir)
        if (model%nstate < 0) call fail("--props: " // mepc_last_error())
        if (given%nstate > 0) model%nstate = given%nstate
        ! A subnormal length would lose digits, the library does not take it.
        if (critical_slip(model) < tiny(1.0_real64)) call fail("--props: gcr = 0 needs --char-length")
        ! A law is made for its checks only; it knows no characteristic length, so it gets the critical slip itself.
        if (mepc_law_new([model%props(1), critical_slip(model), model%props(3:)], nprops, model%ndir, model%nstate, law) < 0) then
            call fail("--nstate: " // mepc_last_error())
        end if
        call mepc_law_free(law)
    end function

    function step_at(history, time, row) result(step)
        type(csv_table), intent(in) :: history
        real(real64), intent(in) :: time(:)
        integer, intent(in) :: row
        type(step_info) :: step
        step%increment = int(row, int32)
        step%time = time(row)
        step%dtime = time(row) - time(max(row - 1, 1))
        step%place = history%where_row(row) // ": step " // whole(row)
    end function

    !> Ends the program if a sum or product of the step's finite numbers is none.
    subroutine check_finite(results, step)
        real(real64), intent(in) :: results(:)
        type(step_info), intent(in) :: step
        if (.not. all(ieee_is_finite(results))) call fail(step%place // ": the result is not a finite number")
    end subroutine

    !> ",name_1" or ",name_1,name_2".
    function names(name, n) result(text)
        character(*), intent(in) :: name
        integer, intent(in) :: n
        character(:), allocatable :: text
        text = "," // name // "_1"
        if (n == 2) text = text // "," // name // "_2"
    end function

    !> Each number with a comma before it.
    function numbers(values) result(text)
        real(real64), intent(in) :: values(:)
        character(:), allocatable :: text
        integer :: i
        text = ""
        do i = 1, size(values)
            text = text // "," // number(values(i))
        end do
    end function

    function wholes(values) result(text)
        integer, intent(in) :: values(:)
        character(:), allocatable :: text
        integer :: i
        text = ""
        do i = 1, size(values)
            text = text // "," // whole(values(i))
        end do
    end function

    !> Writes the table, which is complete: a run that fails before leaves no half one behind.
    subroutine write_output(given, table)
        type(options), intent(in) :: given
        type(text_line), intent(in) :: table(:)
        integer(c_int), parameter :: standard_output = 1
        integer(c_int) :: unit
        integer :: i
        logical :: written

        unit = standard_output
        if (allocated(given%output)) then
            unit = create(given%output)
            if (unit < 0) call fail(given%output // ": cannot be written")
        end if
        do i = 1, size(table)
            written = put(unit, table(i)%text)
            if (.not. written) exit
        end do
        if (allocated(given%output)) then
            if (c_close(unit) /= 0) written = .false.
            ! Emptied, so that nobody takes the part for the whole; it may be a device, so not removed.
            if (.not. written) unit = c_close(create(given%output))
        end if
        if (.not. written) call fail(output_name(given) // ": cannot be written, is the disk full?")
    end subroutine

    !> Opens a file for writing, without what it held.
    integer(c_int) function create(file)
        character(*), intent(in) :: file
        integer(c_int), parameter :: for_all = int(o"666", c_int)
        create = c_creat(file // c_null_char, for_all)
    end function

    !> Writes a line; false if the system does not take it.
    logical function put(unit, line)
        integer(c_int), intent(in) :: unit
        character(*), intent(in) :: line
        character(:), allocatable :: rest
        integer(c_size_t) :: written

        put = .true.
        rest = line // new_line("a")
        do while (put .and. len(rest) > 0)
            written = c_write(unit, rest, len(rest, c_size_t))
            put = written > 0
            if (put) rest = rest(written + 1:)
        end do
    end function

    function output_name(given) result(name)
        type(options), intent(in) :: given
        character(:), allocatable :: name
        name = "standard output"
        if (allocated(given%output)) name = given%output
    end function
end program
