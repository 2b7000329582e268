!> Several contact points that go through one history, each on a surface of its own direction, and what the host of the two
!> explicit routines makes of that: slips in space, forces against them.
module explicit_contacts
    use, intrinsic :: iso_fortran_env, only: real64
    implicit none
    private
    public :: contacts

    !> Points of a block.
    integer, parameter, public :: points = 3
    real(real64), parameter, public :: area(points) = [0.5_real64, 2.0_real64, 8.0_real64]

    type :: contacts
        integer :: ndim = 3                    !< directions of space
        real(real64) :: frame(3, 3, points)    !< per point: normal, tangent 1, tangent 2 as columns
        real(real64) :: slip(3, points)        !< increment, in space
        real(real64) :: along(3, points) = 0   !< its direction
    contains
        procedure :: place
        procedure :: move
        procedure :: traction
    end type

contains

    !> Surfaces that look every which way.
    subroutine place(self, ndir)
        class(contacts), intent(inout) :: self
        integer, intent(in) :: ndir
        real(real64) :: normal(3), a(3), b(3)
        integer :: k

        self%ndim = 1 + ndir
        do k = 1, points
            normal = [0.3_real64, -0.5_real64 * k, merge(0.8_real64 - 0.5_real64 * k, 0.0_real64, ndir == 2)]
            normal = normal / norm2(normal)
            a = [-normal(2), normal(1), 0.0_real64] / norm2(normal(:2))
            b = [normal(2) * a(3) - normal(3) * a(2), normal(3) * a(1) - normal(1) * a(3), &
                normal(1) * a(2) - normal(2) * a(1)]
            self%frame(:, :, k) = reshape([normal, a, b], [3, 3])
            self%along(:, k) = a
        end do
    end subroutine

    !> The slip increment of all points, given in their tangents.
    subroutine move(self, increment)
        class(contacts), intent(inout) :: self
        real(real64), intent(in) :: increment(2)
        integer :: k

        do k = 1, points
            self%slip(:, k) = matmul(self%frame(:, 2:3, k), increment)
            if (any(increment /= 0)) self%along(:, k) = self%slip(:, k) / norm2(self%slip(:, k))
        end do
    end subroutine

    !> The traction in the tangents of point `k`, with the sign of the slip, from the force in the host's directions: along
    !> the slip, and normal x that.
    function traction(self, k, force) result(tau)
        class(contacts), intent(in) :: self
        integer, intent(in) :: k
        real(real64), intent(in) :: force(:)
        real(real64) :: tau(2), in_space(3), n(3), s(3)

        n = self%frame(:, 1, k)
        s = self%along(:, k)
        in_space = force(1) * s
        if (size(force) == 2) then
            in_space = in_space + force(2) * [n(2) * s(3) - n(3) * s(2), n(3) * s(1) - n(1) * s(3), n(1) * s(2) - n(2) * s(1)]
        end if
        tau = -matmul(transpose(self%frame(:, 2:3, k)), in_space) / area(k)
    end function
end module
