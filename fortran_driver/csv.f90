!> Tables from comma-separated files: columns found by name, every complaint with file, line and column.
!>
!> Lines that are blank or start with '#' are skipped, the first other line is the header. Columns that nobody asks for
!> may hold anything; note_unused tells of them.
module csv
    use, intrinsic :: iso_fortran_env, only: iostat_end, iostat_eor, real64
    use replay_text, only: fail, note, read_number, whole, trimmed, text_line
    implicit none
    private
    public :: csv_table, csv_read

    type :: csv_table
        character(:), allocatable :: file              !< as given, for messages
        integer :: rows = 0
        integer, allocatable :: lines(:)               !< line of the file that each row stands on, from 1
        integer, private :: header_line = 0
        type(text_line), allocatable, private :: names(:)
        logical, allocatable, private :: used(:)       !< per column: has it been asked for?
        type(text_line), allocatable, private :: content(:) !< the rows as they stand in the file
    contains
        procedure :: has                               !< is there a column of this name?
        procedure :: column                            !< the numbers of a column
        procedure :: time                              !< the column `time`, which must not decrease
        procedure :: field                             !< a field as it stands in the file
        procedure :: where_row                         !< "file:line" of a row
        procedure :: note_unused                       !< tells of columns that were not asked for
        procedure :: header_place                      !< "file:line" of the header
        procedure, private :: find, list_names
    end type

contains

    !> Reads a file; ends the program when there is no such file, no header, no row, or a row of the wrong length.
    function csv_read(file) result(table)
        character(*), intent(in) :: file
        type(csv_table) :: table
        type(text_line), allocatable :: lines(:)
        integer :: i, count

        table%file = file
        call read_lines(file, lines, count)
        allocate (table%content(count), table%lines(count))
        do i = 1, count
            if (lines(i)%text == "") cycle
            if (lines(i)%text(1:1) == "#") cycle
            if (table%header_line == 0) then
                table%header_line = i
                call check_separators(table, lines(i)%text)
                call split(lines(i)%text, table%names)
                call check_names(table)
                allocate (table%used(size(table%names)), source=.false.)
            else
                table%rows = table%rows + 1
                table%lines(table%rows) = i
                table%content(table%rows) = lines(i)
                call check_length(table, table%rows)
            end if
        end do
        if (table%header_line == 0) call fail(file // ":" // whole(max(count, 1)) // ": is empty: no header line")
        if (table%rows == 0) call fail(table%header_place() // ": has a header but no row below it")
    end function

    !> The lines of a text file without the blanks at their ends; only the first `count` are filled.
    subroutine read_lines(file, lines, count)
        character(*), intent(in) :: file
        type(text_line), allocatable, intent(out) :: lines(:)
        integer, intent(out) :: count
        type(text_line), allocatable :: longer(:)
        character(*), parameter :: byte_order_mark = char(239) // char(187) // char(191) ! of some spreadsheets
        character(256) :: message
        character(:), allocatable :: line
        integer :: unit, status
        logical :: there

        inquire (file=file, exist=there)
        if (.not. there) call fail(file // ": No such file or directory")
        inquire (file=file // "/.", exist=there) ! the runtime library would read a directory as an empty file
        if (there) call fail(file // ": Is a directory")
        open (newunit=unit, file=file, action="read", status="old", iostat=status, iomsg=message)
        if (status /= 0) call fail(file // ": " // trim(message))
        allocate (lines(64))
        count = 0
        do
            call read_line(unit, line, status, message)
            if (status == iostat_end) exit
            if (status /= 0) call fail(file // ": " // trim(message))
            if (index(line, achar(0)) > 0) call fail(file // ": is not a text file")
            if (count == 0 .and. index(line, byte_order_mark) == 1) line = line(4:)
            if (count == size(lines)) then
                allocate (longer(2 * count))
                longer(:count) = lines
                call move_alloc(longer, lines)
            end if
            count = count + 1
            lines(count)%text = trimmed(line)
        end do
        close (unit)
    end subroutine

    !> Reads one line of any length.
    subroutine read_line(unit, line, status, message)
        integer, intent(in) :: unit
        character(:), allocatable, intent(out) :: line
        integer, intent(out) :: status
        character(*), intent(inout) :: message
        character(256) :: buffer
        integer :: length

        line = ""
        do
            read (unit, "(a)", advance="no", size=length, iostat=status, iomsg=message) buffer
            if (status == 0 .or. status == iostat_eor) line = line // buffer(:length)
            if (status /= 0) exit
        end do
        if (status == iostat_eor) status = 0
        ! A last line without a line feed ends with the file.
        if (status == iostat_end .and. len(line) > 0) status = 0
    end subroutine

    !> The fields of a line, without the blanks around them.
    subroutine split(line, fields)
        character(*), intent(in) :: line
        type(text_line), allocatable, intent(out) :: fields(:)
        integer :: i, start, comma

        allocate (fields(count_fields(line)))
        start = 1
        do i = 1, size(fields)
            comma = index(line(start:), ",")
            if (comma == 0) comma = len(line) - start + 2
            fields(i)%text = trimmed(line(start:start + comma - 2))
            start = start + comma
        end do
    end subroutine

    integer function count_fields(line)
        character(*), intent(in) :: line
        integer :: i
        count_fields = 1
        do i = 1, len(line)
            if (line(i:i) == ",") count_fields = count_fields + 1
        end do
    end function

    subroutine check_separators(table, header)
        type(csv_table), intent(in) :: table
        character(*), intent(in) :: header
        integer :: at

        at = scan(header, ";" // achar(9))
        if (at == 0 .or. index(header, ",") > 0) return
        call fail(table%header_place() // ": the fields must be separated by commas, not by " // &
            trim(merge("semicolons", "tabs      ", header(at:at) == ";")))
    end subroutine

    subroutine check_names(table)
        type(csv_table), intent(in) :: table
        integer :: i, k
        do i = 2, size(table%names)
            do k = 1, i - 1
                if (table%names(i)%text /= "" .and. table%names(i)%text == table%names(k)%text) then
                    call fail(table%header_place() // ": column " // table%names(i)%text // &
                        ": appears twice in the header")
                end if
            end do
        end do
    end subroutine

    subroutine check_length(table, row)
        type(csv_table), intent(in) :: table
        integer, intent(in) :: row
        integer :: found, columns
        character(:), allocatable :: lengths

        found = count_fields(table%content(row)%text)
        columns = size(table%names)
        lengths = "the line has " // whole(found) // " fields and the header " // whole(columns)
        if (found < columns) then
            call fail(table%where_row(row) // ": column " // table%names(found + 1)%text // ": missing, " // lengths)
        else if (found > columns) then
            call fail(table%where_row(row) // ": column " // whole(columns + 1) // ": has no name, " // lengths)
        end if
    end subroutine

    function where_row(table, row) result(text)
        class(csv_table), intent(in) :: table
        integer, intent(in) :: row
        character(:), allocatable :: text
        text = table%file // ":" // whole(table%lines(row))
    end function

    !> Number of a column, 0 if there is none of this name.
    integer function find(table, name)
        class(csv_table), intent(in) :: table
        character(*), intent(in) :: name
        do find = size(table%names), 1, -1
            if (table%names(find)%text == name) return
        end do
    end function

    logical function has(table, name)
        class(csv_table), intent(in) :: table
        character(*), intent(in) :: name
        has = table%find(name) > 0
    end function

    function header_place(table) result(text)
        class(csv_table), intent(in) :: table
        character(:), allocatable :: text
        text = table%file // ":" // whole(table%header_line)
    end function

    function field(table, name, row) result(text)
        class(csv_table), intent(in) :: table
        character(*), intent(in) :: name
        integer, intent(in) :: row
        character(:), allocatable :: text
        type(text_line), allocatable :: fields(:)
        call split(table%content(row)%text, fields)
        text = fields(table%find(name))%text
    end function

    !> The numbers of a column; ends the program if it is missing or if a field is not a finite number.
    function column(table, name) result(values)
        class(csv_table), intent(inout) :: table
        character(*), intent(in) :: name
        real(real64) :: values(table%rows)
        character(:), allocatable :: problem
        integer :: row

        if (.not. table%has(name)) then
            call fail(table%header_place() // ": column " // name // ": missing in the header, which has " // &
                table%list_names(all=.true.))
        end if
        table%used(table%find(name)) = .true.
        do row = 1, table%rows
            call read_number(table%field(name, row), values(row), problem)
            if (problem /= "") then
                call fail(table%where_row(row) // ": column " // name // ": '" // table%field(name, row) // "' " // problem)
            end if
        end do
    end function

    !> A note on standard error about columns that were not asked for: one of them may be an optional column mistyped. Files
    !> with more columns than a replay needs are common (records of a rig, the output of another replay), so it is no error.
    subroutine note_unused(table)
        class(csv_table), intent(in) :: table
        character(:), allocatable :: list

        list = table%list_names(all=.false.)
        if (list /= "") call note(table%header_place() // ": columns not used: " // list)
    end subroutine

    !> The names of all columns, or of those that were not asked for.
    function list_names(table, all) result(list)
        class(csv_table), intent(in) :: table
        logical, intent(in) :: all
        character(:), allocatable :: list
        integer :: i

        list = ""
        do i = 1, size(table%names)
            if (table%used(i) .and. .not. all) cycle
            if (list /= "") list = list // ", "
            if (table%names(i)%text == "") then
                list = list // whole(i) // " (no name)"
            else
                list = list // table%names(i)%text
            end if
        end do
    end function

    function time(table) result(values)
        class(csv_table), intent(inout) :: table
        real(real64) :: values(table%rows)
        integer :: row

        values = table%column("time")
        do row = 2, table%rows
            if (values(row) < values(row - 1)) then
                call fail(table%where_row(row) // ": column time: " // table%field("time", row) // " comes after " // &
                    table%field("time", row - 1) // ", time must not decrease")
            end if
        end do
    end function
end module
