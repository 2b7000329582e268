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
        !> The host counts the slip in the directions of the contact, of which the first is along it: which of the two it does is
        !> not confirmed (docs/hosts.md).
        logical :: in_contact_directions = .false.
    contains
        procedure :: place
        procedure :: move
        procedure :: host_slip
        procedure :: host_direction
        procedure :: traction
    end type

contains

    !> Surfaces that look every which way. The program's argument says how the host counts the slip: global or contact.
    subroutine place(self, ndir)
        class(contacts), intent(inout) :: self
        integer, intent(in) :: ndir
        real(real64) :: normal(3), a(3), b(3)
        integer :: k
        character(8) :: directions

        call get_command_argument(1, directions)
        self%in_contact_directions = directions == 'contact'
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

    !> The slip increment as the host counts it.
    function host_slip(self) result(slip)
        class(contacts), intent(in) :: self
        real(real64) :: slip(self%ndim, points)

        slip = self%slip(:self%ndim, :)
        if (self%in_contact_directions) then
            slip(1, :) = norm2(slip, 1)
            slip(2:, :) = 0
        end if
    end function

    !> Unit vectors as a host hands them over that does not compute them to the last digit.
    function host_direction(self, unit) result(direction)
        class(contacts), intent(in) :: self
        real(real64), intent(in) :: unit(3, points)
        real(real64) :: direction(self%ndim, points)

        direction = (1 + 4e-4_real64) * unit(:self%ndim, :)
    end function

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
