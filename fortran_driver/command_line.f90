!> The command line.
module command_line
    use, intrinsic :: iso_fortran_env, only: output_unit, int32, real64
    use replay_text, only: fail, fail_usage, read_number, whole, text_line
    implicit none
    private
    public :: options, read_options

    integer, parameter :: max_props = 64
    character(13), parameter :: known(6) = [character(13) :: &
        "--props", "--nstate", "--char-length", "--series", "--parallel", "--output"]

    type :: options
        character(:), allocatable :: patch      !< patch file, not allocated for a single point
        character(:), allocatable :: history    !< history file
        character(:), allocatable :: output     !< output file, not allocated for standard output
        real(real64), allocatable :: props(:)
        integer(int32) :: nstate = 0            !< 0: the library's default
        real(real64) :: series = 0              !< stiffness of the series spring, 0: rigid
        real(real64) :: parallel = 0            !< stiffness of the parallel spring, 0: none
        real(real64) :: characteristic_length = 0
    end type

contains

    subroutine print_help()
        write (output_unit, "(a)") &
            "Replays a load history through the Abaqus-shaped friction routine fric, in the role of the FE program.", &
            "", &
            "  fric_replay point HISTORY.csv --props mu,gcr,... [options]", &
            "  fric_replay patch PATCH.csv HISTORY.csv --props mu,gcr,... [options]", &
            "", &
            "point  one contact point under prescribed slip and pressure.", &
            "         HISTORY  time,slip_1[,slip_2],pressure", &
            "         output   time,slip_1[,slip_2],pressure,traction_1[,traction_2],", &
            "                  stored_energy,dissipated_energy,status", &
            "patch  contact points that share one rigid tangential motion.", &
            "         PATCH    x,y,area,pressure", &
            "         HISTORY  time,displacement_1[,displacement_2][,rotation][,pressure_scale]", &
            "         output   time,displacement_1[,displacement_2][,rotation],slip_1[,slip_2],", &
            "                  force_1[,force_2][,moment],stored_energy,dissipated_energy,", &
            "                  open,stick,micro_slip,gross_slip,iterations", &
            "", &
            "Each row holds the values at the end of a step; the first row is a step too, from zero slip and zero pressure.", &
            "Pressure is positive in compression; zero or less is an open contact. dissipated_energy counts from the start.", &
            "status: 0 open, 1 stick, 2 micro-slip, 3 gross slip. rotation (radian, about the origin) needs two directions.", &
            "Any consistent units. Columns are found by name, those that are not used are noted; lines starting with # are " // &
            "skipped.", &
            "", &
            "  --props LIST      properties in their order: mu,gcr,chi,method,pressure_rule,... (required)", &
            "  --nstate N        length of the state array (default: what the library recommends)", &
            "  --char-length L   characteristic length of the contact face, for gcr = 0 (default: 0)", &
            "  --series K        patch: spring in series, K (u - g) = contact force (default: rigid)", &
            "  --parallel K      patch: spring in parallel, adds K u to the force (default: none)", &
            "  --output FILE     write the table there (default: standard output)", &
            "  --help            this text", &
            "", &
            "Exit code: 0 done, 1 bad input, 2 wrong command line."
    end subroutine

    !> Argument number i; empty past the last.
    function argument(i) result(text)
        integer, intent(in) :: i
        character(:), allocatable :: text
        integer :: length
        call get_command_argument(i, length=length)
        allocate (character(len=length) :: text)
        call get_command_argument(i, text)
    end function

    function read_options() result(given)
        type(options) :: given
        type(text_line) :: words(3) ! mode and files
        character(:), allocatable :: word
        logical :: seen(size(known))
        integer :: i, count

        seen = .false.
        count = 0
        i = 0
        do while (i < command_argument_count())
            i = i + 1
            word = argument(i)
            if (word == "--help") then
                call print_help()
                stop
            else if (index(word, "--") == 1) then
                i = i + 1
                call check_option(word, argument(i), seen)
                call read_option(given, word, argument(i))
            else if (count < 3) then
                count = count + 1
                words(count)%text = word
            else
                call fail_usage("unexpected argument " // word)
            end if
        end do
        if (count == 0) call fail_usage("the mode is missing: point or patch")
        select case (words(1)%text)
        case ("point")
            if (count /= 2) call fail_usage("mode point takes HISTORY.csv")
            if (given%series > 0 .or. given%parallel > 0) then
                call fail_usage("--series and --parallel belong to mode patch")
            end if
        case ("patch")
            if (count /= 3) call fail_usage("mode patch takes PATCH.csv HISTORY.csv")
            given%patch = words(2)%text
        case default
            call fail_usage("unknown mode " // words(1)%text // ": point or patch")
        end select
        given%history = words(count)%text
        if (.not. allocated(given%props)) call fail_usage("--props is missing")
        if (.not. allocated(given%output)) return
        do i = 2, count
            call check_output(given%output, words(i)%text)
        end do
    end function

    !> Ends the program if the output is this input. The runtime library knows an open file by whatever name or link.
    subroutine check_output(output, input)
        character(*), intent(in) :: output, input
        integer :: unit, status
        logical :: is_input

        open (newunit=unit, file=input, action="read", status="old", iostat=status)
        if (status /= 0) return ! what is wrong with it is told where it is read
        inquire (file=output, opened=is_input)
        close (unit)
        if (is_input) then
            call fail("--output: " // output // " is the input file " // input // ", which it would overwrite")
        end if
    end subroutine

    subroutine check_option(name, value, seen)
        character(*), intent(in) :: name, value
        logical, intent(inout) :: seen(:)
        if (.not. any(known == name)) call fail_usage("unknown option " // name)
        if (any(seen .and. known == name)) call fail_usage(name // ": given twice")
        seen = seen .or. known == name
        ! The next option is no value.
        if (len(value) == 0 .or. index(value, "--") == 1) call fail_usage(name // ": its value is missing")
    end subroutine

    subroutine read_option(given, name, text)
        type(options), intent(inout) :: given
        character(*), intent(in) :: name, text
        select case (name)
        case ("--props")
            given%props = read_props(text)
        case ("--nstate")
            given%nstate = read_count(name, text)
        case ("--char-length")
            given%characteristic_length = read_positive(name, text)
        case ("--series")
            given%series = read_positive(name, text)
        case ("--parallel")
            given%parallel = read_positive(name, text)
        case ("--output")
            given%output = text
        end select
    end subroutine

    real(real64) function read_positive(name, text)
        character(*), intent(in) :: name, text
        character(:), allocatable :: problem
        call read_number(text, read_positive, problem)
        if (problem /= "") call fail_usage(name // ": '" // text // "' " // problem)
        if (read_positive <= 0) call fail_usage(name // ": must be positive, not " // text)
    end function

    integer(int32) function read_count(name, text)
        character(*), intent(in) :: name, text
        integer :: status
        status = 1
        read_count = 0
        if (verify(text, "0123456789") == 0 .and. len(text) > 0 .and. len(text) < 8) then
            read (text, *, iostat=status) read_count
        end if
        if (status /= 0 .or. read_count < 1 .or. read_count > 1000000) then
            call fail_usage(name // ": '" // text // "' is not a whole number from 1 to 1000000")
        end if
    end function

    function read_props(list) result(props)
        character(*), intent(in) :: list
        real(real64), allocatable :: props(:)
        character(:), allocatable :: entry, problem
        real(real64) :: value
        integer :: start, comma

        allocate (props(0))
        start = 1
        do
            comma = index(list(start:), ",")
            if (comma == 0) comma = len(list) - start + 2
            if (size(props) == max_props) call fail_usage("--props: more than " // whole(max_props) // " entries")
            entry = trim(adjustl(list(start:start + comma - 2)))
            call read_number(entry, value, problem)
            if (problem /= "") then
                call fail_usage("--props: entry " // whole(size(props) + 1) // ": '" // entry // "' " // problem)
            end if
            props = [props, value]
            start = start + comma
            if (start > len(list) + 1) exit
        end do
    end function
end module
