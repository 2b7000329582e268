!> Tables of numbers from and to text; an error names file, line and column and ends the program.
module text_table
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
    use, intrinsic :: iso_fortran_env, only: error_unit, real64
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    implicit none
    private
    public :: table, read_table, print_table, read_number, fail, whole

    type :: table
        character(:), allocatable :: file, header
        real(real64), allocatable :: values(:, :) !< (column, row)
        integer, allocatable :: lines(:)          !< line of the file of each row, from 1
    contains
        procedure :: place                        !< "file:line: " of a row
    end type

    ! The runtime library does not tell of a full disk; the system does.
    interface
        integer(c_size_t) function c_write(file, text, length) bind(c, name="write")
            import :: c_char, c_int, c_size_t
            integer(c_int), value :: file
            character(kind=c_char), intent(in) :: text(*)
            integer(c_size_t), value :: length
        end function
    end interface

contains

    !> Prints "fric_replay: <text>" on standard error and stops: exit code 1, or 2 for a wrong command line.
    subroutine fail(text, code)
        character(*), intent(in) :: text
        integer, intent(in), optional :: code
        write (error_unit, "(a)") "fric_replay: " // text
        if (present(code)) stop 2, quiet=.true.
        stop 1, quiet=.true.
    end subroutine

    !> A whole number as text.
    function whole(value) result(text)
        integer, intent(in) :: value
        character(:), allocatable :: text
        character(12) :: buffer
        write (buffer, "(i0)") value
        text = trim(buffer)
    end function

    function place(t, row) result(text)
        class(table), intent(in) :: t
        integer, intent(in) :: row
        character(:), allocatable :: text
        text = t%file // ":" // whole(t%lines(row)) // ": "
    end function

    !> Reads a decimal number that fills the text; false if it is none, or not finite. A READ alone would also take
    !> "1-5", "1/", "2*3", "inf" and "1 2".
    logical function read_number(text, value)
        character(*), intent(in) :: text
        real(real64), intent(out) :: value
        integer :: i, status

        value = 0
        read_number = verify(text, "0123456789+-.eE") == 0 .and. scan(text, "0123456789") > 0 .and. scan(text, "eE") /= 1
        do i = 2, len(text)
            if (scan(text(i:i), "+-") > 0 .and. scan(text(i - 1:i - 1), "eE") == 0) read_number = .false.
        end do
        if (.not. read_number) return
        read (text, *, iostat=status) value
        read_number = status == 0 .and. ieee_is_finite(value)
    end function

    !> Reads comma-separated values under one of the accepted headers; blank lines and those with a '#' are skipped.
    function read_table(file, headers) result(t)
        character(*), intent(in) :: file, headers(:)
        type(table) :: t
        character(:), allocatable :: text, line
        character(256) :: message
        integer :: unit, status, bytes, start, length, number, rows, i

        inquire (file=file, size=bytes)
        open (newunit=unit, file=file, access="stream", form="unformatted", action="read", status="old", iostat=status, &
            iomsg=message)
        if (status == 0) then
            allocate (character(max(bytes, 0)) :: text)
            read (unit, iostat=status, iomsg=message) text
        end if
        if (status /= 0) call fail(file // ": " // trim(message))
        close (unit)
        t%file = file
        allocate (t%lines(1 + count([(text(i:i) == new_line("a"), i=1, len(text))])))
        number = 0
        rows = 0
        start = 1
        do while (start <= len(text))
            length = index(text(start:), new_line("a")) - 1
            if (length < 0) length = len(text) - start + 1
            line = text(start:start + length - 1)
            start = start + length + 1
            number = number + 1
            if (len(line) > 0) line = line(:len(line) - merge(1, 0, line(len(line):) == achar(13)))
            if (len(line) == 0 .or. index(line, "#") == 1) cycle
            if (allocated(t%header)) then
                rows = rows + 1
                t%lines(rows) = number
                call read_row(t, line, rows)
            else if (any(headers == line)) then
                t%header = line
                allocate (t%values(1 + count([(line(i:i) == ",", i=1, len(line))]), size(t%lines)))
            else
                line = file // ":" // whole(number) // ": the header is '" // line // "', must be " // trim(headers(1))
                do i = 2, size(headers)
                    line = line // " or " // trim(headers(i))
                end do
                call fail(line)
            end if
        end do
        if (rows == 0) call fail(file // ":" // whole(number) // ": the file ends without a row of numbers")
        t%values = t%values(:, :rows)
    end function

    subroutine read_row(t, line, row)
        type(table), intent(inout) :: t
        character(*), intent(in) :: line
        integer, intent(in) :: row
        character(:), allocatable :: column
        integer :: i, at, comma, name, length

        at = 1
        name = 1
        do i = 1, size(t%values, 1)
            length = index(t%header(name:) // ",", ",") - 1
            column = t%place(row) // "column " // t%header(name:name + length - 1) // ": "
            comma = index(line(at:), ",")
            if (comma == 0 .neqv. i == size(t%values, 1)) then
                call fail(column // "too " // trim(merge("few ", "many", comma == 0)) // " fields in this row")
            end if
            if (comma == 0) comma = len(line) - at + 2
            if (.not. read_number(line(at:at + comma - 2), t%values(i, row))) then
                call fail(column // "'" // line(at:at + comma - 2) // "' is not a finite number")
            end if
            at = at + comma
            name = name + length + 1
        end do
    end subroutine

    !> Prints the columns of the input and those of the results, all digits. They are complete: no half tables.
    subroutine print_table(input, header, results)
        type(table), intent(in) :: input
        character(*), intent(in) :: header
        real(real64), intent(in) :: results(:, :)
        character(32 * (size(input%values, 1) + size(results, 1))) :: line
        integer :: row

        do row = 1, size(results, 2)
            if (.not. all(ieee_is_finite(results(:, row)))) call fail(input%place(row) // "the result is not a finite number")
        end do
        call write_line(input%header // "," // header)
        do row = 1, size(results, 2)
            write (line, "(*(g0, :, ','))") input%values(:, row), results(:, row)
            call write_line(trim(line))
        end do
    end subroutine

    subroutine write_line(line)
        character(*), intent(in) :: line
        integer(c_int), parameter :: standard_output = 1
        if (c_write(standard_output, line // new_line("a"), len(line, c_size_t) + 1) <= len(line)) then
            call fail("standard output: cannot be written")
        end if
    end subroutine
end module
