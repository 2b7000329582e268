!> Messages, and numbers to and from text. Every error ends the program: exit code 1 for bad input, 2 for a wrong command
!> line.
module replay_text
    use, intrinsic :: iso_fortran_env, only: error_unit, real64
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    implicit none
    private
    public :: fail, fail_usage, note, read_number, number, whole, trimmed, text_line

    character(*), parameter :: program_name = "fric_replay"

    !> A string of its own length, for arrays of strings.
    type :: text_line
        character(:), allocatable :: text
    end type

contains

    !> Prints "fric_replay: <text>" on standard error and stops with exit code 1.
    subroutine fail(text)
        character(*), intent(in) :: text
        call say(text)
        stop 1, quiet=.true.
    end subroutine

    !> Like fail, for the command line: exit code 2.
    subroutine fail_usage(text)
        character(*), intent(in) :: text
        call say(text)
        call say("try --help")
        stop 2, quiet=.true.
    end subroutine

    !> Prints "fric_replay: note: <text>" on standard error and goes on.
    subroutine note(text)
        character(*), intent(in) :: text
        call say("note: " // text)
    end subroutine

    !> What a file or an argument holds may be part of the text: control characters must not reach the terminal.
    subroutine say(text)
        character(*), intent(in) :: text
        character(:), allocatable :: clean
        character(2) :: digits
        integer :: i, code

        clean = program_name // ": "
        do i = 1, len(text)
            code = iachar(text(i:i))
            if (code < 32 .or. code == 127) then
                write (digits, "(z2.2)") code
                clean = clean // "\x" // digits
            else
                clean = clean // text(i:i)
            end if
        end do
        write (error_unit, "(a)") clean
    end subroutine

    !> Reads a decimal number in C or Fortran notation that fills the whole text. `problem` is empty, or what is wrong.
    subroutine read_number(text, value, problem)
        character(*), intent(in) :: text
        real(real64), intent(out) :: value
        character(:), allocatable, intent(out) :: problem
        integer :: status

        value = 0
        problem = ""
        if (len(text) == 0) then
            problem = "is empty"
        else if (is_special(text)) then
            problem = "is not finite"
        else if (.not. is_decimal(text)) then
            problem = "is not a number"
        else
            read (text, *, iostat=status) value
            if (status /= 0 .or. .not. ieee_is_finite(value)) problem = "is too large"
        end if
    end subroutine

    !> True for [sign] digits [. digits] [exponent]. A Fortran READ alone would also take "1/", "2*3" and "1 2".
    logical function is_decimal(text)
        character(*), intent(in) :: text
        integer :: at, digits, found

        at = 1
        call skip_sign(text, at)
        call skip_digits(text, at, digits)
        if (letter(text, at) == ".") then
            at = at + 1
            call skip_digits(text, at, found)
            digits = digits + found
        end if
        is_decimal = digits > 0
        if (index("eEdD", letter(text, at)) > 0) then
            at = at + 1
            call skip_sign(text, at)
            call skip_digits(text, at, found)
            is_decimal = is_decimal .and. found > 0
        end if
        is_decimal = is_decimal .and. at > len(text)
    end function

    !> The character at a position; "," (which no field contains) past the end.
    character function letter(text, at)
        character(*), intent(in) :: text
        integer, intent(in) :: at
        letter = ","
        if (at <= len(text)) letter = text(at:at)
    end function

    subroutine skip_sign(text, at)
        character(*), intent(in) :: text
        integer, intent(inout) :: at
        if (index("+-", letter(text, at)) > 0) at = at + 1
    end subroutine

    subroutine skip_digits(text, at, count)
        character(*), intent(in) :: text
        integer, intent(inout) :: at
        integer, intent(out) :: count
        count = 0
        do while (index("0123456789", letter(text, at)) > 0)
            at = at + 1
            count = count + 1
        end do
    end subroutine

    !> True for what other programs write in place of a number: nan, inf, infinity, in any case and sign.
    logical function is_special(text)
        character(*), intent(in) :: text
        character(len(text)) :: lower
        integer :: i, start, code

        lower = text
        do i = 1, len(text)
            code = iachar(text(i:i))
            if (code >= iachar("A") .and. code <= iachar("Z")) lower(i:i) = achar(code + 32)
        end do
        start = 1
        call skip_sign(lower, start)
        is_special = lower(start:) == "nan" .or. lower(start:) == "inf" .or. lower(start:) == "infinity"
    end function

    !> A number with 17 significant digits, which a reader gets back exactly.
    function number(value) result(text)
        real(real64), intent(in) :: value
        character(:), allocatable :: text
        character(24) :: buffer
        write (buffer, "(es24.16e3)") value
        text = trimmed(buffer)
    end function

    !> A whole number as text.
    function whole(value) result(text)
        integer, intent(in) :: value
        character(:), allocatable :: text
        character(12) :: buffer
        write (buffer, "(i0)") value
        text = trim(buffer)
    end function

    !> The text without the blanks, tabs and carriage returns at both ends.
    function trimmed(text) result(inner)
        character(*), intent(in) :: text
        character(:), allocatable :: inner
        character(*), parameter :: blank = " " // achar(9) // achar(11) // achar(12) // achar(13)
        integer :: first, last

        first = verify(text, blank)
        last = verify(text, blank, back=.true.)
        inner = ""
        if (first > 0) inner = text(first:last)
    end function
end module
