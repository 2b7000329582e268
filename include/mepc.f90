!> Memory-effect penalty contact law: the C interface of the library (mepc.h) for Fortran, and an explicit interface for
!> the Abaqus-shaped routine `fric`, so that the compiler checks the arguments of both.
!>
!> Any consistent set of units. Traction and pressure are force per area, pressure is positive in compression, traction has
!> the sign of the slip, energies are per area. `ndir` is the number of tangential directions, 1 or 2.
!>
!> Functions that can fail return a status: 0 success, < 0 an error (its words: `mepc_last_error`), nothing is written then;
!> > 0 success with a remark. Arguments marked optional may be left out.
!> The routines keep nothing between calls: the state at the start of the increment goes in, the state at its end comes out
!> in another array (C allows the same one, Fortran does not), so that an increment can be repeated or rejected. A law may be
!> used by several threads at once.
!>
!> `fric` is a host's routine: it tells what is wrong through the host or on standard error, not in `mepc_last_error`.
!>
!> Fortran 2018 (optional arguments of C functions).
!>
!> C stores matrices by rows, so in Fortran order the first index is the one that varies in the denominator: see each
!> procedure.
module mepc
    use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_associated, c_char, c_double, c_int8_t, c_int32_t, &
        c_int64_t, c_size_t, c_f_pointer
    use, intrinsic :: iso_fortran_env, only: int32, real64
    implicit none
    private

    public :: mepc_abi_version, mepc_version, mepc_status_message, mepc_last_error
    public :: mepc_law_new, mepc_law_free, mepc_state_size, mepc_state_name
    public :: mepc_friction, mepc_interface, mepc_friction_batch, mepc_interface_batch
    public :: mepc_friction_history, mepc_friction_history_batch
    public :: mepc_iwan_force, mepc_iwan_identify
    public :: fric
    ! What a caller needs to hold a law, or to pass no law.
    public :: c_ptr, c_null_ptr

    !> Version of the interface that is described here; a program compares it with what mepc_abi_version() gives. (In C it
    !> is MEPC_ABI_VERSION, a name that Fortran cannot tell from the function's.)
    integer(c_int32_t), parameter, public :: mepc_abi = 2

    !> Statuses.
    integer(c_int32_t), parameter, public :: mepc_ok = 0
    integer(c_int32_t), parameter, public :: mepc_memory_full = 1        !< a remembered knot that mattered had to be dropped
    integer(c_int32_t), parameter, public :: mepc_not_described = 2      !< mepc_iwan_identify: the model does not describe the loop
    integer(c_int32_t), parameter, public :: mepc_null_pointer = -1
    integer(c_int32_t), parameter, public :: mepc_bad_property = -2
    integer(c_int32_t), parameter, public :: mepc_bad_state = -3         !< too short or damaged
    integer(c_int32_t), parameter, public :: mepc_bad_input = -4         !< not finite, or a wrong size
    integer(c_int32_t), parameter, public :: mepc_internal = -5          !< a defect of the library

    !> Values of the first state variable, the contact status.
    integer(c_int32_t), parameter, public :: mepc_contact_open = 0       !< open, or never closed
    integer(c_int32_t), parameter, public :: mepc_contact_stick = 1
    integer(c_int32_t), parameter, public :: mepc_contact_micro_slip = 2
    integer(c_int32_t), parameter, public :: mepc_contact_gross_slip = 3

    interface
        !> Version of the interface that the library offers: a program stops where it is not mepc_abi.
        function mepc_abi_version() result(version) bind(c, name="mepc_abi_version")
            import :: c_int32_t
            integer(c_int32_t) :: version
        end function

        !> Makes a law from its properties, in the order of the property table; zero and missing trailing ones take
        !> their defaults. `nstate`: length of the state array of a point, at least 20 (ndir 1) or 24 (ndir 2).
        !> The law belongs to the caller, who gives it back with `mepc_law_free`.
        function mepc_law_new(props, nprops, ndir, nstate, law) result(status) bind(c, name="mepc_law_new")
            import :: c_int32_t, c_double, c_ptr
            integer(c_int32_t), value :: nprops, ndir, nstate
            real(c_double), intent(in) :: props(nprops)
            type(c_ptr), intent(inout) :: law
            integer(c_int32_t) :: status
        end function

        !> Frees a law; c_null_ptr is allowed.
        subroutine mepc_law_free(law) bind(c, name="mepc_law_free")
            import :: c_ptr
            type(c_ptr), value :: law
        end subroutine

        !> Recommended length of the state array for these properties, or a negative status.
        function mepc_state_size(props, nprops, ndir) result(nstate) bind(c, name="mepc_state_size")
            import :: c_int32_t, c_double
            integer(c_int32_t), value :: nprops, ndir
            real(c_double), intent(in) :: props(nprops)
            integer(c_int32_t) :: nstate
        end function

        !> Friction at one point. In: slip increment (ndir), length; pressure at the end of the increment, zero or less is
        !> an open contact; mu_factor (optional), >= 0, multiplies the friction coefficient in this increment; state at the
        !> start, all zeros for a virgin point. Out: state at the end (another array);
        !> traction (ndir); its derivatives: dtraction_dslip(b, a) = d traction(a) / d slip(b), and dtraction_dpressure(ndir);
        !> energy(2): stored at the end, dissipated in the increment.
        function mepc_friction(law, slip_increment, pressure, mu_factor, state0, state1, traction, dtraction_dslip, &
                dtraction_dpressure, energy) result(status) bind(c, name="mepc_friction")
            import :: c_int32_t, c_double, c_ptr
            type(c_ptr), value :: law
            real(c_double), intent(in) :: slip_increment(*)
            real(c_double), value :: pressure
            real(c_double), intent(in), optional :: mu_factor
            real(c_double), intent(in) :: state0(*)
            real(c_double), intent(inout) :: state1(*)
            real(c_double), intent(inout) :: traction(*)
            real(c_double), intent(inout), optional :: dtraction_dslip(*)
            real(c_double), intent(inout), optional :: dtraction_dpressure(*)
            real(c_double), intent(inout), optional :: energy(2)
            integer(c_int32_t) :: status
        end function

        !> Friction and normal contact at one point. In: total opening (1 + ndir), normal first and positive when apart;
        !> mu_factor (optional) as in `mepc_friction`; state at the start. Out: state at the end; traction (1 + ndir), normal first, minus the pressure;
        !> tangent(b, a) = d traction(a) / d opening(b), not symmetric; energy(2): stored at the end by friction
        !> and by the normal penalty, dissipated in the increment.
        function mepc_interface(law, opening, mu_factor, state0, state1, traction, tangent, energy) &
                result(status) bind(c, name="mepc_interface")
            import :: c_int32_t, c_double, c_ptr
            type(c_ptr), value :: law
            real(c_double), intent(in) :: opening(*)
            real(c_double), intent(in), optional :: mu_factor
            real(c_double), intent(in) :: state0(*)
            real(c_double), intent(inout) :: state1(*)
            real(c_double), intent(inout) :: traction(*)
            real(c_double), intent(inout), optional :: tangent(*)
            real(c_double), intent(inout), optional :: energy(2)
            integer(c_int32_t) :: status
        end function

        !> `mepc_friction` for n points, whose arrays follow each other: slip_increment(ndir, n), pressure(n),
        !> mu_factor(n), state0(nstate, n) and so on. statuses(n) holds the status of each point. threads: 1 works in the calling thread,
        !> 0 uses all cores. Returns the worst status: the most negative, else the largest. Points that fail keep their
        !> outputs as they were.
        function mepc_friction_batch(law, n, slip_increment, pressure, mu_factor, state0, state1, traction, &
                dtraction_dslip, dtraction_dpressure, energy, statuses, threads) result(status) bind(c, name="mepc_friction_batch")
            import :: c_int32_t, c_int64_t, c_double, c_ptr
            type(c_ptr), value :: law
            integer(c_int64_t), value :: n
            real(c_double), intent(in) :: slip_increment(*)
            real(c_double), intent(in) :: pressure(*)
            real(c_double), intent(in), optional :: mu_factor(*)
            real(c_double), intent(in) :: state0(*)
            real(c_double), intent(inout) :: state1(*)
            real(c_double), intent(inout) :: traction(*)
            real(c_double), intent(inout), optional :: dtraction_dslip(*)
            real(c_double), intent(inout), optional :: dtraction_dpressure(*)
            real(c_double), intent(inout), optional :: energy(*)
            integer(c_int32_t), intent(inout), optional :: statuses(*)
            integer(c_int32_t), value :: threads
            integer(c_int32_t) :: status
        end function

        !> `mepc_interface` for n points, arrays, statuses and threads as in `mepc_friction_batch`.
        function mepc_interface_batch(law, n, opening, mu_factor, state0, state1, traction, tangent, energy, statuses, &
                threads) result(status) bind(c, name="mepc_interface_batch")
            import :: c_int32_t, c_int64_t, c_double, c_ptr
            type(c_ptr), value :: law
            integer(c_int64_t), value :: n
            real(c_double), intent(in) :: opening(*)
            real(c_double), intent(in), optional :: mu_factor(*)
            real(c_double), intent(in) :: state0(*)
            real(c_double), intent(inout) :: state1(*)
            real(c_double), intent(inout) :: traction(*)
            real(c_double), intent(inout), optional :: tangent(*)
            real(c_double), intent(inout), optional :: energy(*)
            integer(c_int32_t), intent(inout), optional :: statuses(*)
            integer(c_int32_t), value :: threads
            integer(c_int32_t) :: status
        end function

        !> Friction at one point in n increments, one after the other: slip_increment(ndir, n), pressure(n), mu_factor(n),
        !> traction(ndir, n), dtraction_dslip(ndir, ndir, n), dtraction_dpressure(ndir, n), energy(2, n), each as in
        !> `mepc_friction`. state(nstate): at the start on entry, at the end on return. Stops at the first increment that is
        !> refused: state is then the one before it, rows before it are written, later ones are not touched.
        function mepc_friction_history(law, n, slip_increment, pressure, mu_factor, state, traction, dtraction_dslip, &
                dtraction_dpressure, energy) result(status) bind(c, name="mepc_friction_history")
            import :: c_int32_t, c_int64_t, c_double, c_ptr
            type(c_ptr), value :: law
            integer(c_int64_t), value :: n
            real(c_double), intent(in) :: slip_increment(*)
            real(c_double), intent(in) :: pressure(*)
            real(c_double), intent(in), optional :: mu_factor(*)
            real(c_double), intent(inout) :: state(*)
            real(c_double), intent(inout) :: traction(*)
            real(c_double), intent(inout), optional :: dtraction_dslip(*)
            real(c_double), intent(inout), optional :: dtraction_dpressure(*)
            real(c_double), intent(inout), optional :: energy(*)
            integer(c_int32_t) :: status
        end function

        !> `mepc_friction_history` for npoints points, the history of one after that of another: slip_increment(ndir, n,
        !> npoints), state(nstate, npoints) and so on. statuses(npoints), threads and the status as in
        !> `mepc_friction_batch`; a point whose increment is refused stops there, the others go on.
        function mepc_friction_history_batch(law, npoints, n, slip_increment, pressure, mu_factor, state, traction, &
                dtraction_dslip, dtraction_dpressure, energy, statuses, threads) result(status) &
                bind(c, name="mepc_friction_history_batch")
            import :: c_int32_t, c_int64_t, c_double, c_ptr
            type(c_ptr), value :: law
            integer(c_int64_t), value :: npoints, n
            real(c_double), intent(in) :: slip_increment(*)
            real(c_double), intent(in) :: pressure(*)
            real(c_double), intent(in), optional :: mu_factor(*)
            real(c_double), intent(inout) :: state(*)
            real(c_double), intent(inout) :: traction(*)
            real(c_double), intent(inout), optional :: dtraction_dslip(*)
            real(c_double), intent(inout), optional :: dtraction_dpressure(*)
            real(c_double), intent(inout), optional :: energy(*)
            integer(c_int32_t), intent(inout), optional :: statuses(*)
            integer(c_int32_t), value :: threads
            integer(c_int32_t) :: status
        end function

        !> The improved four-parameter Iwan model of a joint: forces of its steady loop between -amplitude and +amplitude.
        !> params: F_s (force at gross slip), X_s (displacement there), k_alpha (residual stiffness), kappa (exponent;
        !> chi = 5/2 + kappa >= 1). branch(n): 1 while the displacement grows, -1 while it falls (integer(c_int8_t)).
        function mepc_iwan_force(params, amplitude, n, displacement, branch, force) result(status) &
                bind(c, name="mepc_iwan_force")
            import :: c_int8_t, c_int32_t, c_int64_t, c_double
            real(c_double), intent(in) :: params(4)
            real(c_double), value :: amplitude
            integer(c_int64_t), value :: n
            real(c_double), intent(in) :: displacement(*)
            integer(c_int8_t), intent(in) :: branch(*)
            real(c_double), intent(inout) :: force(*)
            integer(c_int32_t) :: status
        end function

        !> The same parameters from a measured loop: n displacements and forces in the order of time, cycles of one or of
        !> several amplitudes, with noise. method: 0 least squares, 1 the paper's own procedure. misfit: root mean square
        !> residual over the force at the amplitude. A loop that does not show gross slip is refused (mepc_bad_input);
        !> mepc_not_described: there are outputs, but the model does not describe the loop, mepc_last_error() tells why.
        function mepc_iwan_identify(n, displacement, force, method, params, standard_errors, misfit) result(status) &
                bind(c, name="mepc_iwan_identify")
            import :: c_int32_t, c_int64_t, c_double
            integer(c_int64_t), value :: n
            real(c_double), intent(in) :: displacement(*)
            real(c_double), intent(in) :: force(*)
            integer(c_int32_t), value :: method
            real(c_double), intent(inout) :: params(4)
            real(c_double), intent(inout), optional :: standard_errors(4)
            real(c_double), intent(inout), optional :: misfit
            integer(c_int32_t) :: status
        end function
    end interface

    interface
        !> Friction routine in the shape of Abaqus/Standard's FRIC, one contact point, called when the point is closed.
        !> The properties and state variables are those of the native law; `gcr = 0` takes `fraction * chrlngth`.
        !> Stresses and slips are work-conjugate: a positive increment of slip raises the stress.
        subroutine fric(lm, tau, ddtddg, ddtddp, dslip, sed, sfd, ddtddt, pnewdt, statev, dgam, taulm, press, dpress, &
                ddpddh, slip, kstep, kinc, time, dtime, noel, ciname, slname, msname, npt, node, npatch, coords, &
                rcoord, drot, temp, predef, nfdir, mcrd, npred, nstatv, chrlngth, props, nprops)
            import :: int32, real64
            integer(int32), intent(in) :: nfdir                   !< tangential directions, 1 or 2
            integer(int32), intent(in) :: mcrd                    !< coordinates per node
            integer(int32), intent(in) :: npred                   !< predefined field variables
            integer(int32), intent(in) :: nstatv                  !< state variables
            integer(int32), intent(in) :: nprops                  !< properties
            integer(int32), intent(inout) :: lm                   !< 0 slip or elastic stick, 1 rigid stick, 2 no friction
            real(real64), intent(inout) :: tau(nfdir)             !< frictional stress: at the start, then at the end
            real(real64), intent(inout) :: ddtddg(nfdir, nfdir)   !< (a, b) = d tau(a) / d dgam(b)
            real(real64), intent(inout) :: ddtddp(nfdir)          !< d tau / d press
            real(real64), intent(inout) :: dslip(nfdir)           !< non-elastic slip of the increment
            real(real64), intent(inout) :: sed                    !< stored energy per area
            real(real64), intent(inout) :: sfd                    !< energy per area dissipated in the increment
            real(real64), intent(inout) :: ddtddt(nfdir, 2)       !< d tau / d temperatures, zero
            real(real64), intent(inout) :: pnewdt                 !< made less than 1 to refuse the increment
            real(real64), intent(inout) :: statev(nstatv)         !< state: at the start, then at the end
            real(real64), intent(in) :: dgam(nfdir)               !< slip increment
            real(real64), intent(in) :: taulm(nfdir)              !< stress of the host's Lagrange multiplier
            real(real64), intent(in) :: press                     !< pressure at the end of the increment
            real(real64), intent(in) :: dpress                    !< its increment
            real(real64), intent(in) :: ddpddh                    !< contact stiffness of the host
            real(real64), intent(in) :: slip(nfdir)               !< non-elastic slip at the start
            integer(int32), intent(in) :: kstep                   !< number of the step
            integer(int32), intent(in) :: kinc                    !< number of the increment
            real(real64), intent(in) :: time(2)                   !< step time and total time
            real(real64), intent(in) :: dtime                     !< time increment
            integer(int32), intent(in) :: noel                    !< contact element, 0 for surfaces
            character(len=80), intent(in) :: ciname               !< interaction
            character(len=80), intent(in) :: slname               !< slave surface
            character(len=80), intent(in) :: msname               !< master surface
            integer(int32), intent(in) :: npt                     !< point number
            integer(int32), intent(in) :: node                    !< node number
            integer(int32), intent(in) :: npatch                  !< patch number
            real(real64), intent(in) :: coords(mcrd)              !< where the point is
            real(real64), intent(in) :: rcoord(mcrd)              !< the opposite point
            real(real64), intent(in) :: drot(2, 2)                !< rotation increment of the slip directions
            real(real64), intent(in) :: temp(2)                   !< temperatures of both sides
            real(real64), intent(in) :: predef(2, npred)          !< predefined fields of both sides
            real(real64), intent(in) :: chrlngth                  !< characteristic length of the contact face
            real(real64), intent(in) :: props(nprops)             !< properties
        end subroutine
    end interface

    ! The functions of the C interface that return text; the public ones below turn it into Fortran strings.
    interface
        function c_version() result(text) bind(c, name="mepc_version")
            import :: c_ptr
            type(c_ptr) :: text
        end function

        function c_status_message(status) result(text) bind(c, name="mepc_status_message")
            import :: c_ptr, c_int32_t
            integer(c_int32_t), value :: status
            type(c_ptr) :: text
        end function

        function c_last_error() result(text) bind(c, name="mepc_last_error")
            import :: c_ptr
            type(c_ptr) :: text
        end function

        function c_state_name(law, index) result(text) bind(c, name="mepc_state_name")
            import :: c_ptr, c_int32_t
            type(c_ptr), value :: law
            integer(c_int32_t), value :: index
            type(c_ptr) :: text
        end function

        function c_strlen(text) result(length) bind(c, name="strlen")
            import :: c_ptr, c_size_t
            type(c_ptr), value :: text
            integer(c_size_t) :: length
        end function
    end interface

contains

    !> Version of the library.
    function mepc_version() result(text)
        character(:), allocatable :: text
        text = fortran_string(c_version())
    end function

    !> What a status means.
    function mepc_status_message(status) result(text)
        integer(c_int32_t), intent(in) :: status
        character(:), allocatable :: text
        text = fortran_string(c_status_message(status))
    end function

    !> The last error of this thread in words.
    function mepc_last_error() result(text)
        character(:), allocatable :: text
        text = fortran_string(c_last_error())
    end function

    !> Name of a state variable, index from 0 as in C; empty past the end.
    function mepc_state_name(law, index) result(text)
        type(c_ptr), intent(in) :: law
        integer(c_int32_t), intent(in) :: index
        character(:), allocatable :: text
        text = fortran_string(c_state_name(law, index))
    end function

    !> Copies a C string; empty for a null pointer.
    function fortran_string(text) result(copy)
        type(c_ptr), intent(in) :: text
        character(:), allocatable :: copy
        character(kind=c_char), pointer :: letters(:)
        integer(c_size_t) :: i, length

        length = 0
        if (c_associated(text)) length = c_strlen(text)
        allocate (character(len=length) :: copy)
        if (length == 0) return
        call c_f_pointer(text, letters, [length])
        do i = 1, length
            copy(i:i) = letters(i)
        end do
    end function
end module
