!> The routines by which a host lets user routines speak and end the run. Link with -rdynamic, so that a library finds them.
subroutine stdb_abqerr(lop, text, iv, rv, cv)
    use, intrinsic :: iso_fortran_env, only: int32, real64, output_unit
    implicit none
    integer(int32), intent(in) :: lop, iv(*)
    character(*), intent(in) :: text
    real(real64), intent(in) :: rv(*)
    character(8), intent(in) :: cv(*)
    if (iv(1) /= 0 .or. rv(1) /= 0 .or. cv(1) /= '') error stop 9
    write (output_unit, '(a, i0, 2a)') 'HOST ', lop, ': ', text
    flush (output_unit)
end subroutine

subroutine xit
    implicit none
    stop 7
end subroutine
